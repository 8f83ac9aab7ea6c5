"""The walks through the program name functions that are there, in an order that never goes up again."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WALKS = ("docs/inside/walk-fix.md", "docs/inside/walk-mission-item.md")
_MOST_LINES = 110  # two pages


@cache
def names_in(file: Path) -> frozenset[str]:
    """Classes, functions, and methods as `Class.method` and `method`."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.ClassDef):
            found.add(node.name)
            found |= {f"{node.name}.{part.name}" for part in node.body if isinstance(part, ast.FunctionDef)}
    return frozenset(found)


def tables(page: str) -> Iterator[list[tuple[list[Path], list[str]]]]:
    """The tables of a page: for each row its files, and the names in its second column."""
    rows: list[tuple[list[Path], list[str]]] = []
    for line in [*(ROOT / page).read_text(encoding="utf-8").splitlines(), ""]:
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("|") else []
        if len(cells) == 3 and "companion/" in cells[0]:
            rows.append(
                ([ROOT / name for name in re.findall(r"`([^`]+)`", cells[0])], re.findall(r"`([^`]+)`", cells[1]))
            )
        elif not cells and rows:
            yield rows
            rows = []


@cache
def layers() -> dict[str, int]:
    """Height of each room, by the import contract: 0 is the top."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    rows = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    return {room.strip(): height for height, row in enumerate(rows) for room in row.split("|")}


def height(file: Path) -> int:
    parts = file.relative_to(ROOT).with_suffix("").parts
    return layers()[".".join(parts[:2])]


@pytest.mark.parametrize("page", WALKS)
def test_each_step_names_what_is_there(page: str) -> None:
    steps = [row for table in tables(page) for row in table]
    assert len(steps) >= 15
    for files, names in steps:
        there = frozenset[str]().union(*(names_in(file) for file in files))
        assert names and not set(names) - there, f"{page}: {files}: {set(names) - there}"


@pytest.mark.parametrize("page", WALKS)
def test_no_step_goes_up_again(page: str) -> None:
    for table in tables(page):
        heights = [height(file) for files, _ in table for file in files]
        assert heights == sorted(heights), f"{page}: {[str(files[0].relative_to(ROOT)) for files, _ in table]}"


@pytest.mark.parametrize("page", WALKS)
def test_a_walk_fits_on_two_pages(page: str) -> None:
    assert len((ROOT / page).read_text(encoding="utf-8").splitlines()) <= _MOST_LINES
