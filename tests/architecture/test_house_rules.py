"""Rules of the house that import-linter does not know."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted(path for room in ("companion", "sitl", "gcs_plugins") for path in (ROOT / room).rglob("*.py"))
PURE = ("core", "nav", "guidance", "control", "allocation", "mission", "modes")


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_file_fits_on_a_few_pages(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 440


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_untracked_todo(path: Path) -> None:
    assert not re.search(r"\b(TODO|FIXME|XXX)\b", path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", [p for p in SOURCES if p.name != "__init__.py"], ids=lambda path: str(path.relative_to(ROOT)))
def test_every_file_says_what_it_is(path: Path) -> None:
    assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    "path", [p for p in SOURCES if p.parts[-2] in PURE and p.parts[-3] == "companion"], ids=lambda path: str(path.relative_to(ROOT))
)
def test_nothing_below_the_wiring_asks_whether_it_is_simulated(path: Path) -> None:
    code = re.sub(r'"""[\s\S]*?"""|#.*', "", path.read_text(encoding="utf-8"))
    assert not re.search(r"\benviron\b|\bgetenv\b|\bsitl\b|\bis_simulat|\bsimulated\b", code, re.IGNORECASE)


def test_the_top_level_is_as_agreed() -> None:
    allowed = {"companion", "gcs_plugins", "mission_files", "sitl", "tests", "README.md", "pyproject.toml", "Makefile", "LICENSE"}
    made = {"out", "build", "dist"}
    assert {path.name for path in ROOT.iterdir() if not path.name.startswith(".")} - made <= allowed
