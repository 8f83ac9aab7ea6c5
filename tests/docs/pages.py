"""The written pages as tests see them: their blocks, links, anchors and names."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from docs.generate.markdown import slug
from docs.generate.pages import PAGES

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
ON_THE_BOAT = "on the boat"  # title of a block that no test runs

_FENCE = re.compile(r"^(?P<indent> *)```(?P<info>[^\n`]*)\n(?P<text>.*?)^(?P=indent)```[ ]*$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\((?P<target>[^)\s]+)(?:\s+\"[^\"]*\")?\)")
_HEADING = re.compile(r"^#{1,6}\s+(?P<title>.+?)\s*$", re.MULTILINE)
_OWN_ANCHOR = re.compile(r"\{\s*#(?P<name>[\w.-]+)[^}]*\}|<a\s+id=\"(?P<id>[^\"]+)\"")
_SPAN = re.compile(r"`([^`\n]+)`")


def written() -> list[Path]:
    """Every page that people write."""
    top = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md") if (ROOT / name).is_file()]
    return [*top, *sorted(DOCS.rglob("*.md"))]


def label(path: Path) -> str:
    """A page as the output of the tests names it."""
    return path.relative_to(ROOT).as_posix()


@cache
def generated() -> dict[Path, str]:
    """Every generated page by the place where it would stand."""
    return {DOCS / place: make() for place, make in PAGES.items()}


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block: where it stands, its language, its title, its text without indentation."""

    path: Path
    line: int
    language: str
    title: str
    text: str

    @property
    def place(self) -> str:
        return f"{label(self.path)}:{self.line}"


def blocks(language: str) -> Iterator[Block]:
    """Every fenced block of a language in the written pages."""
    for path in written():
        for block in blocks_of(path):
            if block.language == language:
                yield block


@cache
def blocks_of(path: Path) -> tuple[Block, ...]:
    """The fenced blocks of one page."""
    text = path.read_text(encoding="utf-8")
    return tuple(_block(path, text, found) for found in _FENCE.finditer(text))


def _block(path: Path, text: str, found: re.Match[str]) -> Block:
    language, _, rest = found["info"].strip().partition(" ")
    title = re.search(r'title="([^"]*)"', rest)
    line = text.count("\n", 0, found.start()) + 1
    return Block(path, line, language, title[1] if title else "", textwrap.dedent(found["text"]))


def prose(path: Path) -> str:
    """A page without its fenced blocks."""
    return _FENCE.sub("", path.read_text(encoding="utf-8"))


def links(path: Path) -> list[str]:
    """Targets of the links of a page, without those to other sites."""
    targets = [found["target"] for found in _LINK.finditer(prose(path))]
    return [target for target in targets if not re.match(r"[a-z]+:", target)]


def anchors(text: str) -> set[str]:
    """What a link into a page can name: its headings, and anchors of its own."""
    found = {slug(_plain(heading["title"])) for heading in _HEADING.finditer(_FENCE.sub("", text))}
    return found | {own["name"] or own["id"] for own in _OWN_ANCHOR.finditer(text)}


def _plain(title: str) -> str:
    """A heading without its markup."""
    return re.sub(r"\{[^}]*\}|[`*]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title))


def spans(path: Path) -> list[str]:
    """Code within the prose of a page."""
    return _SPAN.findall(prose(path))
