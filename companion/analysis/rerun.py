"""The whole tick again, from a log.

The recorded readings, device health and ground station packets go into a vessel built as the recorded one was:
configuration, parameters, plans and progress at the start, and the same clock. Modes, guidance, control and allocation
are today's, so the new log shows what a change of code would have decided in the same situation.

The boat itself moves as it was recorded to. Where today's code steers differently, only the first moments of the
difference are realistic.
"""

from __future__ import annotations

import collections
import csv
import itertools
import json
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from companion.analysis.compare import LogDifference, compare
from companion.analysis.log_reader import Log, LogError, seconds
from companion.app import Surroundings, build
from companion.config.chart import ChartConfig, ChartError, read_chart
from companion.config.vessel import VesselConfig
from companion.core.actuation import ActuatorCommand
from companion.core.ports import ByteStream
from companion.core.readings import Reading
from companion.core.tick import DeviceHealth
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.guard import Guard
from companion.io.mavlink.wire.link_base import Received, link_health, take_in
from companion.io.mavlink.wire.personas import DEFAULT_PERSONA, PERSONAS
from companion.loop import Devices, RealWorld, Vessel
from companion.params.store import Parameters
from companion.record import readings
from companion.record.readings import read_ticks
from companion.record.recorded import RecordedPacket, RecordedTick
from companion.record.recorder import STATE_FOLDER
from companion.record.state_file import StateFile

_SIMULTANEOUS_S = 1e-9
_ROUNDED_S = 0.00051  # ticks.csv has milliseconds


def rerun(log: Log, out: Path) -> LogDifference:
    """Run a log again into a new log folder and compare the two. Raises LogError for a log without its inputs, and
    OSError."""
    path = readings.path_in(log.folder)
    if not path.exists():
        raise LogError(f"{path}: no such file: this log was recorded without its readings")
    if out.resolve() == log.folder.resolve():
        raise LogError(f"{out}: the log itself; choose another folder with --out")
    warnings: list[str] = []
    settings = _settings(log)
    parameters, charts = _known(log.config.parameters, warnings), _readable(log.config.charts, warnings)
    log = replace(log, config=replace(log.config, parameters=parameters, charts=charts))
    settings["defaults"] = _known(settings["defaults"], warnings)
    with tempfile.TemporaryDirectory() as kept:
        state = _state(log.folder / STATE_FOLDER, Path(kept))
        try:
            done = _run(log, settings, state, out, warnings)
        finally:
            if state is not None:
                state.close()
    return compare(log.folder, out, done, warnings)


def _run(log: Log, settings: dict[str, Any], state: StateFile | None, out: Path, warnings: list[str]) -> int:
    """Returns how many ticks were done."""
    clock, link, bench = _Clock(), _Link(), _Bench(log.config)
    around = Surroundings(
        clock=clock,
        opener=_NoPorts(),
        world=RealWorld(),
        links=[link],
        state=state,
        log_folder=out,
        manifest={"again": str(log.folder)},
        defaults=settings["defaults"],
        patience=float(settings["patience"]),
        devices=Devices(RealWorld(), bench.sensors, bench.actuators),
    )
    vessel: Vessel | None = None
    done = 0
    ticks = read_ticks(readings.path_in(log.folder), warnings)
    try:
        for tick, (time_unix_ns, load) in _stamped(ticks, _stamps(log.folder, warnings)):
            clock.time_ns = time_unix_ns
            vessel = build(log.config, around) if vessel is None else vessel
            bench.take(tick)
            _serve(vessel, clock, link, tick)
            clock.time_s, vessel.load = tick.t_s, load
            vessel.tick(tick.t_s)
            done += 1
        collections.deque(ticks, maxlen=0)  # what a shorter ticks.csv leaves: at its end the log's file is closed
    finally:
        if vessel is not None:
            vessel.close()
    if vessel is None:
        raise LogError(f"{readings.path_in(log.folder)}: no whole tick")
    return done


def _serve(vessel: Vessel, clock: _Clock, link: _Link, tick: RecordedTick) -> None:
    """Deliver the packets that arrived between two ticks, at their times. The tick handles those that came with it."""
    for t_s, packets in itertools.groupby(tick.packets, lambda packet: packet.t_s):
        link.arrive(tuple(packets))
        if t_s < tick.t_s - _SIMULTANEOUS_S:
            clock.time_s = t_s
            vessel.serve(t_s)


def _settings(log: Log) -> dict[str, Any]:
    manifest = json.loads((log.folder / "manifest.json").read_text(encoding="utf-8"))
    if "patience" not in manifest or "defaults" not in manifest:
        raise LogError(
            f"{log.folder}: recorded before logs held the packets of ground stations; "
            "its estimates can be replayed without --all"
        )
    return dict(manifest)


def _known(values: Mapping[str, float], warnings: list[str]) -> dict[str, float]:
    """The values that the present table of parameters accepts."""
    table, known = Parameters(), {}
    for name, value in values.items():
        if (refusal := table.refusal(name, value)) is None:
            known[name] = value
        else:
            warnings.append(f"parameter {name} = {value:g} refused: {refusal.name.lower().replace('_', ' ')}")
    return known


def _readable(charts: Sequence[ChartConfig], warnings: list[str]) -> tuple[ChartConfig, ...]:
    """The charts that can be read here; a log does not hold them."""
    kept = []
    for chart in charts:
        try:
            read_chart(Path(chart.file), chart.kind)
            kept.append(chart)
        except ChartError as error:
            warnings.append(f"chart left out: {error.problems[0]}")
    return tuple(kept)


def _state(recorded: Path, directory: Path) -> StateFile | None:
    """The state that was stored when the run began; None for a vessel without storage."""
    if not recorded.is_dir():
        return None
    shutil.copytree(recorded, directory, dirs_exist_ok=True)
    return StateFile(directory)


def _stamped(
    ticks: Iterator[RecordedTick], stamps: Iterator[tuple[float, int, float]]
) -> Iterator[tuple[RecordedTick, tuple[int, float]]]:
    """Each tick with its row of ticks.csv. A log that went on in another folder may begin with a row more of either."""
    tick, stamp = next(ticks, None), next(stamps, None)
    while tick is not None and stamp is not None:
        late_s = stamp[0] - tick.t_s
        if abs(late_s) <= _ROUNDED_S:
            yield tick, stamp[1:]
        if late_s <= _ROUNDED_S:
            stamp = next(stamps, None)
        if late_s >= -_ROUNDED_S:
            tick = next(ticks, None)


def _stamps(folder: Path, warnings: list[str]) -> Iterator[tuple[float, int, float]]:
    """(t_s, time_unix_ns, load) of each row of ticks.csv. The machine sets the latter two, so a replay takes them from
    the log. Where a row lacks one of these they go on from the row before, and before the first whole row go back from
    that; without t_s a row is omitted. All with a warning."""
    before: tuple[float, int, float] | None = None
    early: list[tuple[int, float]] = []  # number and t_s of rows before the first whole one
    with (folder / "ticks.csv").open(encoding="utf-8", errors="replace", newline="\n") as file:
        rows = csv.DictReader(line for line in file if line.endswith("\n"))
        for number, row in enumerate(rows, start=2):
            t_s = seconds(row.get("t_s"))
            if t_s is None:
                warnings.append(f"ticks.csv:{number}: row omitted: no time")
                continue
            try:
                whole = t_s, int(row["time_unix_ns"]), float(row["load"])
            except (TypeError, ValueError):
                if before is None:
                    early.append((number, t_s))
                    continue
                warnings.append(f"ticks.csv:{number}: no time_unix_ns or load; both go on from the row before")
                whole = _at(t_s, before)
            for early_number, early_s in early:
                warnings.append(f"ticks.csv:{early_number}: no time_unix_ns or load; both go back from row {number}")
                yield _at(early_s, whole)
            early.clear()
            before = whole
            yield whole


def _at(t_s: float, row: tuple[float, int, float]) -> tuple[float, int, float]:
    """Another row at `t_s`, by the values of `row`."""
    return t_s, row[1] + round((t_s - row[0]) * 1e9), row[2]


class _Clock:
    """A clock that is set to the recorded times."""

    def __init__(self) -> None:
        self.time_s = 0.0
        self.time_ns = 0

    def now_s(self) -> float:
        """The recorded vessel time, s."""
        return self.time_s

    def time_unix_ns(self) -> int:
        """The recorded Unix time, ns."""
        return self.time_ns

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        """Return False at once: a replay never waits."""
        return False

    def busy_s(self) -> float:
        """0: the recorded load is used instead."""
        return 0.0


class _NoPorts:
    """An opener that refuses every port: a replay has recorded devices only."""

    def open(self, name: str, url: str) -> ByteStream:
        """Raise AssertionError."""
        raise AssertionError(f"{name}: a replay opens no port")


class _Device:
    """A recorded sensor or bridge. The first one returns the readings of all devices, in their order of arrival."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.state = DeviceHealth(name, False, None, "not in the log")
        self.arrived: tuple[Reading, ...] = ()

    def read(self, now_s: float) -> Sequence[Reading]:
        """The recorded readings of this tick, once."""
        arrived, self.arrived = self.arrived, ()
        return arrived

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """Ignored: the new log has the commands."""

    def health(self, now_s: float) -> DeviceHealth:
        """The recorded health."""
        return self.state

    def fileno(self) -> int | None:
        """None: there is no descriptor."""
        return None

    def close(self) -> None:
        """Do nothing."""


class _Bench:
    """All recorded devices of a vessel."""

    def __init__(self, config: VesselConfig) -> None:
        self.sensors = tuple(_Device(sensor.name) for sensor in config.sensors)
        self.actuators = tuple(_Device(bridge.name) for bridge in config.actuators)
        self._all = {device.name: device for device in (*self.sensors, *self.actuators)}

    def take(self, tick: RecordedTick) -> None:
        """Give the devices the health and readings of a recorded tick."""
        for health in tick.health:
            if health.name in self._all:
                self._all[health.name].state = health
        for device in itertools.islice(self._all.values(), 1):
            device.arrived = tick.readings


class _Link:
    """All recorded links in one, with an endpoint for each remote."""

    name = "recorded"

    def __init__(self) -> None:
        self.guard = Guard()
        self._endpoints: dict[tuple[str, str], Endpoint] = {}
        self._arrived: list[RecordedPacket] = []

    def arrive(self, packets: Sequence[RecordedPacket]) -> None:
        """Queue recorded packets for the next `receive`."""
        self._arrived += packets

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """One endpoint for each remote seen so far."""
        return tuple(self._endpoints.values())

    def receive(self, now_s: float) -> Received:
        """The (endpoint, message) pairs of the queued packets."""
        out: Received = []
        arrived, self._arrived = self._arrived, []
        for packet in arrived:
            key = packet.persona, packet.endpoint
            if key not in self._endpoints:
                persona = PERSONAS.get(packet.persona, DEFAULT_PERSONA)
                self._endpoints[key] = Endpoint(packet.endpoint, persona, lambda data, now_s: len(data))
            endpoint = self._endpoints[key]
            take_in(endpoint, endpoint.framer.feed(packet.data) + endpoint.framer.flush(), now_s, out)
        return out

    def filenos(self) -> Sequence[int]:
        """Empty: there is no descriptor."""
        return ()

    def health(self, now_s: float) -> DeviceHealth:
        """The health, by the packets of all endpoints."""
        return link_health(self.name, self.endpoints, None, now_s)

    def news(self) -> Sequence[str]:
        """Empty: a recorded link has nothing to announce."""
        return ()

    def close(self) -> None:
        """Forget all endpoints."""
        self._endpoints.clear()
