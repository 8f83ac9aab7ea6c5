"""mavsdk-examples.md: what becomes of MAVSDK's own examples, from the file that the tests run."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from docs.generate.markdown import code, page, section, table
from docs.generate.source import ROOT

FILE = ROOT / "docs" / "ground-stations" / "mavsdk_examples.toml"
VERDICTS = {
    "works": "works",
    "partly": "in part",
    "refused": "refused, with the reason",
    "example": "no: the example itself",
    "no": "no",
}

_INTRODUCTION = """The Python examples of MAVSDK, unmodified, against the simulated boat. `make scenarios` runs those
that are marked (`tests/protocol/test_mavsdk_examples.py`).

The examples connect to UDP port 14540, where the simulation sends by default. Most of them are at home in Zurich, where
PX4's simulator starts. Put the boat there:"""

_START = """```sh
companion run revolt --sitl --home 47.39804,8.54557,0 --speed 5
```"""

_VERSIONS = """Version 3 is the package `mavsdk` below 4, with its server; its successor of that form is called
`mavsdk-grpc`. Version 4 of `mavsdk` is another program interface. MAVSDK's package `aiomavsdk` has the seven examples
of version 4 once more, for asyncio; these are not run."""


@dataclass(frozen=True, slots=True)
class Example:
    """One example. `shows`: what it prints, as regular expressions; nothing: it is not run. `ends`: whether it ends by
    itself, without an error. `before`: arguments of version 4's params.py, run first. `speed`: of the boat's time."""

    sdk: int
    file: str
    verdict: str
    note: str = ""
    shows: tuple[str, ...] = ()
    ends: bool = True
    arguments: tuple[str, ...] = ()
    before: tuple[str, ...] = ()
    speed: float = 5.0


def examples(file: Path = FILE) -> list[Example]:
    """Every row, in the order of the file."""
    return [_example(row) for row in tomllib.loads(file.read_text(encoding="utf-8"))["example"]]


def _example(row: Mapping[str, Any]) -> Example:
    fields: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
    return Example(**fields)


def mavsdk_examples() -> str:
    """The page."""
    found = examples()
    parts = []
    for sdk, title in ((3, "MAVSDK 3"), (4, "MAVSDK 4")):
        rows = [
            (code(row.file), VERDICTS[row.verdict], row.note, "yes" if row.shows else "")
            for row in found
            if row.sdk == sdk
        ]
        parts.append(section(2, title, table(("example", "works?", "what happens", "in the tests"), rows)))
    return page("MAVSDK's examples", _INTRODUCTION, _START, _VERSIONS, *parts)
