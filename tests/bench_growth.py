"""`make growth`: how the cost of a tick grows with what the boat has to carry. Writes docs/results/speed/growth.json.

Costs are processor time of the control thread, without the plant, beside that of a reference loop; sizes are measured in
turn, several times, and the least counts: other processes only add to it.
"""

from __future__ import annotations

import argparse
import gc
import json
import math
import random
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.analysis.log_reader import read_table
from companion.app import Surroundings, build, load_vessel
from companion.cli.rig import LockstepRig
from companion.clock import SimulatedClock
from companion.core.geodesy import LocalFrame
from companion.core.tick import Tick
from companion.io.mavlink.wire.links import MemoryLink
from companion.mission.plan import PlanItem, PlanKind
from companion.record.feed import SOCKET
from companion.record.recorder import TICKS, LogFolder
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Conditions
from sitl.traffic import ScriptedVessel
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions
from tests.bench_console import Pages, cpu_s, lateness
from tests.bench_reference import ROOT, measured_at, reference_s
from tests.bench_stopwatches import TimedVessel, time_world
from tests.protocol.process import Companion

FILE = ROOT / "docs" / "results" / "speed" / "growth.json"
_HOLD, _MISSION = 0x03040000, 0x04040000
_ROUNDS = 3
_TICKS = 150


@dataclass(frozen=True, slots=True)
class Axis:
    """One way to grow. `cost(folder, size)`: in the unit of `cost_is`."""

    name: str
    size_is: str
    cost_is: str
    sizes: Sequence[int]
    cost: Callable[[Path, int], float]


class _Ticks:
    """The ticks of a vessel that is advanced by `step`, timed."""

    def __init__(self, boat: Any) -> None:
        self._took_s: list[float] = []
        self._boat = boat
        boat.vessel = TimedVessel(boat.vessel, time_world(boat.vessel), lambda _, took_s: self._took_s.append(took_s))

    def median_ms(self, ticks: int = _TICKS) -> float:
        """Of the next so many ticks."""
        gc.collect()
        gc.freeze()
        self._took_s.clear()
        for _ in range(ticks):
            self._boat.step()
        gc.unfreeze()
        return 1e3 * statistics.median(self._took_s)


def _ready(rig: LockstepRig, mode: int = _HOLD) -> GroundStation:
    station = GroundStation(rig)
    station.ready()
    station.set_mode(mode)
    station.arm()
    station.sail(5.0)
    return station


def _mission(folder: Path, items: int) -> float:
    """In Mission, half-way along the first leg."""
    rig = LockstepRig(Conditions("otter", seed=1, wind="3"), folder)
    frame = LocalFrame(rig.config.home.lat_deg, rig.config.home.lon_deg)
    places = [frame.to_geodetic(200.0 + 20.0 * (k // 2), 20.0 * (k % 2)) for k in range(items)]
    rig.vessel.plans.replace(
        PlanKind.MISSION,
        [
            PlanItem(seq, 16, 3, 0.0, 0.0, 0.0, math.nan, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
            for seq, (lat_deg, lon_deg) in enumerate(places)
        ],
    )
    _ready(rig, _MISSION)
    cost_ms = _Ticks(rig).median_ms()
    rig.close()
    return cost_ms


class _Linked:
    """A boat with so many links, a ground station on each that sends its heartbeat once a second."""

    def __init__(self, folder: Path, links: int) -> None:
        config = load_vessel("otter")
        self._clock, self._links = SimulatedClock(EPOCH_UNIX_NS), [MemoryLink(f"memory:{k}") for k in range(links)]
        world = World(config, WorldConditions(seed=1, wind="3"))
        self.vessel: Any = build(config, Surroundings(self._clock, world, world, self._links, None, folder, False))
        self._wires = [mavlink.MAVLink(None, srcSystem=255 - k, srcComponent=190) for k in range(links)]
        self._steps = 0

    def step(self) -> None:
        """One tick; what the boat says is thrown away."""
        if self._steps % round(1.0 / self.vessel.period_s) == 0:
            for wire, link in zip(self._wires, self._links, strict=True):
                link.to_vessel(wire.heartbeat_encode(6, 8, 0, 0, 4).pack(wire))
        self._clock.wait(self._steps * self.vessel.period_s, ())
        self.vessel.tick(self._clock.now_s())
        self._steps += 1
        for link in self._links:
            link.from_vessel()


def _links(folder: Path, links: int) -> float:
    boat = _Linked(folder, links)
    for _ in range(100):
        boat.step()
    cost_ms = _Ticks(boat).median_ms()
    boat.vessel.close()
    return cost_ms


def _traffic(folder: Path, vessels: int) -> float:
    """On a leg, other vessels within three kilometres that lie or sail at up to 5 m/s."""
    rig = LockstepRig(Conditions("otter", seed=1, wind="3", ais=True), folder)
    draws = random.Random(vessels)
    for number in range(vessels):
        north_m, east_m = (draws.choice((-1, 1)) * draws.uniform(300.0, 2000.0) for _ in range(2))
        course, speed_mps = draws.uniform(-math.pi, math.pi), draws.uniform(0.0, 5.0)
        to = (3600.0, north_m + 3600.0 * speed_mps * math.cos(course), east_m + 3600.0 * speed_mps * math.sin(course))
        rig.world.traffic.vessels.append(ScriptedVessel(2_000_000 + number, f"V{number}", ((0.0, north_m, east_m), to)))
    _ready(rig).sail(20.0)
    cost_ms = _Ticks(rig).median_ms()
    rig.close()
    return cost_ms


def _world(folder: Path, vessels: int) -> float:
    """All that a second of all boats costs, with their plants, in Hold."""
    conditions = Conditions("otter", seed=1, wind="3", gnss_common=0.5)
    rigs = [LockstepRig(conditions, folder / "1")]
    for number in range(2, vessels + 1):
        own = replace(
            conditions, seed=number, start=(30.0 * number, 0.0, 0.0), parameters={"MAV_SYS_ID": float(number)}
        )
        rigs.append(rigs[0].second_vessel(own, f"{number}"))
    started_s, ticks = 0.0, round(20.0 / rigs[0].vessel.period_s)
    for tick in range(ticks):
        if tick == ticks // 2:
            started_s = time.process_time()
        for rig in rigs:
            rig.step()
            rig.receive()
    took_ms = 1e3 * (time.process_time() - started_s) / 10.0
    for rig in rigs:
        rig.close()
    return took_ms


def _browsers(folder: Path, pages: int) -> float:
    """The console's processor time for a tick with so many pages; one of several pages reads nothing."""
    with Companion(folder):
        state = folder / "state"
        command = [sys.executable, "-m", "companion", "console", "--port=0", f"--state={state}"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        url = process.stdout.readline().split()[1].rstrip("/")
        with Pages(url, pages):
            lateness(state / SOCKET, 20)
            before_s = cpu_s(process.pid)
            lateness(state / SOCKET, _TICKS)
            cost_ms = 1e3 * (cpu_s(process.pid) - before_s) / _TICKS
        process.terminate()
        process.wait()
    return cost_ms


class _Sailed:
    """Half a minute of Hold, from which logs of any length are made: its ticks again and again, with later times."""

    def __init__(self, folder: Path) -> None:
        rig = LockstepRig(Conditions("otter", seed=1, wind="3"), folder)
        self._ticks: list[Tick] = []
        rig.vessel.add_recorder(self)
        _ready(rig).sail(30.0)
        rig.close()
        self._thrusters = [row.name for row in rig.config.thrusters]
        self._devices = [*(row.name for row in rig.config.sensors), *(row.name for row in rig.config.actuators)]

    def record(self, tick: Tick) -> None:
        """Keep it."""
        self._ticks.append(tick)

    def close(self) -> None:
        """Nothing is open."""

    def written(self, folder: Path, ticks: int) -> float:
        """What the last hundred ticks of a log of so many cost, ms a tick."""
        log = LogFolder(folder, self._thrusters, self._devices, {})
        for number in range(ticks - 100):
            log.record(self._tick(number))
        last = [self._tick(number) for number in range(ticks - 100, ticks)]
        started_s = time.thread_time()
        for tick in last:
            log.record(tick)
        cost_ms = 1e3 * (time.thread_time() - started_s) / len(last)
        log.close()
        return cost_ms

    def read(self, folder: Path, ticks: int) -> float:
        """What reading the rows of a log of so many costs, ms."""
        self.written(folder, ticks)
        started_s = time.thread_time()
        rows = read_table(folder / TICKS, ("t_s", "north_m", "east_m", "yaw_rad"), [])
        cost_ms = 1e3 * (time.thread_time() - started_s)
        assert len(rows["t_s"]) == ticks
        return cost_ms

    def _tick(self, number: int) -> Tick:
        rounds, at = divmod(number, len(self._ticks))
        tick, by_s = self._ticks[at], rounds * (self._ticks[-1].t_s - self._ticks[0].t_s)
        if rounds == 0:
            return tick
        readings = [replace(reading, t_s=reading.t_s + by_s) for reading in tick.readings]
        return replace(tick, t_s=tick.t_s + by_s, time_unix_ns=tick.time_unix_ns + round(1e9 * by_s), readings=readings)


def axes(folder: Path) -> list[Axis]:
    """All ways to grow. `folder`: for what they share."""
    sailed = _Sailed(folder / "sailed")
    tick = "ms a tick"
    return [
        Axis("Mission", "items", tick, (10, 100, 1000, 10_000), _mission),
        Axis("Links, a station on each", "links", tick, (1, 2, 4, 8, 16), _links),
        Axis("Traffic by AIS", "vessels", tick, (0, 16, 64, 256), _traffic),
        Axis("Vessels in one world", "vessels", "ms a boat second", (1, 2, 5, 10, 20), _world),
        Axis("Pages of the console", "pages", tick, (1, 5, 10, 20), _browsers),
        Axis("Log: writing", "ticks in it", tick, (200, 2000, 20_000), sailed.written),
        Axis("Log: reading all of it", "ticks in it", "ms", (200, 2000, 20_000), sailed.read),
    ]


def measured(axis: Axis, folder: Path) -> dict[str, object]:
    """The axis as the file has it: of each size its cost, and that as a multiple of the reference loop's time."""
    costs: dict[int, list[tuple[float, float]]] = {size: [] for size in axis.sizes}
    for number in range(_ROUNDS):
        for size in axis.sizes:
            cost = axis.cost(folder / f"{axis.name}{number}-{size}", size)
            costs[size].append((cost, cost / (1e3 * reference_s())))
    points = [[size, *(round(least, 4) for least in map(min, zip(*costs[size], strict=True)))] for size in axis.sizes]
    return {"name": axis.name, "size_is": axis.size_is, "cost_is": axis.cost_is, "points": points}


def main() -> None:
    """Measure the axes whose names hold one of the words of the command, or all, and write the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="*", metavar="WORD")
    words = parser.parse_args().words
    before = json.loads(FILE.read_text(encoding="utf-8"))["axes"] if FILE.is_file() else []
    found = {axis["name"]: axis for axis in before}
    with tempfile.TemporaryDirectory() as name:
        for axis in axes(Path(name)):
            if not words or any(word.lower() in axis.name.lower() for word in words):
                found[axis.name] = measured(axis, Path(name)) | measured_at()
                print(axis.name, found[axis.name]["points"], flush=True)
    FILE.write_text(json.dumps({"axes": list(found.values())}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
