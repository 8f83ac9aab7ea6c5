"""`companion replay --all`: the whole tick again. The recorded readings, the health of the devices and what ground stations sent go into a vessel that
is built as the recorded one was (configuration, parameters, plans and progress at the start); the clock stands where it stood. Modes, guidance,
control and allocation are today's, so the new log tells what a change of code would have said in the same situation. The boat itself moves as it
moved: where the code steers otherwise, only the first moments of the difference tell what would have happened.
"""

from __future__ import annotations

import csv
import itertools
import json
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from companion.app import Surroundings, build
from companion.config import VesselConfig
from companion.core.ports import ByteStream
from companion.core.types import ActuatorCommand, DeviceHealth, Reading
from companion.io.mavlink.dialects import DEFAULT_DIALECT, DIALECTS
from companion.io.mavlink.endpoint import Endpoint
from companion.io.mavlink.guard import Guard
from companion.io.mavlink.link_base import Received, link_health, take_in
from companion.loop import Devices, RealWorld, Vessel
from companion.params import Parameters
from companion.record import readings
from companion.record.compare import LogDifference, compare
from companion.record.log_reader import Log, LogError
from companion.record.readings import RecordedPacket, RecordedTick, read_ticks
from companion.record.recorder import STATE_FOLDER
from companion.record.state_file import StateFile

_SIMULTANEOUS_S = 1e-9


def rerun(log: Log, out: Path) -> LogDifference:
    """Do a recorded run again, into a log folder of its own, and compare the two. Raises LogError for a log without its inputs, OSError for
    a file."""
    path = log.folder / readings.FILE
    if not path.exists():
        raise LogError(f"{path}: not there: this log was recorded without its readings")
    if out.resolve() == log.folder.resolve():
        raise LogError(f"{out}: the log itself; give another folder with --out")
    warnings: list[str] = []
    settings = _settings(log)
    log = replace(log, config=replace(log.config, parameters=_known(log.config.parameters, warnings)))
    settings["defaults"] = _known(settings["defaults"], warnings)
    with tempfile.TemporaryDirectory() as kept:
        state = _state(log.folder / STATE_FOLDER, Path(kept))
        try:
            _run(log, settings, state, out, warnings)
        finally:
            if state is not None:
                state.close()
    return compare(log.folder, out, warnings)


def _run(log: Log, settings: dict[str, Any], state: StateFile | None, out: Path, warnings: list[str]) -> None:
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
    try:
        for tick, (time_unix_ns, load) in zip(read_ticks(log.folder / readings.FILE, warnings), _stamps(log.folder), strict=False):
            clock.time_ns = time_unix_ns
            vessel = build(log.config, around) if vessel is None else vessel
            bench.take(tick)
            _serve(vessel, clock, link, tick)
            clock.time_s, vessel.load = tick.t_s, load
            vessel.tick(tick.t_s)
    finally:
        if vessel is not None:
            vessel.close()
    if vessel is None:
        raise LogError(f"{log.folder / readings.FILE}: holds no whole tick")


def _serve(vessel: Vessel, clock: _Clock, link: _Link, tick: RecordedTick) -> None:
    """What came between two ticks, at its time; what came with the tick is left to it."""
    for t_s, packets in itertools.groupby(tick.packets, lambda packet: packet.t_s):
        link.arrive(tuple(packets))
        if t_s < tick.t_s - _SIMULTANEOUS_S:
            clock.time_s = t_s
            vessel.serve(t_s)


def _settings(log: Log) -> dict[str, Any]:
    manifest = json.loads((log.folder / "manifest.json").read_text(encoding="utf-8"))
    if "patience" not in manifest or "defaults" not in manifest:
        raise LogError(f"{log.folder}: recorded before logs held what ground stations send; without --all its estimates can be replayed")
    return dict(manifest)


def _known(values: Mapping[str, float], warnings: list[str]) -> dict[str, float]:
    """What today's table of parameters takes."""
    table, known = Parameters(), {}
    for name, value in values.items():
        if (refusal := table.refusal(name, value)) is None:
            known[name] = value
        else:
            warnings.append(f"parameter {name} = {value:g} not taken over: {refusal.name.lower().replace('_', ' ')}")
    return known


def _state(recorded: Path, directory: Path) -> StateFile | None:
    """What the vessel remembered when the run began, None for a vessel without a memory."""
    if not recorded.is_dir():
        return None
    shutil.copytree(recorded, directory, dirs_exist_ok=True)
    return StateFile(directory)


def _stamps(folder: Path) -> Iterator[tuple[int, float]]:
    """(time_unix_ns, load) of each row of ticks.csv: what the machine said, not the vessel."""
    with (folder / "ticks.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            try:
                stamp = int(row["time_unix_ns"]), float(row["load"])
            except (TypeError, ValueError):
                return  # the last row of a power cut
            yield stamp


class _Clock:
    """Stands where the recorded one stood."""

    def __init__(self) -> None:
        self.time_s = 0.0
        self.time_ns = 0

    def now_s(self) -> float:
        return self.time_s

    def time_unix_ns(self) -> int:
        return self.time_ns

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        return False

    def busy_s(self) -> float:
        return 0.0


class _NoPorts:
    """The devices are recorded: nothing is opened."""

    def open(self, name: str, url: str) -> ByteStream:
        raise AssertionError(f"{name}: a replay opens no port")


class _Device:
    """A sensor or bridge as recorded. The readings of all come from the first, in the order in which they came."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.state = DeviceHealth(name, False, None, "not in the log")
        self.arrived: tuple[Reading, ...] = ()

    def read(self, now_s: float) -> Sequence[Reading]:
        arrived, self.arrived = self.arrived, ()
        return arrived

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """Commands go nowhere; they stand in the new log."""

    def health(self, now_s: float) -> DeviceHealth:
        return self.state

    def fileno(self) -> int | None:
        return None

    def close(self) -> None:
        pass


class _Bench:
    """All devices of a vessel."""

    def __init__(self, config: VesselConfig) -> None:
        self.sensors = tuple(_Device(sensor.name) for sensor in config.sensors)
        self.actuators = tuple(_Device(bridge.name) for bridge in config.actuators)
        self._all = {device.name: device for device in (*self.sensors, *self.actuators)}

    def take(self, tick: RecordedTick) -> None:
        for health in tick.health:
            if health.name in self._all:
                self._all[health.name].state = health
        for device in itertools.islice(self._all.values(), 1):
            device.arrived = tick.readings


class _Link:
    """All recorded links in one, with an endpoint for each remote that was heard."""

    name = "recorded"

    def __init__(self) -> None:
        self.guard = Guard()
        self._endpoints: dict[tuple[str, str], Endpoint] = {}
        self._arrived: list[RecordedPacket] = []

    def arrive(self, packets: Sequence[RecordedPacket]) -> None:
        self._arrived += packets

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        return tuple(self._endpoints.values())

    def receive(self, now_s: float) -> Received:
        out: Received = []
        arrived, self._arrived = self._arrived, []
        for packet in arrived:
            key = packet.dialect, packet.endpoint
            if key not in self._endpoints:
                dialect = DIALECTS.get(packet.dialect, DEFAULT_DIALECT)
                self._endpoints[key] = Endpoint(packet.endpoint, dialect, lambda data, now_s: len(data))
            endpoint = self._endpoints[key]
            take_in(endpoint, endpoint.framer.feed(packet.data) + endpoint.framer.flush(), now_s, out)
        return out

    def filenos(self) -> Sequence[int]:
        return ()

    def health(self, now_s: float) -> DeviceHealth:
        return link_health(self.name, self.endpoints, None, now_s)

    def news(self) -> Sequence[str]:
        return ()

    def close(self) -> None:
        self._endpoints.clear()
