"""A leader module for tests: what its receiver prints, the module in lockstep with a follower, and as a process of its
own."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import tty
from collections.abc import Callable
from pathlib import Path

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire.links import MemoryLink
from companion.io.mavlink.wire.signing import Signing, SigningState
from companion.leader_module.app import LeaderModule, LeaderSurroundings, build_leader
from companion.leader_module.config import parse_leader
from sitl.emulators.nmea import sentence
from sitl.memory import MemoryStream
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions
from tests.copies import Copy
from tests.protocol.driver import Driver
from tests.waiting import ended

FRAME = LocalFrame(57.63, 11.55)  # the RescueRunner's home

CONFIG = """
name = "lead"
system_id = 42
links = ["{link}"]
{more}
[[sensor]]
name = "gnss"
driver = "nmea0183"
port = "{port}"
antennas = 1
rate_hz = 10.0
timeout_s = 1.0
"""


def nmea(
    north_m: float, east_m: float, speed_mps: float, course_deg: float, clock_s: float, *, fix: bool = True
) -> bytes:
    """One epoch of a plain receiver: GGA and RMC."""
    of_day = clock_s % 86400.0
    clock = f"{int(of_day // 3600):02d}{int(of_day // 60) % 60:02d}{of_day % 60.0:05.2f}"
    if not fix:
        return (
            sentence(f"GNGGA,{clock},,,,,0,00,99.9,,M,,M,,") + sentence(f"GNRMC,{clock},V,,,,,,,210626,,,N")
        ).encode()
    lat_deg, lon_deg = FRAME.to_geodetic(north_m, east_m)
    place = f"{int(lat_deg):02d}{lat_deg % 1.0 * 60.0:010.7f},N,{int(lon_deg):03d}{lon_deg % 1.0 * 60.0:010.7f},E"
    gga = f"GNGGA,{clock},{place},1,12,0.8,0.0,M,40.0,M,,"
    return (
        sentence(gga) + sentence(f"GNRMC,{clock},A,{place},{speed_mps * 1.943844:.3f},{course_deg:.2f},210626,,,A")
    ).encode()


class NoDisplay:
    """A terminal that nobody sits at; `press` types."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.said: list[str] = []
        self._typed = ""

    def press(self, keys: str) -> None:
        self._typed += keys

    def fileno(self) -> int | None:
        return None

    def typed(self) -> str:
        typed, self._typed = self._typed, ""
        return typed

    def show(self, line: str, now_s: float) -> None:
        self.lines.append(line)

    def say(self, text: str) -> None:
        self.said.append(text)


class _Streams:
    def __init__(self) -> None:
        self.streams: dict[str, MemoryStream] = {}

    def open(self, name: str, url: str) -> MemoryStream:
        return self.streams.setdefault(name, MemoryStream(name))


class Pair:
    """A RescueRunner and the module on a lead boat, in lockstep at 20 Hz, each with its own links; what goes over the
    air passes `air`.

    `path(t_s)` → (north_m, east_m, speed_mps, course_deg) of the lead boat. `air(t_s, to_follower, data)` → what
    arrives of it.
    """

    def __init__(
        self,
        folder: Path,
        path: Callable[[float], tuple[float, float, float, float]],
        more: str = "thrifty = true",
        keys: tuple[bytes, bytes] | None = None,
    ) -> None:
        """`keys` of the follower and of the module, between which signatures are required; None: nobody asks for
        any."""
        config = load_vessel("rescuerunner")
        world = World(config, WorldConditions(seed=4))
        self.clock = SimulatedClock(EPOCH_UNIX_NS)
        signed = "" if keys is None else "&signing=require"
        self.station, self.lead, self.far = (
            MemoryLink("memory:station"),
            MemoryLink(f"memory:lead?telemetry=leader{signed}"),
            MemoryLink(f"memory:far?telemetry=all{signed}"),
        )
        self.local = MemoryLink("memory:local")
        self.vessel = build(
            config, Surroundings(self.clock, world, world, [self.station, self.lead], None, folder / "follower")
        )
        module_signing = None
        if keys is not None:
            self.lead.guard.signing, module_signing = (
                Signing(self.clock.time_unix_ns, SigningState(key, 0), lambda state: None) for key in keys
            )
        self.world, self.path = world, path
        self.display, self.streams = NoDisplay(), _Streams()
        module_config = parse_leader(CONFIG.format(link="udpout:127.0.0.1:1", port="memory:gnss", more=more), "test")
        around = LeaderSurroundings(
            self.clock,
            self.streams,
            [self.far],
            [self.local],
            self.display,
            folder / "leader",
            signing=module_signing,
        )
        self.module: LeaderModule = build_leader(module_config, around)
        self.air: Callable[[float, bool, bytes], bytes] = lambda t_s, to_follower, data: data
        self.fix = True
        self.bytes_up = self.bytes_down = 0
        self._steps = 0

    @property
    def now_s(self) -> float:
        return self.clock.now_s()

    def step(self) -> None:
        """A twentieth of a second: the receiver speaks, the module tells, the follower hears and answers."""
        now_s = self._steps / 20.0
        self.clock.wait(now_s, ())
        if self._steps % 2 == 0:
            north_m, east_m, speed_mps, course_deg = self.path(now_s)
            data = nmea(north_m, east_m, speed_mps, course_deg, now_s, fix=self.fix)
            self.streams.streams["gnss"].device.send(data, now_s)
        self.module.tick(now_s)
        up = self.far.from_vessel()
        self.bytes_up += len(up)
        self.lead.to_vessel(self.air(now_s, True, up))
        self.vessel.tick(now_s)
        down = self.lead.from_vessel()
        self.bytes_down += len(down)
        self.far.to_vessel(self.air(now_s, False, down))
        self._steps += 1

    def run(self, duration_s: float) -> None:
        for _ in range(round(duration_s * 20)):
            self.step()

    def close(self) -> None:
        self.module.close()
        self.vessel.close()


def along(
    speed_mps: float, course_deg: float, north_m: float = 0.0, east_m: float = 0.0
) -> Callable[[float], tuple[float, float, float, float]]:
    """A straight way."""
    course = math.radians(course_deg)
    return lambda t_s: (
        north_m + speed_mps * t_s * math.cos(course),
        east_m + speed_mps * t_s * math.sin(course),
        speed_mps,
        course_deg,
    )


def circle(t_s: float) -> tuple[float, float, float, float]:
    """60 m of radius at 8 m/s: everything that a module says changes all the time."""
    turned = 8.0 / 60.0 * t_s
    return 30.0 + 60.0 * math.sin(turned), 40.0 + 60.0 * (1.0 - math.cos(turned)), 8.0, math.degrees(turned) % 360.0


class Receiver:
    """A satellite receiver on a pty that speaks at 10 Hz of the driven time, until closed."""

    def __init__(self, path: Callable[[float], tuple[float, float, float, float]], driver: Driver) -> None:
        self._master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(self._master, False)
        self.port, self._slave, self._path = os.ttyname(slave), slave, path
        self._spoken = 0
        driver.between.append(self._speak)

    def _speak(self, now_s: float) -> None:
        while 0.1 * self._spoken <= now_s:
            at_s = 0.1 * self._spoken
            with contextlib.suppress(BlockingIOError):
                os.write(self._master, nmea(*self._path(at_s), at_s))
            self._spoken += 1

    def close(self) -> None:
        os.close(self._master)
        os.close(self._slave)


class LeaderProcess:
    """`companion leader CONFIG`, keys typed through a pipe; its time is the driver's."""

    def __init__(self, folder: Path, link: str, port: str, driver: Driver, more: str = "") -> None:
        folder.mkdir(parents=True, exist_ok=True)
        config = folder / "lead.toml"
        config.write_text(CONFIG.format(link=link, port=f"serial:{port}:115200", more=more), encoding="utf-8")
        self._driver = driver
        self.process = Copy(["leader", str(config), f"--log={folder / 'logs'}", driver.option()])
        self.hello = [self.process.stdout.readline().strip() for _ in range(4)]

    @property
    def rows(self) -> list[dict[str, str]]:
        """Of its log, as far as it has been written."""
        path = Path(self.hello[2].removeprefix("log:").strip()) / "module.csv"
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        return [
            dict(zip(lines[0].split(","), line.split(","), strict=True))
            for line in lines[1:]
            if line.count(",") == lines[0].count(",")
        ]

    def press(self, keys: str) -> None:
        self.process.stdin.write(keys)
        self.process.stdin.flush()

    def stop(self) -> tuple[int, str, str]:
        """Ctrl-C. Returns the exit code and what it said."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self._driver.release()
        out, errors = ended(self.process, "the leader module")
        return self.process.returncode, out, errors
