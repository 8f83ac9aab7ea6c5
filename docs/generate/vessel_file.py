"""vessel-file.md: every table and key of a vessel's file and of a leader module's."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any

from companion.config.actuators import BRIDGES
from companion.config.devices import ActuatorConfig, SensorConfig
from companion.config.kinds import BridgeKind, SensorKind
from companion.config.sensors import SENSORS
from companion.config.vessel import VesselConfig
from companion.io.actuators import DRIVERS as ACTUATOR_DRIVERS
from companion.io.sensors import DRIVERS as SENSOR_DRIVERS
from companion.leader_module.config import LeaderConfig
from docs.generate.keys import Key, keys
from docs.generate.markdown import code, page, section, sentence, summary, table

_INTRODUCTION = """A vessel is one TOML file. `companion check FILE` lists every error with its line.

Angles are in degrees in the file; everything else is in SI units. The unit stands at the end of a key's name.
x points ahead, y to starboard, z down, from the middle of the boat. An empty default means that the key can be left
out.

A table in double brackets, such as `[[thruster]]`, can stand several times."""

_LEADER = """The file of the module on a lead boat, for `companion leader FILE`."""


def vessel_file() -> str:
    """The page."""
    return page(
        "Vessel file",
        _INTRODUCTION,
        section(2, "Vessel", *_tables(VesselConfig)),
        section(2, "Sensor drivers", _drivers(SENSOR_DRIVERS), *_own_keys("sensor", SensorConfig, SENSORS)),
        section(2, "Bridge drivers", _drivers(ACTUATOR_DRIVERS), *_own_keys("actuator", ActuatorConfig, BRIDGES)),
        section(
            2, "Leader module", _LEADER, *_tables(LeaderConfig, but=_known(VesselConfig), prefix="Leader module: ")
        ),
    )


def _tables(root: type[Any], but: frozenset[type[Any]] = frozenset(), prefix: str = "") -> Iterator[str]:
    yield section(3, f"{prefix}top level" if prefix else "Top level", _rows(root))
    for title, kind in _walk(root):
        text = sentence(summary(kind))
        if kind in but:
            yield section(3, f"{prefix}`{title}`", f"{text} The keys are those of the vessel file, above.")
        else:
            yield section(3, f"{prefix}`{title}`", text, _rows(kind))


def _own_keys(name: str, base: type[Any], kinds: Mapping[str, BridgeKind] | Mapping[str, SensorKind]) -> Iterator[str]:
    """Keys that only one driver has, and the tables below them."""
    common = {key.name for key in keys(base)}
    for driver, row in {driver: kind.row for driver, kind in kinds.items()}.items():
        own = [key for key in keys(row) if key.name not in common]
        if own:
            text = sentence(summary(row))
            yield section(3, f"`[[{name}]]` with driver `{driver}`", text, _table(own))
            for title, kind in _walk(row, name, common):
                yield section(3, f"`{title}`", sentence(summary(kind)), _rows(kind))


def _known(root: type[Any]) -> frozenset[type[Any]]:
    return frozenset(kind for _, kind in _walk(root))


def _walk(root: type[Any], path: str = "", but: Collection[str] = ()) -> Iterator[tuple[str, type[Any]]]:
    """Every table below `root`, with its title as the file has it, each kind once under its first place. `path`: that
    of `root`; `but`: keys of it to leave out."""
    seen: set[type[Any]] = set()

    def below(kind: type[Any], path: str) -> Iterator[tuple[str, type[Any]]]:
        for key in keys(kind):
            if key.table is None or (kind is root and key.name in but):
                continue
            place = f"{path}.{key.name}" if path else key.name
            place += ".NAME" if key.named else ""
            if key.table not in seen:
                seen.add(key.table)
                yield (f"[[{place}]]" if key.several else f"[{place}]"), key.table
                yield from below(key.table, place)

    return below(root, path)


def _rows(kind: type[Any]) -> str:
    return _table(keys(kind))


def _table(shown: Iterable[Key]) -> str:
    return table(("key", "type", "unit", "meaning", "default"), (_row(key) for key in shown))


def _row(key: Key) -> tuple[str, ...]:
    return code(key.name), key.kind, key.unit, sentence(key.meaning), key.default


def _drivers(drivers: Mapping[str, Callable[..., Any]]) -> str:
    return table(
        ("driver", "what it is"),
        ((code(name), sentence(summary(inspect.getmodule(driver)))) for name, driver in sorted(drivers.items())),
    )
