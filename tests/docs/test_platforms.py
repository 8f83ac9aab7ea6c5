"""The table of platforms, from the lock: both 64-bit machines have wheels for all, and the container uses one of the Pythons."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs.generate.licences import pins
from docs.generate.platforms import EXTRAS, PLATFORMS, PYTHONS, missing

BY_MACHINE = {platform.machine: platform for platform in PLATFORMS if platform.musl is None}
ROOT = Path(__file__).parents[2]
DOCKERFILE = ROOT / "gcs_plugins" / "blueos" / "Dockerfile"


@pytest.mark.parametrize("machine", ["x86_64", "aarch64"])
@pytest.mark.parametrize("python", PYTHONS)
def test_a_boat_needs_no_compiler(machine: str, python: tuple[int, int]) -> None:
    assert missing(BY_MACHINE[machine], python, EXTRAS) == []


def test_what_32_bit_arm_lacks_is_named() -> None:
    lacking = missing(BY_MACHINE["armv7l"], (3, 11))
    assert {"numpy", "scipy", "shapely", "daqp"} <= set(lacking)
    assert set(lacking) <= {name for name, _, _ in pins()}


def test_the_container_copies_what_is_there_and_has_a_python_of_the_table() -> None:
    text = DOCKERFILE.read_text(encoding="utf-8")
    found = re.search(r"^ARG PYTHON=(\d+)\.(\d+)-slim", text, re.MULTILINE)
    assert found is not None and (int(found[1]), int(found[2])) in PYTHONS
    ignored = DOCKERFILE.with_name("Dockerfile.dockerignore").read_text(encoding="utf-8").split()
    for source in re.findall(r"^COPY (?!--from)(\S+)", text, re.MULTILINE):
        assert (ROOT / source).exists() and source.split("/")[0] not in ignored
    needed = ("companion", "sitl", "gcs_plugins", "mission_files", "pyproject.toml", "README.md", "LICENSE")
    assert not set(needed) & set(ignored)
