"""What a driver says of its row in a file: the dataclass that the row is read into, and checks beyond the types.

The tables of drivers are in `companion.config.actuators` and `companion.config.sensors`. pydantic reads each row into
the dataclass of its driver (`ByDriver`), so that the keys of a driver stand beside the keys of every bridge or sensor.
"""

from __future__ import annotations

import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter, ValidatorFunctionWrapHandler
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from companion.config.devices import OTHER_KEYS, ActuatorConfig, SensorConfig, ThrusterConfig
from companion.config.outputs import ServoConfig

Place = tuple[str | int, ...]
"""Where something stands in a file: ("actuator", 1, "port") is the port of the second bridge."""

Problem = tuple[Place, str]
"""What is wrong and what to do, with its place."""


@dataclass(frozen=True, slots=True)
class Equipment:
    """What the checks of a bridge look at beside its own row."""

    thrusters: Sequence[ThrusterConfig]
    bridges: Sequence[ActuatorConfig]
    servos: Sequence[ServoConfig]


@dataclass(frozen=True, slots=True)
class BridgeKind:
    """A bridge driver's part of the file.

    `row`: the dataclass of its row. `problems(row, place of the row, equipment)`: what its types cannot check.
    `pulses`: `[thruster.output]` of its thrusters is in µs of servo pulses, otherwise in a share −1…1.
    """

    row: type[ActuatorConfig] = ActuatorConfig
    problems: Callable[[Any, Place, Equipment], list[Problem]] = lambda row, at, equipment: []
    pulses: bool = False


@dataclass(frozen=True, slots=True)
class SensorKind:
    """A sensor driver's part of the file: the dataclass of its row, and `problems(row, place of the row)`. `inertial`:
    it gives accelerations and rates; `averages`: each is the mean since the one before, not the newest value."""

    row: type[SensorConfig] = SensorConfig
    problems: Callable[[Any, Place], list[Problem]] = lambda row, at: []
    inertial: bool = False
    averages: bool = False


Kinds = Mapping[str, BridgeKind] | Mapping[str, SensorKind]


class ByDriver:
    """Annotation of a row: pydantic reads it into the dataclass that its driver has in the table.

    Keys of another driver go to `others`, for `foreign_problems`. A driver that is not in the table may be a plug-in:
    all keys that not every row has go to `others`, for `completed`.
    """

    def __init__(self, kinds: Kinds) -> None:
        self._kinds = kinds

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        """The hook by which pydantic asks how to read the row."""
        base: Any = source

        def read(row: Any, by_base: ValidatorFunctionWrapHandler) -> Any:
            driver = row.get("driver") if isinstance(row, dict) else None
            if not isinstance(driver, str):
                return by_base(row)
            kind = self._kinds.get(driver)
            kind_row: Any = base if kind is None else kind.row
            apart = {key for key in row if key not in keys(kind_row) and (kind is None or self._known(key))}
            found = _reader(kind_row).validate_python({key: value for key, value in row.items() if key not in apart})
            return replace(found, others=tuple((key, row[key]) for key in row if key in apart))

        return core_schema.no_info_wrap_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The schema that editors check a file by: the row of any driver."""
        rows: list[Any] = list(dict.fromkeys(kind.row for kind in self._kinds.values()))
        found = [handler.resolve_ref_schema(handler(_reader(row).core_schema)) for row in rows]
        for row_schema in found:
            del row_schema["properties"][OTHER_KEYS]
        return {"anyOf": found}

    def _known(self, key: str) -> bool:
        rows: list[Any] = [kind.row for kind in self._kinds.values()]
        return any(key in keys(row) for row in rows)


def foreign_problems(row: ActuatorConfig | SensorConfig, at: Place, kinds: Kinds) -> list[Problem]:
    """Keys of a row that belong to other drivers of the table."""
    problems: list[Problem] = []
    rows: dict[str, Any] = {name: kind.row for name, kind in kinds.items()}
    for key, _ in row.others:
        owners = " or ".join(f"'{name}'" for name, kind_row in rows.items() if key in keys(kind_row))
        problems.append(((*at, key), f"only for the driver {owners}, not '{row.driver}'"))
    return problems


R = typing.TypeVar("R", ActuatorConfig, SensorConfig)


def completed(row: R, kind_row: type[R]) -> R:
    """A row whose driver was not in the table, as the dataclass that its plug-in declares. Raises pydantic's
    ValidationError for keys that it does not have, or values that it does not take."""
    needed = {"name": row.name, "driver": row.driver, "port": row.port}
    reader: Any = kind_row  # mypy takes a class with slots for one that cannot be hashed
    found: R = _reader(reader).validate_python({**needed, **dict(row.others)})
    common = {field.name: getattr(row, field.name) for field in fields(row) if field.name != "others"}
    return replace(found, **common)


@cache
def keys(kind_row: Any) -> frozenset[str]:
    """The keys of a row in the file, as its dataclass has them."""
    hints = typing.get_type_hints(kind_row, include_extras=True)
    names = set()
    for field in fields(kind_row):
        infos = [info for info in getattr(hints[field.name], "__metadata__", ()) if isinstance(info, FieldInfo)]
        names.add(next((info.alias for info in infos if info.alias), field.name))
    return frozenset(names)


@cache
def _reader(kind_row: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind_row)
