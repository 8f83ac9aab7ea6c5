"""Reads a log folder, whatever ended the run that wrote it: an incomplete last line is omitted with a warning."""

from __future__ import annotations

import csv
import json
import math
import types
import typing
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO, Protocol

from companion.config.actuators import BRIDGES
from companion.config.devices import ActuatorConfig, SensorConfig
from companion.config.dimensions.fins import without_fins
from companion.config.sensors import SENSORS
from companion.config.vessel import HomeConfig, NavigatedBoat, VesselConfig
from companion.params.spec import ParamRefusal
from companion.params.store import Parameters
from companion.params.table import table_of

Table = dict[str, "array[float]"]


class LogError(Exception):
    """A folder that is no log, or lacks what is needed: one line that says why and what to do."""


@dataclass(frozen=True, slots=True)
class Log:
    """What a run began with: its configuration, and the value of each parameter."""

    folder: Path
    config: VesselConfig
    parameters: Mapping[str, float]

    @property
    def bare(self) -> Log:
        """The log with the hull as it is without its rudders, whose blades a fit computes apart."""
        config = self.config
        hull = without_fins(config.hull, config.thrusters, config.limits.surge_n)
        return replace(self, config=replace(config, hull=hull))


class SensorLog(Protocol):
    """What a log tells of a boat's sensors, a vessel's or a lead boat's."""

    @property
    def folder(self) -> Path:
        """Where it lies."""
        ...

    @property
    def config(self) -> NavigatedBoat:
        """The boat's sensors and home."""
        ...

    @property
    def parameters(self) -> Mapping[str, float]:
        """The value of each parameter at the start."""
        ...


@dataclass(frozen=True, slots=True)
class SensedBoat:
    """Of a boat its sensors and home alone: all that the manifest of a leader module has."""

    home: HomeConfig
    sensors: tuple[SensorConfig, ...]


@dataclass(frozen=True, slots=True)
class LeaderModuleLog:
    """A SensorLog that a leader module wrote."""

    folder: Path
    config: SensedBoat
    parameters: Mapping[str, float]


def open_log(folder: Path) -> Log:
    """The log in `folder`. Raises LogError where manifest.json is missing or holds no vessel."""
    log = open_sensor_log(folder)
    if not isinstance(log, Log):
        raise LogError(f"{folder}: the log of a leader module, which `calibrate` and `export --to csv` read")
    return log


def open_sensor_log(folder: Path) -> Log | LeaderModuleLog:
    """The log of a vessel or a leader module in `folder`. Raises LogError where manifest.json is missing or holds
    neither."""
    path = folder / "manifest.json"
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        configuration = manifest["configuration"]
        parameters = {str(name): float(value) for name, value in manifest["parameters"].items()}
        if "follower" in configuration:
            return LeaderModuleLog(folder, _rebuilt(SensedBoat, configuration), parameters)
        return Log(folder, vessel_of(configuration), parameters)
    except OSError as error:
        raise LogError(f"{folder}: no log folder: {error.strerror}: {path.name}{_logs_in(folder)}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise LogError(f"{path}: not a manifest that this version can read: {error}") from error


def _logs_in(folder: Path) -> str:
    """The hint to the newest log in a folder of logs; empty where there is none."""
    newest = max(folder.glob("*/manifest.json"), key=lambda path: path.stat().st_mtime, default=None)
    return "" if newest is None else f"; the newest log in it is {newest.parent}"


def parameters_of(log: SensorLog, warnings: list[str]) -> Parameters:
    """Today's table with the values of the run's start. A value that it refuses keeps its default, with a warning."""
    parameters = Parameters(table=table_of(log.config))
    for name, value in log.parameters.items():
        refusal = parameters.set(name, value)
        if refusal is not None and not (refusal is ParamRefusal.READ_ONLY and parameters[name] == value):
            warnings.append(f"parameter {name} = {value:g} refused: {refusal.name.lower().replace('_', ' ')}")
    return parameters


def read_table(
    path: Path,
    columns: tuple[str, ...],
    warnings: list[str],
    optional: tuple[str, ...] = (),
    words: Mapping[str, list[str]] | None = None,
) -> Table:
    """Columns of a CSV as floats; an empty cell is NaN. A row that cannot be read is omitted, with a warning.
    `optional`: columns that older logs lack; they are NaN there. `words`: columns that are no numbers; their cells in
    the rows that are not omitted are appended, empty ones for a column that the file lacks.

    Raises LogError for a file without these columns, OSError.
    """
    with path.open("rb") as file:
        return _table_of(file, path, columns, warnings, optional, words or {})


def seconds(cell: str | None) -> float | None:
    """A time in a row of a log; None for what is no finite number."""
    try:
        t_s = float(cell or "")
    except ValueError:
        return None
    return t_s if math.isfinite(t_s) else None


def _table_of(
    file: BinaryIO,
    path: Path,
    columns: tuple[str, ...],
    warnings: list[str],
    optional: tuple[str, ...],
    words: Mapping[str, list[str]],
) -> Table:
    table: Table = {name: array("d") for name in (*columns, *optional)}  # a fifth of what lists of floats take
    rows = csv.reader(_whole_lines(file, path, warnings))
    header = next(rows, [])
    missing = [name for name in columns if name not in header]
    if missing:
        raise LogError(f"{path}: no column {', '.join(missing)}")
    known = [name for name in (*columns, *optional) if name in header]
    places = [header.index(name) for name in known]
    worded = [(cells, header.index(name) if name in header else None) for name, cells in words.items()]
    for number, row in enumerate(rows, start=2):
        try:
            values = [float(row[place] or "nan") for place in places]
            if len(row) != len(header):
                raise ValueError(f"{len(row)} cells, not {len(header)}")
            if "t_s" in known and not math.isfinite(values[known.index("t_s")]):
                raise ValueError("no time")
        except (ValueError, IndexError) as error:
            warnings.append(f"{path.name}:{number}: row omitted: {error}")
            continue
        for name, value in zip(known, values, strict=True):
            table[name].append(value)
        for cells, column in worded:
            cells.append("" if column is None else row[column])
    count = len(table["t_s"]) if "t_s" in table else 0
    return {name: values if name in known else array("d", [math.nan]) * count for name, values in table.items()}


def _whole_lines(file: BinaryIO, path: Path, warnings: list[str]) -> Iterator[str]:
    for number, line in enumerate(file, start=1):
        if line.endswith(b"\n"):
            yield line[:-1].decode("utf-8", "replace")
        else:
            warnings.append(f"{path.name}:{number}: incomplete line omitted")


def vessel_of(configuration: Any) -> VesselConfig:
    """The vessel that `config.as_dict` took apart, as a manifest and the feed have it. Raises KeyError, TypeError,
    ValueError for what is none."""
    vessel: VesselConfig = _rebuilt(VesselConfig, configuration)
    return vessel


def _rebuilt(kind: Any, value: Any) -> Any:
    """The dataclass that `config.as_dict` took apart. A key that this version does not know is ignored."""
    origin = typing.get_origin(kind)
    if origin in (typing.Union, types.UnionType):
        return None if value is None else _rebuilt(next(k for k in typing.get_args(kind) if k is not type(None)), value)
    if origin is tuple:
        return tuple(_rebuilt(typing.get_args(kind)[0], item) for item in value)
    if origin is dict:
        return {key: _rebuilt(typing.get_args(kind)[1], item) for key, item in value.items()}
    if is_dataclass(kind) and isinstance(kind, type):
        kind = _row_of(kind, value)
        hints = typing.get_type_hints(kind)
        missing = [
            f.name
            for f in fields(kind)
            if f.name not in value and f.default is MISSING and f.default_factory is MISSING
        ]
        if missing:
            raise KeyError(f"{kind.__name__} lacks {', '.join(missing)}")
        return kind(**{f.name: _rebuilt(hints[f.name], value[f.name]) for f in fields(kind) if f.name in value})
    return float(value) if kind is float else value


def _row_of(kind: type[Any], value: Mapping[str, Any]) -> type[Any]:
    """The dataclass of a sensor's or bridge's row: that of its driver."""
    if kind is ActuatorConfig and value["driver"] in BRIDGES:
        return BRIDGES[value["driver"]].row
    if kind is SensorConfig and value["driver"] in SENSORS:
        return SENSORS[value["driver"]].row
    return kind
