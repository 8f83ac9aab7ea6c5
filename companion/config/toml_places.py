"""The line of a key in a TOML file, for messages to the person who edits it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence


def dotted(loc: Sequence[str | int]) -> str:
    """('thruster', 1, 'max_n') → 'thruster[2].max_n': people count from one."""
    text = ""
    for part in loc:
        text += f"[{part + 1}]" if isinstance(part, int) else f".{part}" if text else part
    return text or "file"


def line_of(lines: Sequence[str], loc: Sequence[str | int]) -> int | None:
    """Line number (from 1) of the key at `loc`, or of the innermost table above it that the file has; None if it has
    none."""
    counts: dict[tuple[str | int, ...], int] = {}
    prefix: tuple[str | int, ...] = ()
    best: tuple[int, int] | None = None  # (parts matched, line)
    for number, raw in enumerate(lines, start=1):
        line = raw.strip()
        if header := re.match(r"^\[\[\s*([^\]]+?)\s*\]\]", line):
            name = _within(header[1].split("."), counts)
            counts[name] = counts.get(name, -1) + 1
            prefix = (*name, counts[name])
        elif header := re.match(r"^\[\s*([^\]]+?)\s*\]", line):
            prefix = _within(header[1].split("."), counts)
        elif key := re.match(r"^([A-Za-z0-9_.\-\"']+)\s*=", line):
            found = (*prefix, *(part.strip("\"'") for part in key[1].split(".")))
            matched = len(found) if tuple(loc[: len(found)]) == found else 0
            if matched and (best is None or matched > best[0]):
                best = (matched, number)
            continue
        else:
            continue
        if tuple(loc) == prefix[:-1] and best is None:  # a list as a whole: its first row
            best = (len(loc), number)
        if tuple(loc[: len(prefix)]) == prefix and (best is None or len(prefix) > best[0]):
            best = (len(prefix), number)
    return best[1] if best else None


def _within(parts: Sequence[str], counts: Mapping[tuple[str | int, ...], int]) -> tuple[str | int, ...]:
    """The path of a table; one below an array of tables belongs to the array's last element."""
    path: tuple[str | int, ...] = ()
    for part in parts:
        path = (*path, counts[path], part) if path in counts else (*path, part)
    return path
