"""The comparison with ArduRover, with a stand-in for it that speaks its two protocols."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from companion.cli.main import main
from companion.config.vessel import find, load
from sitl.evaluate.ardurover import RoverError
from sitl.evaluate.beside import OWN, ROVER, Row, Rows
from sitl.evaluate.rover_setup import RoverSetup, setups
from sitl.evaluate.tasks import TASKS, Task, judge, sail_rover
from sitl.json_physics import parse_outputs
from tests.unit.sitl import stand_in_rover

SETUP = RoverSetup("port=1,starboard=3", {})
SHORT = Task("blueboat", "", "", ((12.0, 0.0), (12.0, 12.0)), begin_s=45.0)
HELD = Task("blueboat", "", "", hold_s=20.0, begin_s=20.0)


@pytest.fixture
def binary(tmp_path: Path) -> Path:
    script = tmp_path / "ardurover"
    root = Path(__file__).parents[3]
    script.write_text(f'#!/bin/sh\nPYTHONPATH={root} exec {sys.executable} {stand_in_rover.__file__} "$@"\n')
    script.chmod(0o755)
    return script


@pytest.mark.process
def test_a_route_is_judged_from_home_to_its_last_waypoint(binary: Path, tmp_path: Path) -> None:
    sailed = sail_rover(SHORT, 0, binary, SETUP, tmp_path / "log")
    figures = {figure.name: figure.value for figure in judge(SHORT, sailed)}
    assert 15.0 < figures["time"] < 90.0 and figures["worst miss of a waypoint passed"] < 0.6
    assert sailed.version == "4.7.0-dev abc"


@pytest.mark.process
def test_a_hold_is_judged_by_the_point_that_it_chose(binary: Path, tmp_path: Path) -> None:
    sailed = sail_rover(HELD, 0, binary, SETUP, tmp_path / "log")
    assert sailed.point is not None and (sailed.from_s, sailed.to_s) == (20.0, pytest.approx(40.0, abs=0.1))
    assert {figure.name: figure.value for figure in judge(HELD, sailed)}["position, RMS"] < 0.5


@pytest.mark.process
@pytest.mark.parametrize(
    ("habit", "words"),
    [
        (stand_in_rover.REFUSES, "the mission was refused"),
        (stand_in_rover.DIES, "it went away"),
        (stand_in_rover.STAYS_DISARMED, "armed: not within"),
    ],
)
def test_what_it_does_not_do_is_said(binary: Path, tmp_path: Path, habit: int, words: str) -> None:
    with pytest.raises(RoverError, match=words):
        sail_rover(SHORT, 0, binary, RoverSetup(SETUP.outputs, {"STAND_IN": habit}), tmp_path / "log")


def test_every_task_has_a_boat_that_is_set_up() -> None:
    known = setups()
    for task in TASKS.values():
        assert parse_outputs(known[task.vessel].outputs, load(find(task.vessel)))


def row(task: str, seed: int, autopilot: str, error: str = "", **figures: float) -> Row:
    return Row(task, "otter", seed, autopilot, "1", "2026-01-01", figures, error)


def test_rows_stay_and_only_seeds_that_both_completed_are_compared(tmp_path: Path) -> None:
    rows = Rows(tmp_path / "rows.json")
    for given in (
        row("hold", 0, OWN, rms=0.1, heading=1.0),
        row("hold", 0, ROVER, rms=0.4),
        row("hold", 1, OWN, rms=0.3, heading=3.0),
        row("hold", 1, ROVER, "it went away"),
    ):
        rows.add(given)
    again = Rows(tmp_path / "rows.json")
    assert again.has("hold", 1, ROVER) and not again.has("hold", 2, ROVER)
    assert list(again.table())[2:] == [
        "| hold (1 of 2 seeds) | rms | 0.1 (0.1) | 0.4 (0.4) | 4.00 |",
        "|  | heading | 1 (1) | not held | – |",
    ]


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "rows.json").write_text('{"rows": [{"a": 1}]}')
    with pytest.raises(ValueError, match="no rows"):
        Rows(tmp_path / "rows.json")


@pytest.mark.process
def test_the_command_sails_both_and_goes_on_where_it_was(
    binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sitl.evaluate.tasks.TASKS", {"hold": HELD})
    monkeypatch.setattr("sitl.evaluate.rover_setup.setups", lambda: {"blueboat": SETUP})
    words = ["evaluate", "ardurover", str(binary), "--seeds", "3", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    first = capsys.readouterr().out
    assert "hold, seed 3, ArduRover: sailed" in first and "| hold (1 of 1 seeds) | position, RMS |" in first
    assert main(words) == 0
    assert "sailed" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "text"),
    [(["/nowhere"], "no such file"), (["/nowhere", "--task", "hold, Oter"], "did you mean 'hold, Otter'")],
)
def test_what_the_command_cannot_do_is_said(words: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "ardurover", *words]) == 2
    assert text in capsys.readouterr().err


def test_the_command_lists_its_tasks(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "ardurover", "/nowhere", "--task", "list"]) == 0
    assert capsys.readouterr().out.splitlines() == list(TASKS)
