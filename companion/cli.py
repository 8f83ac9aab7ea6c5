"""The commands. Also where the companion and the simulator are composed: nothing else knows both."""

from __future__ import annotations

import argparse
import gc
import os
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from companion import config as config_module
from companion.app import Surroundings, build, load_vessel, program_version, warm_up
from companion.cli_sitl import add_to as add_sitl_to
from companion.clock import PacedClock, SimulatedClock, WallClock
from companion.commands import bollard, devices, leader, logs, missions, report, service, signing, thruster_test
from companion.commands.common import Interrupt, UsageError
from companion.commands.folders import fresh, kept_in
from companion.config import ConfigError, HomeConfig, SensorConfig, VesselConfig
from companion.io.mavlink.links import LinkError, MemoryLink, open_links
from companion.io.service_manager import service_manager
from companion.io.transport import TransportOpener
from companion.io.urls import TransportError
from companion.loop import RealWorld, Vessel, run
from companion.mission.plan_file import PlanFileError
from companion.record.log_reader import LogError, open_log
from companion.record.retention import Retention
from companion.record.state_file import StateFile, StateFileBusy

if TYPE_CHECKING:
    from sitl.scenarios.rig import Believed, Conditions
    from sitl.waters import Waters
    from sitl.world import World

_SITL_LINKS = ("udpout:127.0.0.1:14550", "tcpin:127.0.0.1:5760")


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command. Returns its exit code: 0 well, 1 a check that failed, 2 a mistake in what was asked."""
    arguments = _parser().parse_args(argv)
    try:
        code: int = arguments.command(arguments)
        return code
    except (ConfigError, PlanFileError) as error:
        for problem in error.problems:
            print(problem, file=sys.stderr)
    except (UsageError, LinkError, LogError, TransportError, StateFileBusy, service.ServiceError, thruster_test.TrialError) as error:
        print(f"companion: {error}", file=sys.stderr)
    except OSError as error:
        print(f"companion: {error.filename or 'the system'}: {error.strerror or error}", file=sys.stderr)
    return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="companion", description="Autopilot for small uncrewed boats, flown by any MAVLink ground station.")
    parser.add_argument("--version", action="version", version=f"USV companion {program_version()}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    run_ = commands.add_parser("run", help="run a vessel, real or simulated")
    run_.add_argument("vessel", metavar="VESSEL", help=f"a bundled name ({', '.join(config_module.bundled())}) or a TOML file")
    run_.add_argument("--sitl", action="store_true", help="with the simulated boat in place of its devices")
    run_.add_argument("--devices", type=Path, metavar="DIR", help="with the devices of a `companion sitl`: /dev/NAME is DIR/NAME")
    run_.add_argument("--speed", type=float, default=1.0, metavar="N", help="with --sitl or --devices: N times as fast as the wall clock")
    run_.add_argument("--link", action="append", metavar="URL", help="replaces the vessel's links; udpout:, udpin:, tcpin:, tcpout:, serial:")
    run_.add_argument("--home", metavar="LAT,LON,HEADING_DEG", help="replaces the vessel's home")
    run_.add_argument("--state", type=Path, metavar="DIR", help="where parameters and plans are kept")
    run_.add_argument("--log", type=Path, metavar="DIR", help="where the log folder is made")
    run_.add_argument("--log-limit", type=int, metavar="MB", help="delete the oldest log folders there while all hold more")
    run_.add_argument("--seed", type=int, default=0, help="with --sitl: seed of all noise")
    run_.add_argument("--wind", metavar="MPS@FROM_DEG", help="with --sitl")
    run_.add_argument("--current", metavar="MPS@TOWARDS_DEG", help="with --sitl")
    run_.add_argument("--fault", action="append", default=[], metavar="NAME@T_S[+DURATION_S]", help="with --sitl")
    run_.add_argument("--duration", type=float, metavar="S", help="end after this long, in the boat's time")
    run_.set_defaults(command=_run)

    check = commands.add_parser("check", help="every error of a vessel's file at once, with its place")
    check.add_argument("vessel", metavar="VESSEL")
    check.add_argument("--listen", action="store_true", help="and whether its serial devices are what it says; nothing is written to any")
    check.set_defaults(command=_check)

    add_sitl_to(commands)
    devices.add_to(commands)
    missions.add_to(commands)

    scenario = commands.add_parser("scenario", help="sail a named scenario in lockstep and check it")
    verbs = scenario.add_subparsers(required=True, metavar="list | run | table")
    verbs.add_parser("list", help="the scenarios and their settings").set_defaults(command=_scenario_list)
    sail = verbs.add_parser("run", help="sail one")
    sail.add_argument("name", metavar="NAME")
    sail.add_argument("--vessel", metavar="V")
    sail.add_argument("--seed", type=int, default=0)
    sail.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")
    sail.add_argument("--out", type=Path, metavar="DIR", help="folder of the log and result.json")
    sail.set_defaults(command=_scenario_run)
    table = verbs.add_parser("table", help="the thesis's law beside the companion's, on the same seeds; takes a while")
    table.add_argument("name", metavar="NAME", choices=["four_corner", "route"])
    table.add_argument("--seeds", type=int, default=8, metavar="N")
    table.set_defaults(command=_scenario_table)

    leader.add_to(commands)
    logs.add_to(commands)
    report.add_to(commands)
    service.add_to(commands)
    signing.add_to(commands)
    bollard.add_to(commands)
    thruster_test.add_to(commands, _thruster_test)
    return parser


# --- run -----------------------------------------------------------------------------------------------------------


def _run(arguments: argparse.Namespace) -> int:
    if arguments.duration is not None and not arguments.duration > 0.0:
        raise UsageError(f"--duration {arguments.duration:g}: above 0, please")
    if arguments.log_limit is not None and arguments.log_limit < 1:
        raise UsageError(f"--log-limit {arguments.log_limit}: at least 1 MB, please")
    config = load_vessel(arguments.vessel)
    if arguments.home:
        config = config_module.with_home(config, _home(arguments.home))
    kept = _kept_in(config, arguments.sitl or arguments.devices is not None)
    stamp = time.strftime("%Y%m%d-%H%M%S")
    logs_kept = kept / "logs" if arguments.log is None else arguments.log
    log_folder = fresh(logs_kept, f"{config.name}-{stamp}")
    state = StateFile(kept / "state" if arguments.state is None else arguments.state)
    vessel, clock = _compose_run(config, arguments, state, log_folder)
    manager = service_manager(os.environ)
    if manager is not None:
        vessel.add_recorder(manager)
    retention = None
    if arguments.log_limit is not None:
        retention = Retention(logs_kept, arguments.log_limit * 1_000_000, log_folder, lambda text: print(f"companion: {text}", file=sys.stderr))
    stop = _Stop(clock, vessel, arguments.duration)
    _say_hello(config, arguments, state, log_folder)
    gc.collect()
    gc.freeze()
    loading = threading.Thread(target=warm_up, name="warm-up")
    loading.start()
    try:
        punctuality = run(vessel, clock, stop)
    finally:
        loading.join()
        vessel.close()
        state.close()
        if retention is not None:
            retention.close()
    if not arguments.sitl:
        print(punctuality.text, flush=True)
    if vessel.restart_requested:
        os.execv(sys.executable, [sys.executable, "-m", "companion", *sys.argv[1:]])
    return 0


def _compose_run(
    config: VesselConfig, arguments: argparse.Namespace, state: StateFile, log_folder: Path
) -> tuple[Vessel, WallClock | PacedClock]:
    urls = arguments.link or (_SITL_LINKS if arguments.sitl else config.links)
    manifest = {"command": " ".join(sys.argv), "seed": arguments.seed if arguments.sitl else None}
    simulated = arguments.sitl or arguments.devices is not None
    if not arguments.sitl:
        for flag in ("wind", "current", "fault"):
            if getattr(arguments, flag):
                raise UsageError(f"--{flag} {'belongs to `companion sitl`' if simulated else 'needs --sitl: a real boat brings its own'}")
    elif arguments.devices is not None:
        raise UsageError("--sitl has its own devices: leave out --devices, or --sitl for those of a `companion sitl`")
    if not arguments.speed > 0.0 or not (simulated or arguments.speed == 1.0):
        raise UsageError(f"--speed {arguments.speed:g}: {'above 0, please' if simulated else 'needs --sitl or --devices: real time is what it is'}")
    # people and ground stations live in wall time: what they may take must not shrink as the boat's time speeds up
    patience = max(1.0, arguments.speed)
    usual = {"COM_DL_LOSS_T": (10.0, 300.0), "COM_RC_LOSS_T": (0.5, 10.0), "FOLL_LOSS_T": (0.9, 10.0), "OFFB_TIMEOUT": (0.8, 60.0)}
    defaults = {name: min(most_s, usual_s * patience) for name, (usual_s, most_s) in usual.items()} if patience > 1.0 else {}
    if not arguments.sitl:
        wall = WallClock(arguments.speed)
        opener = TransportOpener(arguments.devices)
        links = open_links(urls, patience)
        around = Surroundings(wall, opener, RealWorld(), links, state, log_folder, True, manifest, defaults, patience, network=opener)
        return build(config, around), wall
    from sitl.truth_log import TruthLog
    from sitl.world import EPOCH_UNIX_NS, World

    world = World(config, seed=arguments.seed, wind=arguments.wind, current=arguments.current, faults=tuple(arguments.fault))
    paced = PacedClock(arguments.speed, EPOCH_UNIX_NS)
    links = open_links(urls, patience)
    network = TransportOpener()
    around = Surroundings(
        paced, world, world, links, state, log_folder, True, manifest, defaults, patience, stations_time_unix_ns=time.time_ns, network=network
    )
    vessel = build(config, around)
    vessel.add_recorder(TruthLog(log_folder, world, tuple(thruster.name for thruster in config.thrusters)))
    return vessel, paced


def _home(text: str) -> HomeConfig:
    import math

    try:
        lat_deg, lon_deg, *heading_deg = (float(part) for part in text.split(","))
    except ValueError as error:
        raise UsageError(f"--home {text}: write LAT,LON,HEADING_DEG, as 63.4389,10.3990,0") from error
    if not (-89.0 <= lat_deg <= 89.0 and -180.0 <= lon_deg <= 180.0 and len(heading_deg) <= 1 and all(map(math.isfinite, heading_deg))):
        raise UsageError(f"--home {text}: no such place; write LAT,LON,HEADING_DEG")
    return HomeConfig(lat_deg, lon_deg, math.radians(heading_deg[0]) if heading_deg else 0.0)


def _kept_in(config: VesselConfig, simulated: bool) -> Path:
    """Where this vessel's things are kept, apart from those of its simulation."""
    return kept_in(f"{config.name}-sitl" if simulated else config.name)


def _say_hello(config: VesselConfig, arguments: argparse.Namespace, state: StateFile, log_folder: Path) -> None:
    how = f"simulated, {arguments.speed:g} times real time" if arguments.sitl else "on its own devices"
    if arguments.devices is not None:
        how = f"on simulated devices in {arguments.devices}, {arguments.speed:g} times real time"
    links = ", ".join(arguments.link or (_SITL_LINKS if arguments.sitl else config.links))
    print(f"USV companion {program_version()}: {config.title}, {how}")
    print(f"links: {links}")
    print(f"state: {state.directory}")
    print(f"log:   {log_folder}", flush=True)


class _Stop:
    """Whether the run should end: Ctrl-C, SIGTERM, the duration, a restart asked for."""

    def __init__(self, clock: WallClock | PacedClock, vessel: Vessel, duration_s: float | None) -> None:
        self._clock, self._vessel, self._duration_s = clock, vessel, duration_s
        self._interrupt = Interrupt()

    def __call__(self) -> bool:
        over = self._duration_s is not None and self._clock.now_s() >= self._duration_s
        return self._interrupt.asked or over or self._vessel.restart_requested


# --- thruster-test ------------------------------------------------------------------------------------------------


def _thruster_test(arguments: argparse.Namespace) -> int:
    config = load_vessel(arguments.vessel)
    state = StateFile(_kept_in(config, arguments.sitl) / "state")  # locks: a companion that runs this vessel would fight for its thrusters
    try:
        if arguments.sitl:
            from sitl.world import EPOCH_UNIX_NS, World

            world = World(config)
            return thruster_test.run_test(config, world, world, PacedClock(1.0, EPOCH_UNIX_NS), arguments)
        return thruster_test.run_test(config, TransportOpener(), RealWorld(), WallClock(), arguments)
    finally:
        state.close()


# --- check ---------------------------------------------------------------------------------------------------------


def _check(arguments: argparse.Namespace) -> int:
    config = load_vessel(arguments.vessel)
    print(f"{config.name}: {config.title}: no errors", flush=True)
    judged = devices.listen_to(config, 3.0) if arguments.listen else []
    for _, text in judged:
        print(text)
    return 0 if all(well for well, _ in judged) else 1


# --- scenario ------------------------------------------------------------------------------------------------------


class LockstepRig:
    """A composed vessel in lockstep, with a memory link whose far end the scenario holds."""

    def __init__(self, conditions: Conditions, folder: Path, waters: Waters | None = None) -> None:
        """`waters`: those of another rig; None: as the conditions say."""
        from sitl.plant_error import with_plant_error
        from sitl.truth_log import LeaderLog, TruthLog
        from sitl.waters import waters_of
        from sitl.world import EPOCH_UNIX_NS, World

        self.config = load_vessel(conditions.vessel)
        for name in conditions.rotating:
            self.config = config_module.with_rotating(self.config, name)
        if conditions.wind_sensor:
            wind = SensorConfig(name="wind", driver="nmea0183", port="memory:wind", rate_hz=5.0)
            self.config = replace(self.config, sensors=(*self.config.sensors, wind))
        if conditions.magnetometer:
            from sitl.magnetometer import with_magnetometer

            self.config = with_magnetometer(self.config)
        if conditions.ais:
            ais = SensorConfig(name="ais", driver="ais", port="memory:ais", rate_hz=5.0)
            self.config = replace(self.config, sensors=(*self.config.sensors, ais))
        self.conditions: Conditions = conditions
        self._folder = folder
        believed = _believed(self.config, conditions)
        if waters is None and (conditions.others or conditions.gnss_common):
            waters = waters_of(conditions.others, self.config.home, conditions.seed, conditions.gnss_common)
        real = with_plant_error(self.config, conditions.plant, conditions.plant_error, conditions.seed) if conditions.plant_error else self.config
        self.world: World = World(
            real,
            seed=conditions.seed,
            wind=conditions.wind,
            current=conditions.current,
            gnss=conditions.gnss,
            plant=conditions.plant,
            waves_m=conditions.waves_m,
            push_ned_n=conditions.push_ned_n,
            faults=conditions.faults,
            tow=conditions.tow,
            waters=waters,
        )
        if conditions.start is not None:
            self.world.set_state(*conditions.start)
        self._clock = SimulatedClock(EPOCH_UNIX_NS)
        self._link = MemoryLink("memory:scenario")
        manifest = {"seed": conditions.seed, "conditions": repr(conditions)}
        around = Surroundings(
            self._clock, self.world, self.world, [self._link], None, folder, False, manifest, conditions.parameters
        )
        self.vessel = build(believed, around)
        self.vessel.add_recorder(TruthLog(folder, self.world, tuple(thruster.name for thruster in self.config.thrusters)))
        for boat in () if self.world.waters is None else self.world.waters.boats:
            self.vessel.add_recorder(LeaderLog(folder, boat, self.config.home))
        self._steps = 0
        self._closed = False

    @property
    def now_s(self) -> float:
        return self._clock.now_s()

    def step(self) -> None:
        self._clock.wait(self._steps * self.vessel.period_s, ())
        self.vessel.tick(self._clock.now_s())
        self._steps += 1

    def send(self, data: bytes) -> None:
        self._link.to_vessel(data)

    def hear(self, data: bytes, at_s: float) -> None:
        self._clock.wait(max(at_s, self._clock.now_s()), ())
        self._link.to_vessel(data)
        self.vessel.serve(self._clock.now_s())

    def receive(self) -> bytes:
        return self._link.from_vessel()

    def identify(self) -> Believed:
        from companion.record.identify import identify
        from sitl.scenarios.rig import Believed

        self.close()
        fit = identify(open_log(self._folder), out=self._folder).fit
        return Believed(fit.hull, fit.thrusters)

    def again(self, believed: Believed, folder: str) -> LockstepRig:
        return LockstepRig(replace(self.conditions, hull=believed), self._folder / folder)

    def beside(self, conditions: Conditions, folder: str) -> LockstepRig:
        return LockstepRig(conditions, self._folder / folder, self.world.waters)

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self.vessel.close()


def _believed(config: VesselConfig, conditions: Conditions) -> VesselConfig:
    """The vessel as its controller knows it."""
    if conditions.magnetometer == "raw":
        config = config_module.without_calibration(config)
    if isinstance(conditions.hull, str):
        plants = config.sitl.plants if config.sitl is not None else {}
        if conditions.hull not in plants:
            raise UsageError(f"no plant '{conditions.hull}' whose hull to believe in; there is {', '.join(plants)}")
        config = replace(config, hull=plants[conditions.hull].hull)
    elif conditions.hull is not None:
        config = replace(config, hull=conditions.hull.hull, thrusters=conditions.hull.thrusters or config.thrusters)
    return config_module.with_model_error(config, conditions.model_error) if conditions.model_error else config


def _scenario_list(arguments: argparse.Namespace) -> int:
    from sitl.scenarios import SCENARIOS

    for scenario in SCENARIOS.values():
        settings = " ".join(f"{key}={value}" for key, value in scenario.defaults.items())
        print(f"{scenario.name:20} {scenario.text} ({scenario.vessel}); {settings}")
    return 0


def _scenario_table(arguments: argparse.Namespace) -> int:
    from sitl.scenarios import SCENARIOS, route_table, table

    if arguments.seeds < 1:
        raise UsageError(f"--seeds {arguments.seeds}: at least 1, please")
    lines = route_table.lines if arguments.name == "route" else table.lines
    for line in lines(SCENARIOS[arguments.name], LockstepRig, arguments.seeds):
        print(line, flush=True)
    return 0


def _scenario_run(arguments: argparse.Namespace) -> int:
    from sitl.scenarios import SCENARIOS
    from sitl.scenarios.scenario import ScenarioError
    from sitl.scenarios.scenario import run as sail

    if arguments.name not in SCENARIOS:
        raise UsageError(f"no scenario '{arguments.name}'; there is {', '.join(SCENARIOS)}")
    changes: dict[str, str] = {}
    for change in arguments.changes:
        key, equals, value = change.partition("=")
        if not equals:
            raise UsageError(f"--set {change}: write KEY=VALUE")
        changes[key] = value
    folder = arguments.out or fresh(Path("out"), f"{arguments.name}-seed{arguments.seed}")
    started_s = time.perf_counter()
    try:
        outcome = sail(SCENARIOS[arguments.name], LockstepRig, folder, arguments.seed, arguments.vessel, changes, draw=True)
    except (ScenarioError, ValueError) as error:
        raise UsageError(str(error)) from error
    for name, value in outcome.metrics.items():
        print(f"{name:24} {value:10.3f}")
    for check in outcome.checks:
        relation = "at least" if check.at_least else "at most"
        print(f"{'ok  ' if check.ok else 'FAIL'} {check.name}: {check.value:.3f} {check.unit}, {relation} {check.limit:g}")
    if outcome.error:
        print(f"FAIL {outcome.error}")
    if outcome.hint:
        print(outcome.hint)
    print(f"{folder}: {time.perf_counter() - started_s:.1f} s")
    return 0 if outcome.ok else 1
