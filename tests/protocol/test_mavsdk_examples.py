"""MAVSDK's own examples, unmodified, against the running process; the table of them in the documentation."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from docs.generate.mavsdk_examples import VERDICTS, Example, examples, mavsdk_examples
from tests.island import Island, NoIsland
from tests.protocol.mavsdk_examples import Running, Unavailable, fetched, interpreter
from tests.protocol.process import Companion

LINK = "udpout:127.0.0.1:14540"  # the simulation's default link for programs, which the examples know
HOME = "47.39804,8.54557,0"  # of PX4's simulator
EVERY = examples()
_UNASKED = "not-existing command"  # in MAVSDK's log: an acknowledgement of a command that it did not send


@pytest.fixture(scope="module")
def cache(request: pytest.FixtureRequest) -> Path:
    config = request.config
    assert config.cache is not None
    return Path(config.cache.mkdir("mavsdk"))


@contextmanager
def afloat(folder: Path, speed: float) -> Iterator[tuple[str, ...]]:
    """A boat at the example's place, alone with it on a network. What to put before a command that shall meet it."""
    try:
        island = Island()
    except NoIsland as error:
        pytest.skip(f"the examples' port is fixed, and this machine gives no network of its own: {error}")
    with (
        island,
        Companion(folder, speed=speed, extra=(f"--home={HOME}",), links=(LINK,), within=island.within),
    ):
        yield island.within


@pytest.mark.process
@pytest.mark.sweep
@pytest.mark.parametrize("example", [row for row in EVERY if row.shows], ids=lambda row: f"{row.sdk}-{row.file}")
def test_an_example_does_what_the_table_says(example: Example, cache: Path, tmp_path: Path) -> None:
    try:
        python = interpreter(example.sdk, cache)
        source = shutil.copytree(fetched(example.sdk, cache), tmp_path / "examples")
    except Unavailable as error:
        pytest.skip(str(error))
    script = source / example.file
    (source / "boat.params").write_text("# a parameter file\n1\t1\tWP_SPEED\t0.5\t9\n", encoding="utf-8")
    with afloat(tmp_path / "boat", example.speed) as within:
        if example.before:
            params = str(fetched(4, cache) / "params.py")
            prepare = [*within, interpreter(4, cache), params, "udpin://0.0.0.0:14540", *example.before]
            with Running(prepare, script.parent, tmp_path / "before.txt") as running:
                running.shows("Ok")
                running.ended_well()
        command = [*within, python, str(script), *example.arguments]
        with Running(command, script.parent, tmp_path / "printed.txt") as running:
            for pattern in example.shows:
                running.shows(pattern)
            if example.ends:
                running.ended_well()
            assert _UNASKED not in running.printed


@pytest.mark.sweep
@pytest.mark.parametrize("sdk", [3, 4])
def test_every_example_has_a_row(sdk: int, cache: Path) -> None:
    try:
        folder = fetched(sdk, cache)
    except Unavailable as error:
        pytest.skip(str(error))
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*.py")}
    assert {row.file for row in EVERY if row.sdk == sdk} == files


def test_a_row_says_what_happens() -> None:
    assert len({(row.sdk, row.file) for row in EVERY}) == len(EVERY)
    for row in EVERY:
        assert row.verdict in VERDICTS, row
        assert row.note or row.verdict == "works", f"{row.file}: say why"
        assert row.shows or row.verdict == "no", f"{row.file}: only what is not run has nothing to show"


def test_the_page_has_every_row() -> None:
    text = mavsdk_examples()
    assert all(f"| `{row.file}` | {VERDICTS[row.verdict]} |" in text for row in EVERY)
