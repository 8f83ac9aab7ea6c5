"""`companion sitl`: the simulated boat as a process of its own. Like `cli.py` it composes companion and simulator; nothing below knows both."""

from __future__ import annotations

import argparse
import contextlib
import fcntl
import json
import os
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from companion.app import load_vessel, program_version
from companion.clock import WallClock
from companion.commands.common import Interrupt, UsageError
from companion.commands.folders import fresh
from companion.config import ConfigError, VesselConfig
from companion.io.transport import device_endpoint

if TYPE_CHECKING:
    from sitl.plant_process import Offered, PlantProcess
    from sitl.truth_log import LeaderLog, TruthLog
    from sitl.world import World

_TRUTH_S = 0.05
_LATE_S = 1.0  # by which a plant that cannot keep up is late at least


def add_to(commands: Any) -> None:
    """`commands` as argparse's `add_subparsers` gives it."""
    sitl = commands.add_parser(
        "sitl",
        help="the simulated boat alone, its devices on ports of this machine, for a `companion run --devices` in another process",
        description="While it runs, type a fault's name to have it from now on, or NAME+SECONDS; `depart` sends a lead boat off.",
    )
    sitl.add_argument("vessel", metavar="VESSEL")
    sitl.add_argument("--dir", type=Path, metavar="DIR", help="where its serial ports appear: /dev/NAME as DIR/NAME")
    sitl.add_argument("--speed", type=float, default=1.0, metavar="N", help="N times as fast as the wall clock")
    sitl.add_argument("--seed", type=int, default=0, help="seed of all noise")
    sitl.add_argument("--wind", metavar="MPS@FROM_DEG")
    sitl.add_argument("--current", metavar="MPS@TOWARDS_DEG")
    sitl.add_argument("--fault", action="append", default=[], metavar="NAME@T_S[+DURATION_S]")
    sitl.add_argument("--leader", metavar="SCRIPT[@MPS][+DEPART_S]", help="a lead boat as well, whose wake the boat feels: thesis@8.2+30")
    sitl.add_argument("--leader-link", metavar="URL", help="where the lead boat's module speaks: the follower's own link for it, as udpin:0.0.0.0:14600")
    sitl.add_argument("--log", type=Path, metavar="DIR", help="where a folder with truth.csv is made")
    sitl.add_argument("--duration", type=float, metavar="S", help="end after this long, in the boat's time")
    sitl.set_defaults(command=_sitl)


def _sitl(arguments: argparse.Namespace) -> int:
    from sitl.plant_process import PlantProcess, offered

    if not arguments.speed > 0.0:
        raise UsageError(f"--speed {arguments.speed:g}: above 0, please")
    config = load_vessel(arguments.vessel)
    world = _world(config, arguments)
    folder = (arguments.dir or _usual_folder(config)).resolve()
    urls = {row.name: row.port for row in config.sensors} | {row.name: row.port for row in config.actuators}
    places = {name: device_endpoint(url) for name, url in urls.items()}
    interrupt = Interrupt()
    with _alone_in(folder):
        devices = offered(world, config, places, folder)
        if arguments.leader_link is not None:
            devices = (*devices, _leader(world, arguments, folder))
            urls["leader"] = arguments.leader_link
        plant = PlantProcess(world, devices)
        print(f"USV companion {program_version()}: the plant of {config.title}, {arguments.speed:g} times real time")
        for device in devices:
            print(f"  {device.name:16} {urls[device.name]:36} {device.end.shown}")
        truths = _truth_logs(config, world, arguments)
        speed = "" if arguments.speed == 1.0 else f" --speed {arguments.speed:g}"
        print(f"for: companion run {arguments.vessel} --devices {folder}{speed}", flush=True)
        try:
            _serve(plant, WallClock(arguments.speed), truths, interrupt, arguments.duration)
        finally:
            plant.close()
            for truth in truths:
                truth.close()
    return 0


def _world(config: VesselConfig, arguments: argparse.Namespace) -> World:
    from sitl.plant_process import leader
    from sitl.waters import waters_of
    from sitl.world import World

    waters = None
    if arguments.leader is not None:
        waters = waters_of([leader(arguments.leader, config.home.yaw_rad)], config.home, arguments.seed)
    return World(
        config,
        seed=arguments.seed,
        wind=arguments.wind,
        current=arguments.current,
        faults=tuple(arguments.fault),
        epoch_unix_ns=time.time_ns(),
        waters=waters,
    )


def _leader(world: World, arguments: argparse.Namespace, folder: Path) -> Offered:
    """The module on the lead boat, at the far end of the follower's link."""
    from sitl.far_ends import far_end
    from sitl.leader_radio import LeaderModule, LeaderPort
    from sitl.plant_process import Offered

    if world.waters is None:
        raise UsageError("--leader-link needs a lead boat: --leader thesis@8.2")
    module = LeaderModule(world.waters.boats[0], seed=arguments.seed)
    port = Offered("leader", LeaderPort("leader", module), far_end(device_endpoint(arguments.leader_link), folder))
    port.end.plug()
    return port


def _usual_folder(config: VesselConfig) -> Path:
    return Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()) / f"usv-sitl-{config.name}"


@contextlib.contextmanager
def _alone_in(folder: Path) -> Any:
    """One plant in a folder: two would take each other's ports away."""
    folder.mkdir(parents=True, exist_ok=True)
    lock: IO[str] = (folder / ".lock").open("w", encoding="utf-8")
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise UsageError(f"{folder}: another `companion sitl` has its devices there; choose another --dir") from error
        yield


def _truth_logs(config: VesselConfig, world: World, arguments: argparse.Namespace) -> list[TruthLog | LeaderLog]:
    """truth.csv and the lead boat's leader.csv, where asked for; beside them the time at which its own begins, so that it can be laid beside the companion's log."""
    if arguments.log is None:
        return []
    from sitl.truth_log import LeaderLog, TruthLog

    folder = fresh(arguments.log, f"{config.name}-plant-{time.strftime('%Y%m%d-%H%M%S')}")
    truths: list[TruthLog | LeaderLog] = [TruthLog(folder, world, tuple(thruster.name for thruster in config.thrusters))]
    truths += [LeaderLog(folder, boat, config.home) for boat in (world.waters.boats if world.waters is not None else ())]
    about = {"vessel": config.name, "seed": arguments.seed, "speed": arguments.speed, "started_unix_ns": time.time_ns(), "command": " ".join(sys.argv)}
    (folder / "manifest.json").write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
    print(f"log:   {folder}")
    return truths


def _serve(plant: PlantProcess, clock: WallClock, truths: Sequence[TruthLog | LeaderLog], interrupt: Interrupt, duration_s: float | None) -> None:
    console = _Console()
    step_s, next_s, truth_s, late = plant.world.step_s, 0.0, 0.0, False
    while not interrupt.asked and (duration_s is None or clock.now_s() < duration_s):
        while clock.wait(next_s, console.filenos):
            for line in console.lines():
                _obey(plant, line)
        now_s = clock.now_s()
        plant.advance(now_s)
        if now_s >= truth_s:
            truth_s = now_s + _TRUTH_S
            for truth in truths:
                truth.write()
        next_s = max(next_s + step_s, now_s)
        if not late and clock.now_s() - now_s > _LATE_S:
            late = True
            print("this machine cannot keep up with that; a lower --speed, please", file=sys.stderr, flush=True)


def _obey(plant: PlantProcess, line: str) -> None:
    try:
        print(plant.obey(line), flush=True)
    except ConfigError as error:
        print(error, file=sys.stderr, flush=True)


class _Console:
    """What is typed, line by line, where there is anybody to type."""

    def __init__(self) -> None:
        self.filenos: Sequence[int] = (0,)
        self._rest = b""
        signal.signal(signal.SIGTTIN, signal.SIG_IGN)  # in the background: nobody types

    def lines(self) -> list[str]:
        try:
            data = os.read(0, 4096)
        except OSError:
            data = b""
        if not data:
            self.filenos = ()
        *lines, self._rest = (self._rest + data).split(b"\n")
        return [text for line in lines if (text := line.decode("utf-8", "replace").strip())]
