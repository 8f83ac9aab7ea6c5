"""Rules of the house that import-linter does not know."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.architecture.measures import LONGEST, ROOMS, ROOT, long_functions, parsed, sources, undocumented

SOURCES = sources(*ROOMS)
PURE = (
    "core", "nav", "guidance", "control", "allocation", "mission", "following", "fence", "baselines", "positioning", "payload",
    "traffic", "modes", "supervisor",
)  # fmt: skip


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_a_function_fits_on_a_page(path: Path) -> None:
    assert not long_functions(parsed(path)), f"at most {LONGEST} lines"


@pytest.mark.parametrize("path", sources("companion"), ids=name_of)
def test_what_is_public_has_a_docstring(path: Path) -> None:
    assert not undocumented(parsed(path))


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_no_untracked_todo(path: Path) -> None:
    assert not re.search(r"\b(TODO|FIXME|XXX)\b", path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", [p for p in SOURCES if p.name != "__init__.py"], ids=name_of)
def test_every_file_says_what_it_is(path: Path) -> None:
    assert ast.get_docstring(parsed(path))


@pytest.mark.parametrize(
    "path", [p for p in SOURCES if p.relative_to(ROOT).parts[:2] in {("companion", room) for room in PURE}], ids=name_of
)
def test_nothing_below_the_wiring_asks_whether_it_is_simulated(path: Path) -> None:
    code = re.sub(r'"""[\s\S]*?"""|#.*', "", path.read_text(encoding="utf-8"))
    assert not re.search(r"\benviron\b|\bgetenv\b|\bsitl\b|\bis_simulat|\bsimulated\b", code, re.IGNORECASE)


def test_the_top_level_is_as_agreed() -> None:
    rooms = {"companion", "docs", "gcs_plugins", "mission_files", "sitl", "tests"}
    pages = {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "LICENSE"}
    tools = {"pyproject.toml", "uv.lock", "mkdocs.yml", "Makefile"}
    made = {"out", "build", "dist"}
    assert {path.name for path in ROOT.iterdir() if not path.name.startswith(".")} - made <= rooms | pages | tools
