"""`companion sitl VESSEL`: the simulated boat alone, in a process of its own."""

from __future__ import annotations

import argparse
import contextlib
import fcntl
import json
import os
import select
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from companion.app import load_vessel, program_version
from companion.cli.common import (
    Interrupt,
    UsageError,
    add_clock_to,
    driven_clock,
    is_over,
    judge_log_folder,
    judge_time,
    new_folder,
    no_log,
    no_ports,
    typed,
)
from companion.cli.composition import WhileThereIsSpace
from companion.cli.physics import parse_physics, serve_physics
from companion.clock import WallClock
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.ports import WaitingClock
from companion.io.transport.opener import device_endpoint

if TYPE_CHECKING:
    from sitl.plant_process import PlantProcess, ServedDevice
    from sitl.world import World

_TRUTH_S = 0.05
_LATE_S = 1.0  # a step that takes longer means that the machine is too slow


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    sitl = commands.add_parser(
        "sitl",
        help="the simulated boat alone, its devices on ports of this machine, for `companion run --devices`",
        description="While it runs, type a fault's name, or NAME+SECONDS, to start that fault now. "
        "`depart` starts the lead boat.",
    )
    sitl.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
    sitl.add_argument("--dir", type=Path, metavar="DIR", help="folder of its serial ports: /dev/NAME is DIR/NAME")
    sitl.add_argument("--speed", type=float, default=1.0, metavar="N", help="N times as fast as the wall clock")
    sitl.add_argument("--seed", type=int, default=0, help="seed of all noise")
    sitl.add_argument("--wind", metavar="MPS@FROM_DEG")
    sitl.add_argument("--current", metavar="MPS@TOWARDS_DEG")
    sitl.add_argument("--waves", metavar="HS[@FROM_DEG][/TP_S]", help="sea state: height, direction, peak period")
    sitl.add_argument("--water", metavar="KIND", help="usual, or rough: all that water, wind and sensors do to a boat")
    sitl.add_argument("--plant", metavar="NAME", help="another of the vessel's simulated hulls, `[sitl.plants.NAME]`")
    sitl.add_argument("--fault", action="append", default=[], metavar="NAME[:DEVICE][=SIZE]@T_S[+DURATION_S]")
    sitl.add_argument(
        "--leader",
        metavar="SCRIPT[@MPS][+DEPART_S]",
        help="add a lead boat, whose wake the boat feels: thesis@8.2+30",
    )
    sitl.add_argument(
        "--leader-link",
        metavar="URL",
        help="the follower's link on which the lead boat's module sends, as udpin:0.0.0.0:14600",
    )
    sitl.add_argument("--log", type=Path, metavar="DIR", help="folder in which a folder with truth.csv is made")
    sitl.add_argument("--duration", type=float, metavar="S", help="end after this long, in the boat's time")
    sitl.add_argument(
        "--physics",
        metavar="json:PORT",
        help="serve ArduPilot's JSON simulation interface in place of devices, in lockstep: "
        "ArduRover with --model JSON:127.0.0.1",
    )
    sitl.add_argument(
        "--outputs",
        default="",
        metavar="NAME=CH,…",
        help="servo channels of the thrusters for --physics: port=1,starboard=3, or stern=1/2 for throttle and azimuth",
    )
    add_clock_to(sitl)
    sitl.set_defaults(command=_sitl)


def _sitl(arguments: argparse.Namespace) -> int:
    from sitl.plant_process import PlantProcess, serve_devices

    judge_time(arguments.speed, arguments.duration)
    config = load_vessel(arguments.vessel)
    if arguments.log is not None:
        judge_log_folder(arguments.log)
    if arguments.physics is not None:
        return _physics(config, arguments)
    world = _world(config, arguments)
    folder = (arguments.dir or _default_folder(config)).resolve()
    urls = {row.name: row.port for row in config.sensors} | {row.name: row.port for row in config.actuators}
    addresses = {name: device_endpoint(url) for name, url in urls.items()}
    interrupt = Interrupt()
    with _locked(folder):
        devices = serve_devices(world, config, addresses, folder)
        if arguments.leader_link is not None:
            devices = (*devices, _leader_module(world, arguments, folder))
            urls["leader"] = arguments.leader_link
        plant = PlantProcess(world, devices)
        print(f"USV companion {program_version()}: the plant of {config.title}, {arguments.speed:g} times real time")
        for device in devices:
            print(f"  {device.name:16} {urls[device.name]:36} {device.port.shown}")
        truths = _truth_logs(config, world, arguments)
        speed = "" if arguments.speed == 1.0 else f" --speed {arguments.speed:g}"
        print(f"for: {typed('run', arguments.vessel, '--devices', folder)}{speed}", flush=True)
        try:
            driven = driven_clock(arguments.clock, time.time_ns()) if arguments.clock else None
            _simulate(plant, driven or WallClock(arguments.speed), truths, interrupt, arguments.duration)
        finally:
            plant.close()
            for truth in truths:
                truth.close()
    return 0


def _physics(config: VesselConfig, arguments: argparse.Namespace) -> int:
    """The plant for another autopilot."""
    from sitl.json_physics import JsonPhysics, parse_outputs, without_boards
    from sitl.plant_process import PlantProcess

    address = parse_physics(arguments.physics)
    outputs = parse_outputs(arguments.outputs, config)
    world = _world(without_boards(config), arguments)
    physics, console = JsonPhysics(world, config, outputs), _Console()
    plant = PlantProcess(world, ())

    def obeyed() -> Sequence[int]:
        if console.filenos and select.select(console.filenos, [], [], 0.0)[0]:
            for line in console.lines():
                _obey(plant, line)
        return console.filenos

    print(f"USV companion {program_version()}: the plant of {config.title} by JSON on {address[0]}:{address[1]}")
    for name, channels in outputs.items():
        azimuth = "" if channels.azimuth is None else f", azimuth on {channels.azimuth}"
        print(f"  {name:16} throttle on channel {channels.throttle}{azimuth}")
    truths = _truth_logs(config, world, arguments)
    print(f"for: ardurover --model JSON:{address[0]}, SIM_RATE_HZ 100", flush=True)
    try:
        serve_physics(physics, address, lambda: _write(truths), obeyed, Interrupt(), arguments.duration)
    finally:
        for truth in truths:
            truth.close()
    return 0


def _write(truths: Sequence[WhileThereIsSpace]) -> None:
    for truth in truths:
        truth.write()


def _world(config: VesselConfig, arguments: argparse.Namespace) -> World:
    from sitl.plant_process import parse_leader
    from sitl.shared_sea import build_shared_sea
    from sitl.world import World, WorldConditions

    shared_sea = None
    if arguments.leader is not None:
        leader = parse_leader(arguments.leader, config.home.yaw_rad)
        shared_sea = build_shared_sea([leader], config.home, arguments.seed)
    conditions = WorldConditions(
        seed=arguments.seed,
        wind=arguments.wind,
        current=arguments.current,
        waves=arguments.waves,
        water=arguments.water,
        plant=arguments.plant,
        faults=tuple(arguments.fault),
        epoch_unix_ns=time.time_ns(),
    )
    return World(config, conditions, shared_sea)


def _leader_module(world: World, arguments: argparse.Namespace, folder: Path) -> ServedDevice:
    """The module on the lead boat, at the other end of the follower's link."""
    from sitl.device_ports import device_port
    from sitl.leader_radio import EmulatedLeaderModule, LeaderPort
    from sitl.plant_process import ServedDevice

    if world.shared_sea is None:
        raise UsageError("--leader-link needs a lead boat: --leader thesis@8.2")
    module = EmulatedLeaderModule(world.shared_sea.boats[0], seed=arguments.seed)
    port = device_port(device_endpoint(arguments.leader_link), folder)
    port.plug()
    return ServedDevice("leader", LeaderPort("leader", module), port)


def _default_folder(config: VesselConfig) -> Path:
    return Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()) / f"usv-sitl-{config.name}"


@contextlib.contextmanager
def _locked(folder: Path) -> Any:
    """Lock a folder for one simulated boat: two would replace each other's ports."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock: IO[str] = (folder / ".lock").open("w", encoding="utf-8")
    except OSError as error:
        raise no_ports(folder, error) from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise UsageError(f"{folder}: another `companion sitl` uses it; choose another --dir") from error
        yield


def _truth_logs(config: VesselConfig, world: World, arguments: argparse.Namespace) -> list[WhileThereIsSpace]:
    """truth.csv, the lead boat's leader.csv and the cameras' pictures.csv, where `--log` asks for them.

    The manifest beside them holds the time at which theirs begins, so that they can be compared with the companion's
    log. Raises UsageError where they cannot be written.
    """
    if arguments.log is None:
        return []
    folder = new_folder(arguments.log, f"{config.name}-plant-{time.strftime('%Y%m%d-%H%M%S')}")
    try:
        truths = _truths_in(folder, config, world)
        _describe(folder, config, arguments)
    except OSError as error:
        raise no_log(folder, error) from error
    print(f"log:   {folder}")
    return truths


def _truths_in(folder: Path, config: VesselConfig, world: World) -> list[WhileThereIsSpace]:
    from sitl.camera import PictureLog
    from sitl.truth_log import LeaderTruthLog, TruthLog

    names = tuple(thruster.name for thruster in config.thrusters)
    truths = [WhileThereIsSpace(TruthLog(folder, world, names), "truth.csv")]
    for boat in () if world.shared_sea is None else world.shared_sea.boats:
        truths.append(WhileThereIsSpace(LeaderTruthLog(folder, boat, config.home), f"{boat.name}.csv"))
    return truths + ([WhileThereIsSpace(PictureLog(folder, world.cameras), "pictures.csv")] if world.cameras else [])


def _describe(folder: Path, config: VesselConfig, arguments: argparse.Namespace) -> None:
    about = {
        "vessel": config.name,
        "seed": arguments.seed,
        "speed": arguments.speed,
        "started_unix_ns": time.time_ns(),
        "command": " ".join(sys.argv),
    }
    (folder / "manifest.json").write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")


def _simulate(
    plant: PlantProcess,
    clock: WaitingClock,
    truths: Sequence[WhileThereIsSpace],
    interrupt: Interrupt,
    duration_s: float | None,
) -> None:
    console = _Console()
    step_s, next_s, truth_s, late = plant.world.step_s, 0.0, 0.0, False
    while not (interrupt.received or is_over(clock, duration_s)):
        while clock.wait(next_s, console.filenos):
            for line in console.lines():
                _obey(plant, line)
        now_s = clock.now_s()
        plant.advance(now_s)
        if now_s >= truth_s:
            truth_s = now_s + _TRUTH_S
            _write(truths)
        next_s = max(next_s + step_s, now_s)
        if not late and clock.now_s() - now_s > _LATE_S:
            late = True
            print("this machine is too slow for that speed; choose a lower --speed", file=sys.stderr, flush=True)


def _obey(plant: PlantProcess, line: str) -> None:
    try:
        print(plant.obey(line), flush=True)
    except ConfigError as error:
        print(error, file=sys.stderr, flush=True)


class _Console:
    """Standard input, line by line; nothing where it has ended or the process runs in the background."""

    def __init__(self) -> None:
        self.filenos: Sequence[int] = (0,)
        self._rest = b""
        signal.signal(
            signal.SIGTTIN, signal.SIG_IGN
        )  # reading in the background then fails instead of stopping the process

    def lines(self) -> list[str]:
        """The complete lines that have arrived, without blank ones."""
        try:
            data = os.read(0, 4096)
        except OSError:
            data = b""
        if not data:
            self.filenos = ()
        *lines, self._rest = (self._rest + data).split(b"\n")
        return [text for line in lines if (text := line.decode("utf-8", "replace").strip())]
