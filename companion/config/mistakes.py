"""Mistakes in a file, in the words of a person who edits it: what a missing key means, which key a misspelt one is."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from difflib import get_close_matches
from functools import cache
from typing import Any, get_args, get_origin, get_type_hints

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from companion.config.kinds import Place, Problem
from companion.config.units import unit_of

MISSING = "is missing"  # how a problem of a key that is not there begins
_NOTHING = object()
_ALIKE = 0.6  # of difflib: what one would take for the same word
_REMEDIES = (  # what pydantic says, and what it means for the file
    ("Unexpected keyword argument", "unknown key; check the spelling"),
    ("String should match pattern '^[a-z][a-z0-9_]{0,31}$'", "should be small letters, digits and _, from a letter on"),
    ("Input should be a valid tuple", "should be a list in square brackets"),
    ("Input should be a valid string", "should be text in quotes"),
    ("Input should be a valid number, unable to parse string as a number", "should be a number, without quotes"),
    ("Input should", "should"),
)


def problems_of(
    root: type[Any],
    error: ValidationError,
    data: Mapping[str, Any],
    moot: Sequence[Place] = (),
    known: Sequence[Problem] = (),
) -> list[Problem]:
    """The problems of a file, without those that are only the consequence of another: a missing key whose name was
    misspelt, missing keys below a place in `moot`, and a list that lacks only the entries that are wrong. `data`: the
    file as it stands. `known`: what was found already; it comes first, and is not said twice."""
    found = [(tuple(e["loc"]), e["type"], e["msg"]) for e in error.errors()]
    lacking = [place for place, text in known if text.startswith(MISSING)]
    missing = [place for place, kind, _ in found if kind == "missing" and not _below(place, moot)] + lacking
    unknown = {place: _near(root, place, missing) for place, kind, _ in found if kind == "unexpected_keyword_argument"}
    meant = {(*place[:-1], near) for place, near in unknown.items() if near is not None}
    said = {place for place, _ in known}
    elsewhere = {place[-1:] for place in lacking}  # length and beam stand at the top or in `[hull]`
    wrong = [place for place, _, _ in found if _stands(data, place)]
    problems = [
        (place, text) for place, text in known if place not in lacking or not {place, place[-1:]}.intersection(meant)
    ]
    for place, kind, text in found:
        if place in said or (_is_derived(data, place, kind) and any(place[:-1] == other[:-1] for other in wrong)):
            continue
        if kind == "missing" and (place in meant or place in elsewhere or _below(place, moot)):
            continue
        if kind == "too_short" and any(other != place and _below(other, [place]) for other, _, _ in found):
            continue
        if _is_one_table(data, place, kind):
            if place not in meant:  # else it is [actuator.mavlink] below a row that was misspelt as [[actuators]]
                problems.append((place, f"is a list of tables: each begins with [[{_header(place)}]]"))
        elif kind == "missing":
            problems.append((place, _missing(root, place)))
        else:
            problems.append((place, _unknown(unknown[place]) if place in unknown else remedy(text)))
    return problems


def _stands(data: Mapping[str, Any], place: Place) -> bool:
    """Whether the file itself has something at a place."""
    return _at(data, place) is not _NOTHING


def _at(data: Mapping[str, Any], place: Place) -> Any:
    """What the file itself has at a place, or `_NOTHING`."""
    inner: Any = data
    try:
        for part in place:
            inner = inner[part]
    except (LookupError, TypeError):
        return _NOTHING
    return inner


def _is_one_table(data: Mapping[str, Any], place: Place, kind: str) -> bool:
    """Whether the file has one table where it should have rows."""
    return kind == "tuple_type" and isinstance(_at(data, place), Mapping)


def _header(place: Place) -> str:
    """What stands in the brackets of a row."""
    return ".".join(part for part in place if isinstance(part, str))


def _is_derived(data: Mapping[str, Any], place: Place, kind: str) -> bool:
    """Whether a wrong value was made of others: it does not stand in the file, nor is it missing."""
    return kind != "missing" and not _stands(data, place)


def remedy(message: str) -> str:
    """pydantic's message in the words of a person who edits a TOML."""
    for said, plain in _REMEDIES:
        message = message.replace(said, plain)
    return message


def _below(place: Place, moot: Sequence[Place]) -> bool:
    return any(place[: len(above)] == above for above in moot)


def _missing(root: type[Any], place: Place) -> str:
    entry = _entries_at(root, place[:-1]).get(str(place[-1]))
    if entry is None:
        return MISSING
    unit = unit_of(str(place[-1]))
    meaning = entry.rstrip(".")
    if not meaning[1:2].isupper():  # MAVLink, GNSS and other names keep their capitals
        meaning = meaning[:1].lower() + meaning[1:]
    return f"{MISSING}: {meaning}{f', in {unit}' if unit else ''}"


def _unknown(near: str | None) -> str:
    return f"unknown key; did you mean '{near}'?" if near is not None else "unknown key; check the spelling"


def _near(root: type[Any], place: Place, missing: Sequence[Place]) -> str | None:
    """The key that was meant: one that is missing in the same table first."""
    wrong = str(place[-1])
    absent = [str(other[-1]) for other in missing if other[:-1] == place[:-1]]
    for names in (absent, list(_entries_at(root, place[:-1]))):
        if close := get_close_matches(wrong, names, n=1, cutoff=_ALIKE):
            return close[0]
    return None


def _entries_at(root: type[Any], place: Place) -> Mapping[str, str]:
    table: Any = _table(root, place)
    return _entries(table)


def _table(root: type[Any], place: Place) -> type[Any] | None:
    """The dataclass of the table at `place`; None where it is none."""
    table: Any = root
    for part in place:
        if isinstance(part, int):
            continue
        if table is None:
            return None
        table = _inner(table).get(part, table if _is_mapping(table, part) else None)
    found: type[Any] | None = table
    return found


@cache
def _inner(table: Any) -> Mapping[str, type[Any]]:
    """The tables below a table, by key."""
    found = {}
    for name, hint in _hints(table):
        inner = _dataclass_in(hint)
        if inner is not None:
            found[name] = inner
    return found


def _is_mapping(table: type[Any], part: str) -> bool:
    """Whether `part` is a name that the file chose, as of a plant, and no key of the table."""
    known: Any = table
    return part not in _entries(known)


@cache
def _entries(table: Any) -> Mapping[str, str]:
    """Meaning by key of a table."""
    if table is None:
        return {}
    return {
        name: next((info.description for info in _infos(hint) if info.description), "")
        for name, hint in _hints(table)
        if not name.startswith("keys of")
    }


def _hints(table: type[Any]) -> list[tuple[str, Any]]:
    hints = get_type_hints(table, include_extras=True)
    return [
        (next((info.alias for info in _infos(hints[entry.name]) if info.alias), entry.name), hints[entry.name])
        for entry in fields(table)
    ]


def _infos(hint: Any) -> list[FieldInfo]:
    infos: list[FieldInfo] = []
    if get_origin(hint) is typing.Annotated:
        hint, *extras = get_args(hint)
        infos += [extra for extra in extras if isinstance(extra, FieldInfo)]
    if get_origin(hint) in (types.UnionType, typing.Union):
        for part in get_args(hint):
            infos += _infos(part)
    return infos


def _dataclass_in(hint: Any) -> type[Any] | None:
    """The dataclass that a hint holds, through Annotated, unions, tuples and mappings."""
    if isinstance(hint, type) and is_dataclass(hint):
        return hint
    for part in get_args(hint):
        if not isinstance(part, FieldInfo) and (found := _dataclass_in(part)) is not None:
            return found
    return None
