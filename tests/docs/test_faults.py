"""The page of the simulation has every fault that a simulated boat can have, and the links that it has by itself."""

from __future__ import annotations

import re

import pytest

from companion.config.vessel import bundled, find, load
from sitl.faults import known
from tests.docs.pages import DOCS

PAGE = (DOCS / "start" / "simulation.md").read_text(encoding="utf-8")
FIRST_CELLS = re.findall(r"^\| (`.+?) \|", PAGE, re.MULTILINE)
NAMED = [span for cell in FIRST_CELLS for span in re.findall(r"`([\w]+)`", cell)]
ANY_OF = {"NAME": r"\w+?", "DEVICE": r"\w+?", "AXIS": "(x|y|z|roll|pitch|yaw)"}


def as_pattern(span: str) -> str:
    """`thruster_NAME_stuck` → a pattern of what people type."""
    return re.sub("|".join(ANY_OF), lambda found: ANY_OF[found[0]], span)


PATTERNS = re.compile("|".join(as_pattern(f"thruster_NAME{span}" if span[0] == "_" else span) for span in NAMED))


@pytest.mark.parametrize("name", bundled())
def test_every_fault_of_a_bundled_boat_stands_on_the_page(name: str) -> None:
    faults = [fault for fault in known(load(find(name))) if not re.fullmatch(r"gnss_off_\d+m", fault)]
    assert [fault for fault in faults if not PATTERNS.fullmatch(fault)] == []
