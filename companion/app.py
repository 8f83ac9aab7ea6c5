"""Builds the vessel from configuration, ports and clock. Only this file uses all the concrete classes."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from companion import native
from companion.allocation.availability import Availability
from companion.allocation.choice import allocator_of
from companion.baselines.ahrs import ThesisAhrs
from companion.baselines.controller_choice import controller_with_baselines
from companion.beside import Beside
from companion.config import vessel as config_module
from companion.config.chart import ChartError, ChartFeature, read_chart, read_charts
from companion.config.reversing import stern_first_refusal
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.decision import TextKind
from companion.core.events import EventLog
from companion.core.nearest import did_you_mean
from companion.core.ports import Recorder, ReportsBack, StreamOpener, WaitingClock, World
from companion.io import actuators, sensors
from companion.io.actuators import open_actuator
from companion.io.corrections import CorrectionsRelay, CorrectionsSource
from companion.io.host import HostWatch
from companion.io.known_time import KnownTime, host_synchronised
from companion.io.mavlink.assembly import connect
from companion.io.mavlink.wire.exposure import exposed
from companion.io.mavlink.wire.hub import Copies
from companion.io.mavlink.wire.links import Link, LinkError, judge_url
from companion.io.mavlink.wire.signing import Policy, Signing, SigningState
from companion.io.mavlink.wire.stream_memory import SharedStreamMemory
from companion.io.nmea_out import NmeaOut
from companion.io.sensors import open_sensor
from companion.io.transport.opener import device_endpoint
from companion.io.transport.urls import TransportError, parse_url
from companion.loop import Blocks, Devices, Vessel
from companion.mission.executor import MissionExecutor
from companion.mission.plan import Plans
from companion.mission.validation import check_plan
from companion.nav.estimator import Estimator
from companion.params.spec import ParamRefusal
from companion.params.store import Parameters
from companion.params.table import TABLE, table_of
from companion.record.disk import REAL_DISK, Disk
from companion.record.progress_keeper import ProgressKeeper
from companion.record.recorder import STATE_FOLDER, LogFolder, Medium
from companion.record.state_file import StateFile
from companion.record.storage import BoatStorage
from companion.record.wear_keeper import WearKeeper
from companion.record.writer import ThreadWriter
from companion.safety import Gate
from companion.supervisor.supervisor import Supervisor


@cache
def program_version() -> str:
    """The installed version, or "0.0.0" from a source tree."""
    try:
        return version("usv-companion")
    except PackageNotFoundError:
        return "0.0.0"


def load_vessel(vessel: str) -> VesselConfig:
    """The configuration of a bundled vessel or of a TOML path, checked with its parameters and ports. Raises
    ConfigError with every problem."""
    path = config_module.find(vessel)
    tables = config_module.raw(path)
    if "system_id" in tables and "thruster" not in tables:
        raise ConfigError([f"{path}: a leader module's file, not a vessel's: `companion leader {path}`"])
    problems: list[str] = []
    try:
        config = config_module.load(path)
        settings: Mapping[str, float] = config.parameters
        plugins = (*sensors.plugin_problems(config.sensors), *actuators.plugin_problems(config))
        problems += [config_module.placed(path, place, text) for place, text in plugins]
    except ConfigError as error:
        problems += error.problems
        settings = config_module.raw_parameters(path)
    problems += port_problems(path) + parameter_problems(path, settings) + script_problems(path) + chart_problems(path)
    if problems:
        raise ConfigError(problems)
    return config


def parameter_problems(path: Path, settings: Mapping[str, float]) -> list[str]:
    """One line, with its place in the file, for each entry of `[parameters]` that the table of parameters refuses."""
    found: list[str] = []
    table = Parameters()
    for name, value in settings.items():
        if (refusal := table.refusal(name, value)) is not None:
            why = refusal.name.lower().replace("_", " ")
            text = f"{value:g}: {why}{_allowed(table, name)}"
            if refusal is ParamRefusal.DOES_NOT_EXIST:
                text += did_you_mean(name, (spec.name for spec in TABLE))
            found.append(config_module.placed(path, ("parameters", name), text))
    return found


def script_problems(path: Path) -> list[str]:
    """One line for each script whose file is not there."""
    rows = _rows(config_module.raw(path), "script")
    named = ((i, path.parent / str(row["file"])) for i, row in rows if "file" in row)
    return [
        config_module.placed(path, ("script", i, "file"), f"no such file: {file}")
        for i, file in named
        if not file.is_file()
    ]


def chart_problems(path: Path) -> list[str]:
    """What is wrong with the files of charts, each with its place in the vessel's file."""
    found: list[str] = []
    for i, row in _rows(config_module.raw(path), "chart"):
        try:
            if isinstance(row.get("file"), str):
                read_chart(path.parent / row["file"], str(row["kind"]) if "kind" in row else None)
        except ChartError as error:
            found += [config_module.placed(path, ("chart", i, "file"), problem) for problem in error.problems]
    return found


def port_problems(path: Path) -> list[str]:
    """One line, with its place in the file, for each unknown driver, each URL that can never be opened, and each port
    used twice. The file may have other faults too."""
    tables = config_module.raw(path)
    found: list[str] = []
    for table, refusal in (("sensor", sensors.refusal), ("actuator", actuators.refusal)):
        for i, row in _rows(tables, table):
            if "driver" in row and (text := refusal(str(row["driver"]))) is not None:
                found.append(config_module.placed(path, (table, i, "driver"), text))
            found += _port_problem(path, table, i, row)
    for table in ("corrections", "nmea_out"):
        for i, row in _rows(tables, table):
            found += _port_problem(path, table, i, row)
    for key in ("links", "local_links"):
        for i, url in enumerate(_list(tables, key)):
            found += _url_problem(path, (key, i), url, judge_url)
    return found + _device_clashes(path, tables) + _link_clashes(path, tables)


def _port_problem(path: Path, table: str, i: int, row: Mapping[str, Any]) -> list[str]:
    """The problems of the row's port; empty if it has none."""
    return _url_problem(path, (table, i, "port"), row["port"], device_endpoint) if "port" in row else []


def _url_problem(path: Path, loc: tuple[str | int, ...], url: object, parse: Callable[[str], object]) -> list[str]:
    """Why `parse` refuses the URL at `loc`; empty if it does not."""
    try:
        parse(str(url))
    except (TransportError, LinkError) as error:
        return [config_module.placed(path, loc, str(error))]
    return []


def _device_clashes(path: Path, tables: Mapping[str, Any]) -> list[str]:
    """One line for each device on the serial port of another that gives other settings: a port is opened once, with the
    settings of the first. Devices that give the same are judged by `stream_problems`."""
    first: dict[str, tuple[str, object]] = {}
    found = []
    for table in ("sensor", "actuator"):
        for i, row in _rows(tables, table):
            url = row.get("port")
            for device in _serial_path(url):
                name, other = first.setdefault(device, (f"{table} '{row.get('name', i + 1)}'", url))
                if other != url:
                    text = f"{name} has {device} too, as '{other}': give both the same, or each a port of its own"
                    found.append(config_module.placed(path, (table, i, "port"), text))
    return found


def _link_clashes(path: Path, tables: Mapping[str, Any]) -> list[str]:
    """One line for each serial link on the port of a device or of another link: each would read the other's bytes."""
    rows = [
        (f"{table} '{row.get('name', i + 1)}'", row.get("port"))
        for table in ("sensor", "actuator", "corrections")
        for i, row in _rows(tables, table)
    ]
    taken = {parts[0]: name for name, url in rows if (parts := _serial_path(url))}
    found = []
    for key in ("links", "local_links"):
        for i, url in enumerate(_list(tables, key)):
            for device in _serial_path(url):
                if device in taken:
                    found.append(
                        config_module.placed(
                            path, (key, i), f"'{url}': {taken[device]} has {device} too: a link needs a port of its own"
                        )
                    )
                taken.setdefault(device, f"{key}[{i + 1}]")
    return found


def _serial_path(url: object) -> list[str]:
    """The device file of a serial URL; empty for another or an invalid URL (`port_problems` reports that)."""
    try:
        endpoint = parse_url(str(url))
    except TransportError:
        return []
    return [endpoint.path] if endpoint.scheme == "serial" else []


def _list(tables: Mapping[str, Any], key: str) -> list[object]:
    """The list at a key; empty if the file has something else there (the check of its keys reports that)."""
    found = tables.get(key)
    return found if isinstance(found, list) else []


def _rows(tables: Mapping[str, Any], table: str) -> list[tuple[int, dict[str, Any]]]:
    """The numbered rows of a [[table]]; empty if the file has something else there (the check of its keys reports
    that)."""
    rows = tables.get(table)
    return [(i, row) for i, row in enumerate(rows) if isinstance(row, dict)] if isinstance(rows, list) else []


def _allowed(table: Parameters, name: str) -> str:
    spec = table.spec(name)
    return f"; allowed {spec.minimum:g} to {spec.maximum:g} {spec.unit}".rstrip() if spec is not None else ""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The surroundings of a vessel: its clock, ports and links, and the places of its state and log."""

    clock: WaitingClock
    opener: StreamOpener
    world: World
    links: Sequence[Link]
    state: StateFile | None = None
    log_folder: Path | None = None
    durable_log: bool = False  # with ticks.ulg; for a boat, not for lockstep
    manifest: Mapping[str, Any] | None = None
    defaults: Mapping[str, float] | None = None  # defaults of parameters; they override the vessel's own
    patience: float = 1.0  # factor on time-outs of ground stations, whose time runs slower than the vessel's
    devices: Devices | None = None  # None: open the devices of the configuration
    stations_time_unix_ns: Callable[[], int] | None = None  # the time of the ground stations; None: the clock's
    beside: bool = False  # write, and do long work, beside the control thread; for a boat, not for lockstep
    disk: Disk = REAL_DISK
    network: StreamOpener | None = None  # opens the ports of corrections and NMEA out; None: both are off
    patient_log: bool = False  # a medium that is full or fails keeps the boat from nothing: its log begins later


def build(config: VesselConfig, around: Surroundings) -> Vessel:
    """Make a vessel. Raises ConfigError for an unknown driver, OSError for a log folder that cannot be written."""
    events = EventLog()
    warn = _warner(events, around.clock)
    if around.state is not None:
        around.state.on_warning = warn
        around.state.on_good_news = lambda text: events.say(around.clock.now_s(), TextKind.ROUTINE, "storage", text)
    beside = Beside() if around.beside else None
    parameters = _parameters(config, around, warn)
    plans = _plans(around.state, config, warn)
    executor = MissionExecutor(plans)
    estimator = Estimator(config, parameters, events.say, ThesisAhrs)
    supervisor = Supervisor(config, parameters, plans, executor, events, lambda: estimator.frame)
    supervisor.senses.decide = estimator.answer
    supervisor.parts.chart.load(_charts(config))
    availability = Availability(config, parameters, events.say)
    allocator = allocator_of(config, parameters)
    controller = controller_with_baselines(config, parameters)
    blocks = Blocks(estimator, supervisor, controller, availability, allocator, Gate(config))
    devices, relay = _devices(config, around, events)
    vessel = Vessel(config, parameters, plans, executor, events, blocks, devices, around.clock)
    if beside is not None:
        vessel.work_beside(beside.worker, beside.bell)
        supervisor.parts.work_with(beside.worker)
    log = _store(vessel, around, beside, warn)
    ear = None if log is None else log.heard
    for recorder in (relay, *_reporters(config, devices, around, events)):
        vessel.add_recorder(recorder)
    if around.beside:
        watch = HostWatch(events.say)
        vessel.host = watch
        if around.patience <= 1.0:
            vessel.add_recorder(watch)
    vessel.attach(
        connect(
            vessel,
            around.links,
            program_version(),
            Copies(_tap(log, around.clock), ear),
            around.patience,
            around.log_folder,
            relay,
            _signing(vessel, around, warn),
        )
    )
    if beside is not None:
        vessel.add_recorder(beside)
    _tell_exposed(around, events)
    return vessel


def _charts(config: VesselConfig) -> tuple[ChartFeature, ...]:
    try:
        return read_charts(config.charts)
    except ChartError as error:
        raise ConfigError(error.problems) from error


def _store(
    vessel: Vessel, around: Surroundings, beside: Beside | None, warn: Callable[[str], None]
) -> LogFolder | None:
    """Give the vessel its log, its storage and what keeps its progress; returns the log."""
    state, keeper = around.state, None
    if state is not None:
        if beside is not None:
            state.write_with(ThreadWriter(state.directory, beside.bell.ring, around.disk))
        keeper = ProgressKeeper(vessel.executor, vessel.supervisor, state, warn)
        vessel.add_recorder(keeper)
        vessel.add_recorder(WearKeeper(vessel.config, state, vessel.events.say, warn))
    log = _log_folder(vessel.config, vessel.parameters, around)
    if log is not None:
        vessel.add_recorder(log)
        vessel.parameters.on_change(log.parameter)
    if state is not None or log is not None:
        output = None if log is None else log.output
        storage = BoatStorage(state, vessel.parameters, keeper, output, vessel.events.say)
        vessel.store_in(storage)
        vessel.add_recorder(storage)
    return log


def _devices(config: VesselConfig, around: Surroundings, events: EventLog) -> tuple[Devices, CorrectionsRelay]:
    """The devices, and the relay that passes corrections to the receivers among them."""
    receivers = [
        sensor.name for sensor in config.sensors if sensor.rtcm or sensor.name in {row.to for row in config.corrections}
    ]
    names = [f"corrections_{number}" for number in range(1, len(config.corrections) + 1)]
    if around.devices is not None:
        return around.devices, CorrectionsRelay(dict.fromkeys(receivers), names, events.say)
    ports = {sensor.name: around.opener.open(sensor.name, sensor.port) for sensor in config.sensors}
    moving = [ports[sensor.name] for sensor in config.sensors if sensor.moving_base]
    relay = CorrectionsRelay({name: ports[name] for name in receivers}, names, events.say, moving)
    network = around.network
    sources = (
        ()
        if network is None
        else tuple(
            CorrectionsSource(row, name, network.open(name, row.port), relay)
            for name, row in zip(names, config.corrections, strict=True)
        )
    )
    devices = Devices(
        world=around.world,
        sensors=(*(open_sensor(sensor, ports[sensor.name]) for sensor in config.sensors), *sources),
        actuators=tuple(
            open_actuator(bridge, config, around.opener.open(bridge.name, bridge.port)) for bridge in config.actuators
        ),
    )
    return devices, relay


def _reporters(config: VesselConfig, devices: Devices, around: Surroundings, events: EventLog) -> Iterator[Recorder]:
    """What tells devices aboard of the boat's state."""
    for device in (*devices.sensors, *devices.actuators):
        if isinstance(device, ReportsBack):
            yield device.telemetry
    if around.network is not None:
        for row in config.nmea_out:
            yield NmeaOut(row, config.thrusters, around.network.open("nmea_out", row.port), events.say)


def _tell_exposed(around: Surroundings, events: EventLog) -> None:
    for link in around.links:
        if exposed(link.name):
            events.say(around.clock.now_s(), TextKind.ATTENTION, "link_exposed", f"Link {link.name} obeys anybody")


def _warner(events: EventLog, clock: WaitingClock) -> Callable[[str], None]:
    """Announces a warning about storage, and writes it to stderr."""

    def warn(text: str) -> None:
        events.say(clock.now_s(), TextKind.ATTENTION, "storage", text)
        sys.stderr.write(f"companion: {text}\n")

    return warn


def _parameters(config: VesselConfig, around: Surroundings, warn: Callable[[str], None]) -> Parameters:
    """The parameters: defaults of the table, then the vessel's, then this run's, then the stored values of an
    operator."""
    parameters = Parameters({**config.parameters, **(around.defaults or {})}, table_of(config))
    kept: Mapping[str, float] = {}
    if around.state is not None:
        kept, warnings = around.state.load_parameters()
        for text in warnings:
            warn(text)
    for name, value in kept.items():
        if (refusal := parameters.set(name, value)) is not None:
            warn(f"Stored {name} = {value:g} ignored: {refusal.name.lower().replace('_', ' ')}")
            if around.state is not None:
                around.state.keep_aside(name, value)
    if around.state is not None:
        parameters.on_change(partial(_set_anew, around.state, parameters))
    return parameters


def _set_anew(state: StateFile, parameters: Parameters, name: str, _: float) -> None:
    """The operator has set a parameter whose stored value was refused: that one is no longer kept."""
    if state.let_go(name):
        state.save_parameters(parameters.changed())


def _signing(vessel: Vessel, around: Surroundings, warn: Callable[[str], None]) -> Signing:
    """Message signing, with the stored key if there is one. The time is known by satellites, or by a synchronised
    computer; on a simulated boat, whose satellites have a time of their own, by the computer alone."""
    time_unix_ns = around.stations_time_unix_ns or around.clock.time_unix_ns
    by_satellites = None if around.stations_time_unix_ns else partial(_time_by_satellites, vessel, around.clock)
    known = KnownTime(host_synchronised if around.beside else lambda: False, time_unix_ns, by_satellites)
    state = around.state
    if state is None:
        return Signing(time_unix_ns, SigningState(None, 0), lambda _: None)
    kept, warnings = state.load_signing()
    for text in warnings:
        warn(text)
    if kept[0] is None and any(link.guard.options.signing is Policy.REQUIRE for link in around.links):
        warn("No signing key: run companion signing set")

    def save(new: SigningState) -> None:
        state.save_signing(new.key, new.horizon)

    memory = SharedStreamMemory(state.directory) if around.beside else None
    return Signing(time_unix_ns, SigningState(*kept), save, known.unix_ns, memory)


def _time_by_satellites(vessel: Vessel, clock: WaitingClock) -> int | None:
    """Unix time, ns; None until a receiver gives it."""
    last = vessel.last_tick
    if last is None or last.nav.time_unix_ns is None:
        return None
    return last.nav.time_unix_ns + round((clock.now_s() - last.nav.t_s) * 1e9)


def _plans(state: StateFile | None, config: VesselConfig, warn: Callable[[str], None]) -> Plans:
    """The stored plans that pass the checks."""
    plans = Plans()
    if state is not None:
        kept, warnings = state.load_plans()
        no_astern = stern_first_refusal(config.thrusters)
        for text in warnings:
            warn(text)
        for kind, items in kept.items():
            outputs = len(config.servos), len(config.relays)
            refusal = check_plan(kind, items, *outputs, no_astern=no_astern) if items else None
            if refusal is None:
                plans.replace(kind, items)
            else:
                warn(f"Stored {kind.name.lower()} ignored: {refusal.text}")
                state.plan_refused(kind)
    return plans


def _log_folder(config: VesselConfig, parameters: Parameters, around: Surroundings) -> LogFolder | None:
    if around.log_folder is None:
        return None
    manifest = {
        "version": program_version(),
        "python": sys.version.split()[0],
        "arithmetic": native.status,
        "vessel": config.name,
        "started_unix_ns": around.clock.time_unix_ns(),
        **(around.manifest or {}),
        "parameters": {spec.name: parameters[spec.name] for spec in parameters.specs},
        "defaults": dict(around.defaults or {}),
        "patience": around.patience,
        "configuration": config_module.as_dict(config),
    }
    thrusters = [thruster.name for thruster in config.thrusters]
    devices = [*(sensor.name for sensor in config.sensors), *(bridge.name for bridge in config.actuators)]
    medium = Medium(around.durable_log, around.beside, around.disk, around.patient_log)
    state = around.state

    def furnish(folder: Path) -> None:
        if state is not None:
            state.copy_to(folder / STATE_FOLDER)

    return LogFolder(
        around.log_folder, thrusters, devices, manifest, parameters.specs, medium, furnish, bool(config.cameras)
    )


def _tap(log: LogFolder | None, clock: WaitingClock) -> Callable[[Sequence[bytes]], None] | None:
    """The function that logs a copy of every packet, in and out; None without a log."""
    if log is None:
        return None
    return lambda packets: log.packets(packets, clock.time_unix_ns())
