"""The drawn house: the rooms of the program in layers, from the import graph and the contracts that hold it."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from html import escape

from docs.generate.markdown import code, table
from docs.generate.source import ROOT, Module, imports, modules

_PROGRAM = "companion"
_WIDTH, _BOX_H, _GAP, _LEFT, _TOP = 960, 44, 8, 30, 24


@dataclass(frozen=True, slots=True)
class Room:
    """A folder or file directly below the program. `uses`: the rooms that it imports."""

    name: str
    files: int
    lines: int
    uses: frozenset[str]


@cache
def rooms() -> Mapping[str, Room]:
    """Every room by its name."""
    by_room: dict[str, list[Module]] = {}
    for module in modules(_PROGRAM):
        parts = module.name.split(".")
        if len(parts) > 1:
            by_room.setdefault(parts[1], []).append(module)
    names = frozenset(by_room)
    return {
        name: Room(name, len(found), sum(module.lines for module in found), _used(found, names) - {name})
        for name, found in sorted(by_room.items())
        if name != "__main__" and sum(module.lines for module in found) > 0
    }


def _used(found: Iterable[Module], names: frozenset[str]) -> frozenset[str]:
    return frozenset(
        room for module in found for node in imports(module.tree) for room in _imported(node) if room in names
    )


def _imported(node: ast.AST) -> list[str]:
    """Rooms named by an import statement."""
    if isinstance(node, ast.ImportFrom) and node.module == _PROGRAM:
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{_PROGRAM}."):
        return [str(node.module).split(".")[1]]
    if isinstance(node, ast.Import):
        return [alias.name.split(".")[1] for alias in node.names if alias.name.startswith(f"{_PROGRAM}.")]
    return []


def layers(found: Mapping[str, Room]) -> list[list[Room]]:
    """The rooms from top to bottom, as the contract of layers in pyproject.toml has them; others above all that they
    import."""
    ordered = _contract()
    place = {name: i for i, row in enumerate(ordered) for name in row if name in found}
    for name in found.keys() - place.keys():
        below = [place[used] for used in found[name].uses if used in place]
        place[name] = max(0, min(below, default=len(ordered)) - 1)
    rows: dict[int, list[Room]] = {}
    for name, i in place.items():
        rows.setdefault(i, []).append(found[name])
    return [sorted(rows[i], key=lambda room: -room.lines) for i in sorted(rows)]


def _contract() -> list[list[str]]:
    """Layers of the first contract of that type, top first, as names of rooms."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    rows: Sequence[str] = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    return [[part.strip().removeprefix(f"{_PROGRAM}.") for part in row.replace(":", "|").split("|")] for row in rows]


# --- drawing -------------------------------------------------------------------------------------------------------


def house() -> str:
    """The SVG: a strip for each layer, shared by its rooms."""
    shapes: list[str] = []
    y = _TOP
    for row in layers(rooms()):
        width = (_WIDTH + _GAP) / len(row)
        shapes += [_box(room, _LEFT + i * width, y, width - _GAP) for i, room in enumerate(row)]
        y += _BOX_H + _GAP
    return _SVG.format(width=_LEFT + _WIDTH + _GAP, height=y + 10, arrow_end=y - 14, shapes="\n".join(shapes))


def _box(room: Room, x: float, y: int, width: float) -> str:
    uses = escape(", ".join(sorted(room.uses)) or "none of the rooms")
    files = "1 file" if room.files == 1 else f"{room.files} files"
    return (
        f"<g><title>{escape(room.name)} imports {uses}</title>"
        f'<rect x="{x:.0f}" y="{y}" width="{width:.0f}" height="{_BOX_H}" rx="5" class="box"/>'
        f'<text x="{x + 10:.0f}" y="{y + 19}" class="name">{escape(room.name)}</text>'
        f'<text x="{x + 10:.0f}" y="{y + 36}" class="count">{files}, {room.lines} lines</text></g>'
    )


_SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" aria-label="Rooms of the
program in layers">
<style>
.box {{ fill: #e8eef7; stroke: #3f51b5; }}
.name {{ font: bold 15px sans-serif; fill: #1a237e; }}
.count {{ font: 12px sans-serif; fill: #37474f; }}
.side {{ font: 12px sans-serif; fill: #607d8b; }}
.line {{ stroke: #607d8b; stroke-width: 2; }}
</style>
<line x1="12" y1="24" x2="12" y2="{arrow_end}" class="line"/>
<path d="M 7 {arrow_end} l 10 0 l -5 8 z" fill="#607d8b"/>
<text x="6" y="14" class="side">imports point down</text>
{shapes}
</svg>
"""


def rooms_table() -> str:
    """The rooms, top first: files, lines, how many rooms each imports and is imported by."""
    found = rooms()
    used_by = {name: sum(name in room.uses for room in found.values()) for name in found}
    rows = (
        (code(room.name), str(room.files), str(room.lines), str(len(room.uses)), str(used_by[room.name]))
        for row in layers(found)
        for room in row
    )
    return table(("room", "files", "lines", "imports rooms", "imported by rooms"), rows)
