"""What a boat installs is locked, with hashes, and stands in the list of licences."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

from docs.generate.licences import REQUIREMENTS, licences, pins

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
MAY_BREAK = {"daqp", "numpy", "pyais", "pydantic", "pymavlink", "scipy", "shapely", "nmea2000", "python-can", "mavsdk"}


def requirements() -> dict[str, Requirement]:
    rows = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["can"]]
    return {row.name: row for row in map(Requirement, rows)}


def test_every_package_of_a_boat_is_pinned_with_hashes() -> None:
    text = REQUIREMENTS.read_text(encoding="utf-8")
    blocks = [block for block in re.split(r"\n(?=[a-z0-9])", text) if block.strip()]
    assert len(blocks) == len(pins())
    for block in blocks:
        assert "==" in block and "--hash=sha256:" in block, block.splitlines()[0]


def test_the_pins_are_those_of_the_lock_and_within_the_bounds() -> None:
    locked = (ROOT / ".ci" / "constraints.txt").read_text(encoding="utf-8")
    pinned = {name: version for name, version, _ in pins()}
    assert set(requirements()) <= set(pinned), "make lock"
    for name, version in pinned.items():
        assert re.search(rf"^{re.escape(name)}=={re.escape(version)}\b", locked, re.M), f"{name}: make lock"
        if name in requirements():
            assert requirements()[name].specifier.contains(version), name


def test_libraries_that_break_often_have_an_upper_bound() -> None:
    rows = [Requirement(row) for extra in PROJECT["optional-dependencies"].values() for row in extra]
    rows += requirements().values()
    bounded = {row.name for row in rows if any(one.operator == "<" for one in row.specifier)}
    assert not MAY_BREAK - bounded


def test_every_package_has_its_licence() -> None:
    page = licences()
    for name, version, _ in pins():
        assert f"| {name} | `{version}` |" in page
    assert "not stated" not in page
