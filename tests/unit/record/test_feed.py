"""The feed over its socket: what readers get, and that nobody waits for one."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from companion.core.actuation import ZERO_WRENCH
from companion.core.decision import Event, TextKind
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, Point, PoseSetpoint, Progress, WrenchSetpoint
from companion.record.feed import SOCKET, Feed, address_of
from companion.record.feed_schema import MORE, TickEncoder, finite, more
from companion.record.recorder import tick_columns, tick_row
from tests.shortage import Shortage
from tests.unit.record.ticks import tick
from tests.waiting import wait_until

THRUSTERS, DEVICES = ("port", "bow"), ("gnss", "imu")


class Boat:
    """A feed with what the control thread does."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / SOCKET
        self.looks = 0
        self.feed = Feed(self.path, {"version": 1}, THRUSTERS, DEVICES, self._look, period_s=0.0)
        self.t_s = 0.0

    def _look(self, now_s: float) -> dict[str, Any]:
        self.looks += 1
        return {"looked_s": now_s}

    def step(self, *events: Event) -> None:
        self.t_s = round(self.t_s + 0.1, 3)
        self.feed.record(replace(tick(self.t_s), events=events))


class BlindBoat(Boat):
    """One whose look fails."""

    def _look(self, now_s: float) -> dict[str, Any]:
        raise RuntimeError("no look")


class Reader:
    """A display that reads when it is told to."""

    def __init__(self, boat: Boat) -> None:
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self._socket.settimeout(60.0)
        with address_of(boat.path) as address:
            self._socket.connect(address)
        self._file = self._socket.makefile("rb")

    def next(self, kind: str) -> dict[str, Any]:
        while True:
            message = json.loads(self._file.readline())
            if message["kind"] == kind:
                return message  # type: ignore[no-any-return]

    def close(self) -> None:
        self._file.close()
        self._socket.close()


@pytest.fixture
def boat(tmp_path: Path) -> Iterator[Boat]:
    made = Boat(tmp_path)
    yield made
    made.feed.close()
    assert not made.path.exists()


def test_a_tick_has_the_columns_and_the_values_of_the_log(boat: Boat) -> None:
    reader = Reader(boat)
    assert reader.next("hello")["columns"] == tick_columns(THRUSTERS, DEVICES)
    boat.step()
    got = reader.next("tick")
    cells = tick_row(tick(0.1), DEVICES).rstrip("\n").split(",")
    assert list(got["row"]) == tick_columns(THRUSTERS, DEVICES)
    for value, cell in zip(got["row"].values(), cells, strict=True):
        assert (value is None and cell == "") or value == cell or float(value) == float(cell)
    assert got["more"]["satellites"] == 18
    reader.close()


def test_more_is_what_the_schema_describes() -> None:
    assert set(more(tick(1.0))) == set(MORE)


def test_a_boat_without_sideways_thrust_keeps_a_place_in_hold_and_none_on_a_path() -> None:
    """A console showed neither the point that such a boat holds nor how far off it is."""
    here = Progress(place=Point(1.0, 2.0), target=Point(1.0, 2.0), distance_to_go_m=0.5)
    for setpoint, keeps in (
        (PoseSetpoint(1.0, 2.0, 0.0), True),
        (PathSetpoint(0.0, progress=here, keeps_place=True), True),
        (WrenchSetpoint(ZERO_WRENCH, here), True),
        (PathSetpoint(0.0, progress=replace(here, cross_track_error_m=0.1)), False),
        (NeutralSetpoint(), False),
    ):
        assert more(replace(tick(0.1), setpoint=setpoint))["pose"] is keeps


def test_a_value_that_is_not_finite_is_none() -> None:
    assert finite({"a": float("inf"), "b": [1.0, float("nan")]}) == {"a": None, "b": [1.0, None]}


def test_nothing_is_encoded_while_nobody_reads(boat: Boat) -> None:
    for _ in range(50):
        boat.step()
    assert boat.looks == 0


def test_a_late_reader_gets_the_events_before_it_came(boat: Boat) -> None:
    boat.step(Event(0.1, TextKind.ALARM, "watch_alarm", "Hold: 7 m off"))
    reader = Reader(boat)
    assert reader.next("event")["text"] == "Hold: 7 m off"
    boat.step()
    assert reader.next("boat")["looked_s"] == boat.t_s
    reader.close()


def test_a_reader_that_stalls_loses_frames_and_others_lose_none(boat: Boat) -> None:
    stalled, lively = Reader(boat), Reader(boat)
    lively.next("hello")
    frames = 400
    seen = []
    for _ in range(frames):  # far more than the socket's buffers hold
        boat.step()
        seen.append(lively.next("tick")["row"]["t_s"])
    assert seen == [round(0.1 * n, 3) for n in range(1, frames + 1)]
    numbers = [stalled.next("tick")["sequence"]]
    while numbers[-1] < frames:
        numbers.append(stalled.next("tick")["sequence"])
    assert len(numbers) < frames and numbers == sorted(numbers)
    stalled.close()
    lively.close()


def test_a_reader_that_leaves_is_forgotten(boat: Boat) -> None:
    for _ in range(20):  # more than may read at once
        reader = Reader(boat)
        reader.next("hello")
        reader.close()

    wait_until(lambda: boat.feed.readers == 0, "that all readers are forgotten")
    boat.step()
    assert boat.looks == 0


def test_a_look_that_fails_stops_nothing(tmp_path: Path) -> None:
    boat = BlindBoat(tmp_path)
    reader = Reader(boat)
    reader.next("hello")
    boat.step()
    assert "no look" in reader.next("boat")["fault"]
    assert reader.next("tick")
    reader.close()
    boat.feed.close()


def test_a_folder_far_down_has_a_feed_too(tmp_path: Path) -> None:
    deep = tmp_path / ("a" * 60) / ("b" * 60)
    deep.mkdir(parents=True)
    boat = Boat(deep)
    assert boat.path.stat().st_mode & 0o777 == 0o600  # for the owner alone
    reader = Reader(boat)
    assert reader.next("hello")
    reader.close()
    boat.feed.close()
    assert not boat.path.exists()


def test_the_encoder_keeps_whole_numbers_whole() -> None:
    encoder = TickEncoder(THRUSTERS, DEVICES)
    message = encoder.message(tick(1.0), 1, 0)
    assert message["row"]["time_unix_ns"] == 1_780_000_001_000_000_000


def test_without_descriptors_a_reader_waits_and_the_thread_does_not_turn_without_end(tmp_path: Path) -> None:
    boat = Boat(tmp_path)
    with socket.socket(socket.AF_UNIX) as waiting, address_of(boat.path) as address:
        with Shortage():
            waiting.connect(address)
            wait_until(lambda: not boat.feed.listens, "it listens no more for a while")
        waiting.settimeout(60.0)
        assert waiting.recv(1), "it gets in"
    boat.feed.close()
