"""The keys of a TOML file from the dataclasses that it is read into: name, type, unit, meaning, default."""

from __future__ import annotations

import math
import types
import typing
from collections.abc import Iterator
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from typing import Any, Literal, get_args, get_origin, get_type_hints

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import TypeAdapter
from pydantic.fields import FieldInfo

from companion.config.fields import DERIVED
from companion.config.units import unit_of
from docs.generate.markdown import code, number

_WORDS = {str: "text", bool: "true or false", int: "whole number", float: "number"}
_SIGNS = {Ge: ("≥", "ge"), Gt: (">", "gt"), Le: ("≤", "le"), Lt: ("<", "lt")}
REQUIRED = "**required**"
FILLED_IN = "from other keys"


class UndescribedKey(Exception):
    """A key without a meaning: its dataclass and field."""


@dataclass(frozen=True, slots=True)
class Key:
    """One key of a table, as the page has it. `tables`: the dataclass of a key that is itself a table, and whether
    there may be several."""

    name: str
    kind: str
    unit: str
    meaning: str
    default: str
    table: type[Any] | None
    several: bool
    named: bool  # a table of tables by name


def keys(table: type[Any]) -> Iterator[Key]:
    """The keys of a table in the order of its dataclass. Raises UndescribedKey."""
    hints = get_type_hints(table, include_extras=True)
    for entry in fields(table):
        if entry.name == "others":
            continue  # what a row has for another driver is no key of its own
        yield _key(table, entry, hints[entry.name])


def _key(table: type[Any], entry: Field[Any], hint: Any) -> Key:
    plain, infos = _unwrapped(hint)
    meaning = next((info.description for info in infos if info.description), None)
    if meaning is None:
        raise UndescribedKey(f"{table.__module__}.{table.__name__}.{entry.name} has no meaning: give it means(…)")
    name = next((info.alias for info in infos if info.alias), entry.name)
    inner, several, named = _table_of(plain)
    kind = _kind(plain)
    if inner is None and (limits := _limits(infos)):
        kind = f"{kind}, {limits}"
    unit = unit_of(name) if "number" in kind else ""
    default = FILLED_IN if any(_is_derived(info) for info in infos) else _default(entry, name, inner)
    return Key(name, kind, unit, meaning, default, inner, several, named)


def _is_derived(info: FieldInfo) -> bool:
    extra = info.json_schema_extra
    return isinstance(extra, dict) and DERIVED in extra


def _unwrapped(hint: Any) -> tuple[Any, list[FieldInfo]]:
    """The bare type, and what stands in Annotated around it and around the type within `… | None`."""
    infos: list[FieldInfo] = []
    if get_origin(hint) is typing.Annotated:
        hint, *extras = get_args(hint)
        infos += [extra for extra in extras if isinstance(extra, FieldInfo)]
    if get_origin(hint) in (types.UnionType, typing.Union):
        parts = [part for part in get_args(hint) if part is not type(None)]
        if len(parts) == 1:
            inner, more = _unwrapped(parts[0])
            return inner, infos + more
    return hint, infos


def _table_of(plain: Any) -> tuple[type[Any] | None, bool, bool]:
    """The dataclass of a key that is a table; whether it is one of several; whether it has a name."""
    arguments = [_unwrapped(argument)[0] for argument in get_args(plain)]
    if _is_table(plain):
        return plain, False, False
    if get_origin(plain) is tuple and _is_table(arguments[0]):
        return arguments[0], True, False
    if get_origin(plain) is dict and _is_table(arguments[1]):
        return arguments[1], False, True
    return None, False, False


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and is_dataclass(kind)


def _kind(plain: Any) -> str:
    plain, _ = _unwrapped(plain)
    if plain in _WORDS:
        return _WORDS[plain]
    if _is_table(plain):
        return "table"
    origin, arguments = get_origin(plain), get_args(plain)
    if origin is Literal:
        return ", ".join(code(f'"{value}"' if isinstance(value, str) else value) for value in arguments)
    if origin in (types.UnionType, typing.Union):
        return " or ".join(_kind(part) for part in arguments if part is not type(None))
    if origin is dict:
        return "table"
    if origin is tuple and len(arguments) == 2 and arguments[1] is Ellipsis:
        return "tables" if _is_table(_unwrapped(arguments[0])[0]) else f"list of {_plural(_kind(arguments[0]))}"
    if origin is tuple:
        return f"list of {len(arguments)}: {_plural(_kind(arguments[0]))}"
    raise UndescribedKey(f"no words for the type {plain}")


def _plural(kind: str) -> str:
    return {"number": "numbers", "whole number": "whole numbers", "text": "texts"}.get(kind, kind)


def _limits(infos: list[FieldInfo]) -> str:
    rules = [rule for info in infos for rule in info.metadata]
    bounds = {
        kind: getattr(rule, name) for rule in rules for kind, (_, name) in _SIGNS.items() if isinstance(rule, kind)
    }
    if set(bounds) == {Ge, Le}:
        parts = [f"{number(bounds[Ge])} to {number(bounds[Le])}"]
    else:
        parts = [f"{_SIGNS[kind][0]} {number(bound)}" for kind, bound in bounds.items()]
    parts += [f"{rule.min_length} or more" for rule in rules if isinstance(rule, MinLen)]
    parts += [f"at most {rule.max_length}" for rule in rules if isinstance(rule, MaxLen)]
    return ", ".join(parts)


def _default(entry: Field[Any], name: str, inner: type[Any] | None) -> str:
    if entry.default is MISSING and entry.default_factory is MISSING:
        return REQUIRED
    value = entry.default if entry.default is not MISSING else ()
    if value is None or value == () or inner is not None:
        return ""
    if isinstance(value, bool):
        return code(str(value).lower())
    if isinstance(value, (int, float)):
        in_degrees = entry.name != name and isinstance(value, float)
        return number(math.degrees(value) if in_degrees else value)
    return code(_toml(value))


def _toml(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, str):
        return f'"{value}"'
    return "[" + ", ".join(_toml(part) for part in value) + "]" if isinstance(value, tuple) else f"{value:g}"


def schema(table: type[Any]) -> dict[str, Any]:
    """The JSON schema of a file, for editors that check TOML as it is written."""
    found = TypeAdapter(table).json_schema()
    for part in (found, *found.get("$defs", {}).values()):
        if "required" in part:
            optional = {name for name, row in part["properties"].items() if row.pop(DERIVED, False)}
            part["required"] = [name for name in part["required"] if name not in optional]
    return found
