"""The page of sweeps and the designs beside the results: their keys, their examples, how many runs they ask for."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any, get_type_hints

import pytest
from pydantic.fields import FieldInfo

from sitl.scenarios import SCENARIOS
from sitl.sweep.design import DesignConfig, PartConfig, RangeConfig, parse_design
from sitl.sweep.plan import runs_of
from tests.docs.pages import DOCS

DESIGNS = sorted((DOCS / "results" / "designs").glob("*.toml"))
PAGE = (DOCS / "use" / "sweeps.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", DESIGNS, ids=lambda path: path.stem)
def test_a_design_can_be_sailed(path: Path) -> None:
    design = parse_design(path.read_text(encoding="utf-8"), str(path), SCENARIOS)
    assert design.name == path.stem
    count = len(runs_of(design, SCENARIOS))
    assert f"| `docs/results/designs/{path.name}` | {count:,} |" in PAGE


def keys(of: type[Any]) -> dict[str, str]:
    """Keys of a table as a file has them, with their meaning."""
    found = {}
    for name, hint in get_type_hints(of, include_extras=True).items():
        infos = [info for info in hint.__metadata__ if isinstance(info, FieldInfo)]
        alias = next((info.alias for info in infos if info.alias), name)
        found[alias] = next(info.description for info in infos if info.description)
    assert len(found) == len(fields(of))
    return found


@pytest.mark.parametrize("of", [DesignConfig, PartConfig, RangeConfig], ids=lambda of: of.__name__)
def test_every_key_stands_on_the_page_as_the_file_means_it(of: type[Any]) -> None:
    rows = set(re.findall(r"^\| `(\w+)` \| (.+?) \|", PAGE, re.MULTILINE))
    assert {(name, text) for name, text in keys(of).items()} <= rows
