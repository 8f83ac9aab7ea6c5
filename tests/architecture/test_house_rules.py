"""Rules of the house that import-linter does not know."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tests.architecture.measures import LONGEST, ROOMS, ROOT, long_functions, parsed, sources, undocumented

PURE = (
    "core", "nav", "guidance", "control", "allocation", "mission", "following", "fence", "baselines", "positioning", "payload",
    "traffic", "modes", "supervisor",
)  # fmt: skip


@dataclass(frozen=True)
class File:
    """A source file, which is read and parsed once for all rules."""

    place: str
    text: str
    long: Sequence[str]
    undocumented: Sequence[str]
    says_what_it_is: bool

    @property
    def room(self) -> tuple[str, ...]:
        return Path(self.place).parts[:2]


@cache
def files() -> Sequence[File]:
    return [file_of(path) for path in sources(*ROOMS)]


def file_of(path: Path) -> File:
    tree = parsed(path)
    named = path.name == "__init__.py" or bool(ast.get_docstring(tree))
    text, place = path.read_text(encoding="utf-8"), str(path.relative_to(ROOT))
    return File(place, text, long_functions(tree), undocumented(tree), named)


def test_every_source_file_is_looked_at() -> None:
    places = {file.place for file in files()}
    assert len(places) > 800 and {"companion/loop.py", "sitl/world.py", "gcs_plugins/usvctl/cli.py"} <= places


def test_a_function_fits_on_a_page() -> None:
    assert not {file.place: file.long for file in files() if file.long}, f"at most {LONGEST} lines"


def test_what_is_public_has_a_docstring() -> None:
    assert not {file.place: file.undocumented for file in files() if file.room[0] == "companion" and file.undocumented}


def test_no_untracked_todo() -> None:
    assert not [file.place for file in files() if re.search(r"\b(TODO|FIXME|XXX)\b", file.text)]


def test_every_file_says_what_it_is() -> None:
    assert not [file.place for file in files() if not file.says_what_it_is]


def test_nothing_below_the_wiring_asks_whether_it_is_simulated() -> None:
    asks = r"\benviron\b|\bgetenv\b|\bsitl\b|\bis_simulat|\bsimulated\b"
    rooms = {("companion", room) for room in PURE}
    assert {file.room for file in files()} >= rooms
    found = [
        file.place
        for file in files()
        if file.room in rooms and re.search(asks, re.sub(r'"""[\s\S]*?"""|#.*', "", file.text), re.IGNORECASE)
    ]
    assert not found


def test_the_top_level_is_as_agreed() -> None:
    rooms = {"companion", "docs", "gcs_plugins", "mission_files", "sitl", "tests"}
    pages = {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "LICENSE"}
    tools = {"pyproject.toml", "uv.lock", "mkdocs.yml", "Makefile"}
    made = {"out", "build", "dist"}
    assert {name for name in top_level() if not name.startswith(".")} - made <= rooms | pages | tools


def top_level() -> set[str]:
    """What belongs to the project; where git cannot tell, all that lies there. Somebody's own boat may lie there too:
    the README makes `my_boat.toml`."""
    git = shutil.which("git")
    if git is not None:
        done = subprocess.run([git, "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
        if done.returncode == 0 and done.stdout:
            return {name.partition("/")[0] for name in done.stdout.splitlines()}
    return {path.name for path in ROOT.iterdir()}
