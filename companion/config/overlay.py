"""Overlays: what a sea trial found, in a file beside the vessel's own, which stays as it is.

`NAME.trial-2026-11-22.toml` beside `NAME.toml` counts while its `[trial]` table says `accepted = true`; of several, the
one with the last name. One that has parameters alone leaves the model to the one before it. To undo it, `accepted`
becomes false, and the one before counts again.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

_ACCEPTED = re.compile(r"^accepted *= *(true|false)", re.MULTILINE)
_MARK = ".trial-"
_LETTERS = "bcdefghijklmnopqrstuvwxyz"


def is_overlay(name: str) -> bool:
    """Whether a file of that name is an overlay."""
    return _MARK in name and name.endswith(".toml")


def overlay_name(vessel: str, date: str) -> str:
    """The file name of an overlay of that vessel file's stem; `date`: 2026-11-22."""
    return f"{vessel}{_MARK}{date}.toml"


def free_place(folder: Path, vessel: str, date: str) -> Path:
    """Where a new overlay of that day goes, so that no other is overwritten and its name is the last of all: the
    second trial of a day is `2026-11-22b`."""
    names = (overlay_name(vessel, date + letter) for letter in ("", *_LETTERS))
    return next((place for name in names if not (place := folder / name).exists()), folder / overlay_name(vessel, date))


def copy_beside(overlay: Path, vessel_file: Path) -> Path:
    """Copy an overlay of another folder beside a vessel's file, unless it is there, and return its place. Another of
    the same day stays as it is. Raises OSError."""
    text = overlay.read_text(encoding="utf-8")
    for there in overlays(vessel_file):
        if _not_accepted(there.read_text(encoding="utf-8")) == _not_accepted(text):
            return there
    place = free_place(vessel_file.parent, vessel_file.stem, overlay.name.split(_MARK)[1].removesuffix(".toml"))
    place.write_text(text, encoding="utf-8")
    return place


def _not_accepted(text: str) -> str:
    return _ACCEPTED.sub("accepted = false", text, count=1)


def overlays(vessel_file: Path) -> tuple[Path, ...]:
    """All overlays beside a vessel's file, the oldest first."""
    return tuple(sorted(vessel_file.parent.glob(f"{vessel_file.stem}{_MARK}*.toml")))


def accepted(overlay: Path) -> bool:
    """Whether it counts. Raises OSError."""
    found = _ACCEPTED.search(overlay.read_text(encoding="utf-8-sig"))
    return found is not None and found[1] == "true"


def in_force(vessel_file: Path) -> Path | None:
    """The overlay that counts for a vessel's file; None without one. Raises OSError."""
    return next((overlay for overlay in reversed(overlays(vessel_file)) if accepted(overlay)), None)


def that_count(vessel_file: Path) -> tuple[Path, ...]:
    """The one in force; before it, where it has no model, the accepted ones that it leaves the model to, the oldest
    first. Raises OSError."""
    found: list[Path] = []
    for overlay in reversed(overlays(vessel_file)):
        if accepted(overlay):
            found.insert(0, overlay)
            if _has_model(overlay):
                break
    return tuple(found)


def parameters_that_count(vessel_file: Path) -> dict[str, float]:
    """The parameters of the overlays that count. Raises OSError; ValueError for one that is no TOML."""
    found: dict[str, float] = {}
    for overlay in that_count(vessel_file):
        found |= tomllib.loads(overlay.read_text(encoding="utf-8-sig")).get("parameters", {})
    return found


def _has_model(overlay: Path) -> bool:
    """Whether it has more than parameters; true for one that cannot be read, which says so when it is loaded."""
    try:
        tables = tomllib.loads(overlay.read_text(encoding="utf-8-sig"))
    except tomllib.TOMLDecodeError:
        return True
    return bool(tables.keys() - {"trial", "parameters"})


def proposed(vessel_file: Path) -> Path | None:
    """The newest overlay, if nobody has accepted it and it holds more than `[trial]`; else None. Raises OSError."""
    newest = next(reversed(overlays(vessel_file)), None)
    if newest is None or accepted(newest):
        return None
    try:
        tables = tomllib.loads(newest.read_text(encoding="utf-8-sig"))
    except tomllib.TOMLDecodeError:
        return None
    return newest if tables.keys() - {"trial"} else None


def set_accepted(overlay: Path, counts: bool) -> None:
    """Let it count, or not. Raises OSError, ValueError for a file without the key."""
    text = overlay.read_text(encoding="utf-8-sig")
    if _ACCEPTED.search(text) is None:
        raise ValueError(f"{overlay}: no key 'accepted' in [trial], so it is no overlay of a trial")
    new = _ACCEPTED.sub(f"accepted = {'true' if counts else 'false'}", text, count=1)
    beside = overlay.with_suffix(".new")
    beside.write_text(new, encoding="utf-8")
    beside.replace(overlay)


def merged(data: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`data` with the keys of `over` in place of its own. Rows of an array of tables are matched by their `name`."""
    result = dict(data)
    for key, value in over.items():
        here = result.get(key)
        if isinstance(value, Mapping) and isinstance(here, Mapping):
            result[key] = merged(here, value)
        elif isinstance(value, list) and isinstance(here, list) and all(isinstance(row, Mapping) for row in value):
            rows = {row["name"]: row for row in value if "name" in row}
            result[key] = [merged(row, rows.get(row.get("name"), {})) for row in here]
        else:
            result[key] = value
    return result


def with_overlay(data: Mapping[str, Any], overlay: Path) -> dict[str, Any]:
    """The raw tables of a vessel with those of its overlay. Raises OSError, tomllib.TOMLDecodeError."""
    over = tomllib.loads(overlay.read_text(encoding="utf-8-sig"))
    return merged(data, {key: value for key, value in over.items() if key != "trial"})
