"""A log played back: the messages of a running boat, at the pace of the page."""

from __future__ import annotations

import asyncio
import json
import math
import tracemalloc
from pathlib import Path
from typing import Any

import pytest

from companion.analysis.log_reader import LogError
from companion.console.board import Page
from companion.console.replay import Player, Recording
from tests.unit.console.recorded import write_log


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return Recording(write_log(tmp_path_factory.mktemp("console") / "log"))


def taken(page: Page) -> dict[str, Any]:
    return {message["kind"]: message for message in map(json.loads, asyncio.run(page.take()))}


def test_a_row_is_a_tick(recording: Recording) -> None:
    made = recording.tick(recording.index(20.0))
    assert made["row"]["t_s"] == 20.0 and made["row"]["north_m"] == 2.0
    assert made["row"]["stern_port_force_n"] == 20.0 and made["row"]["bow_azimuth_rad"] is None
    assert made["more"]["covariance_m2"] == [0.0625, 0.0, 0.0625]
    assert made["sample"][0] == pytest.approx(math.hypot(1.0, 4.0))  # from (2, 2) to the hold point (1, −2)


def test_measured_thrust_and_devices_come_from_the_log(recording: Recording) -> None:
    recording.measured.wait()

    def at(t_s: float) -> dict[str, Any]:
        more: dict[str, Any] = recording.tick(recording.index(t_s))["more"]
        return more

    measured = {"throttle": 0.5, "azimuth_rad": 0.2, "age_s": 0.0, "ok": True}
    assert at(20.0)["feedback"] == [measured, None, None]
    assert at(32.0)["feedback"][0] == {**measured, "age_s": pytest.approx(2.0)}
    assert at(36.0)["feedback"] == [None, None, None]  # a report that is old tells nothing
    imu = {t_s: next(row for row in at(t_s)["health"] if row["name"] == "imu") for t_s in (9.0, 12.0, 16.0)}
    assert imu[12.0] == {"name": "imu", "ok": False, "age_s": None, "text": "no bytes"}
    assert imu[9.0]["ok"] and imu[16.0]["ok"]
    assert {row["name"] for row in at(9.0)["health"]} == {"gnss", "imu", "microcontroller"}


def test_a_log_without_readings_has_none(tmp_path: Path) -> None:
    folder = write_log(tmp_path / "log", seconds=2)
    (folder / "log.mcap").unlink()
    recording = Recording(folder)
    recording.measured.wait()
    assert recording.tick(5)["more"]["feedback"] == [None, None, None]


def test_a_player_begins_at_the_start_and_obeys(recording: Recording) -> None:
    page = Page()
    player = Player(recording, page, {"control": False})
    first = taken(page)
    assert first["hello"]["console"]["replay"] and len(first["recording"]["events"]) == 4
    assert first["tick"]["row"]["t_s"] == 0.0 and first["tick"]["replay"]["playing"]
    player.order({"t_s": 25.04, "playing": False, "speed": 10})
    second = taken(page)
    assert second["tick"]["row"]["t_s"] == 25.0
    assert second["tick"]["replay"] == {"t_s": 25.04, "playing": False, "speed": 10.0}
    assert second["history"]["t_s"][0] == 0.0 and second["history"]["t_s"][-1] == 25.0
    assert len(second["history"]["t_s"]) == 51  # two a second


@pytest.mark.parametrize("asked", [{"speed": 7}, {"t_s": "x"}, {"playing": 1}, {"t_s": float("nan")}])
def test_nonsense_changes_nothing(recording: Recording, asked: dict[str, Any]) -> None:
    page = Page()
    player = Player(recording, page, {})
    before = taken(page)["tick"]["replay"]
    player.order(asked)
    assert taken(page)["tick"]["replay"] == before


def test_beyond_the_end_is_the_end(recording: Recording) -> None:
    page = Page()
    player = Player(recording, page, {})
    player.order({"t_s": 1e9})
    assert taken(page)["tick"]["row"]["t_s"] == recording.times_s[-1]


def test_a_line_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    folder = write_log(tmp_path / "log", seconds=2)
    ticks = folder / "ticks.csv"
    ticks.write_bytes(ticks.read_bytes()[:-20])
    assert Recording(folder).times_s[-1] == 1.8


def test_what_is_no_log_is_said(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no log folder"):
        Recording(tmp_path)


def damaged(path: Path, row: int, column: str, cell: str) -> None:
    lines = path.read_text().split("\n")
    cells = lines[row].split(",")
    cells[lines[0].split(",").index(column)] = cell
    lines[row] = ",".join(cells)
    path.write_text("\n".join(lines))


def test_a_damaged_row_costs_that_row_alone(tmp_path: Path) -> None:
    """One bad cell stopped the playing there, or kept the whole log shut; so did a bad row of events.csv."""
    folder = write_log(tmp_path / "log", seconds=10)
    damaged(folder / "ticks.csv", 11, "north_m", "x?y")
    damaged(folder / "ticks.csv", 21, "t_s", "")
    with (folder / "events.csv").open("a") as file:
        file.write("garbage\n\0\0\n")
    recording = Recording(folder)
    assert recording.tick(recording.index(1.0))["row"]["north_m"] == pytest.approx(0.09)  # of the row before
    assert 2.0 not in recording.times_s and len(recording.times_s) == 99
    assert len(recording.events) == 1


def test_a_log_of_a_boat_that_knew_nothing_plays(tmp_path: Path) -> None:
    folder = write_log(tmp_path / "log", seconds=2)
    for row in range(1, 21):
        for column in ("north_m", "east_m", "yaw_rad"):
            damaged(folder / "ticks.csv", row, column, "")
        damaged(folder / "ticks.csv", row, "fix", "9")  # of a later version
    made = Recording(folder).tick(10)
    assert made["sample"][0] is None and made["sample"][2] is None and made["more"]["fix"] == "fix 9"


def test_a_number_that_is_none_is_missing(tmp_path: Path) -> None:
    """An infinite yaw or place stopped the playing there."""
    folder = write_log(tmp_path / "log", seconds=2)
    for column in ("yaw_rad", "north_m"):
        damaged(folder / "ticks.csv", 11, column, "inf")
    made = Recording(folder).tick(10)
    assert made["row"]["yaw_rad"] is None and made["sample"][0] is None and made["sample"][2] is None


@pytest.mark.parametrize("cell", ["", "x"])
def test_a_row_without_unix_time_leaves_what_devices_report(tmp_path: Path, cell: str) -> None:
    """The thread that reads it ended with a ValueError."""
    folder = write_log(tmp_path / "log", seconds=12)
    damaged(folder / "ticks.csv", 11, "time_unix_ns", cell)
    recording = Recording(folder)
    recording.measured.wait()
    assert {"name": "imu", "ok": False, "age_s": None, "text": "no bytes"} in recording.tick(115)["more"]["health"]


def test_a_long_log_takes_little_more_memory_than_its_file(tmp_path: Path) -> None:
    """Each cell was an object: a log of 24 h took 2.5 GB."""
    folder = write_log(tmp_path / "log", seconds=100)
    (folder / "log.mcap").unlink()
    tracemalloc.start()
    recording = Recording(folder)
    taken_bytes = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert len(recording.times_s) == 1000 and taken_bytes < 2 * (folder / "ticks.csv").stat().st_size
