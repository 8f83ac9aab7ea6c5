"""When a camera takes pictures: spacing, pace, what a slow camera leaves out, pauses, missions that are interrupted."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.payload.trigger import CameraTrigger

DT_S = 0.1


class Sail:
    """A boat at a steady speed; `shots` holds (way_m, now_s) of each picture."""

    def __init__(self, trigger: CameraTrigger, speed_mps: float = 1.0) -> None:
        self.trigger, self.speed_mps = trigger, speed_mps
        self.ticks, self.way_m = 0, 0.0
        self.shots: list[tuple[float, float]] = []

    @property
    def now_s(self) -> float:
        return self.ticks * DT_S

    def run(self, duration_s: float, mission: bool = True) -> None:
        for _ in range(round(duration_s / DT_S)):
            self.ticks += 1
            self.way_m += self.speed_mps * DT_S
            if self.trigger.update(self.way_m, self.speed_mps, self.now_s, DT_S, mission):
                self.shots.append((self.way_m, self.now_s))


@given(st.floats(0.1, 15.0), st.floats(0.5, 30.0))
def test_each_picture_is_within_half_a_tick_of_its_place(speed_mps: float, spacing_m: float) -> None:
    sail = Sail(CameraTrigger(1e-6), speed_mps)
    sail.run(1.0)
    begin_m = sail.way_m + speed_mps * DT_S  # the first tick after the request
    sail.trigger.by_distance(spacing_m)
    sail.run(60.0)
    if spacing_m > speed_mps * DT_S:
        places = [begin_m + (i + 1) * spacing_m for i in range(len(sail.shots))]
        assert all(
            abs(way_m - place) <= 0.5 * speed_mps * DT_S + 1e-6
            for (way_m, _), place in zip(sail.shots, places, strict=True)
        )
        assert abs(len(sail.shots) - int((sail.way_m - begin_m) / spacing_m)) <= 1
        assert sail.trigger.left_out == 0
    else:
        assert len(sail.shots) + sail.trigger.left_out == pytest.approx((sail.way_m - begin_m) / spacing_m, abs=2)


@given(st.floats(0.3, 10.0), st.integers(1, 20))
def test_pictures_by_time_begin_at_once_and_end_by_count(interval_s: float, count: int) -> None:
    sail = Sail(CameraTrigger(0.2), 0.0)
    sail.trigger.by_time(interval_s, count)
    sail.run(count * interval_s + 1.0)
    assert len(sail.shots) == count and not sail.trigger.runs
    for i, (_, t_s) in enumerate(sail.shots):
        assert t_s == pytest.approx(DT_S + i * interval_s, abs=0.5 * DT_S + 1e-6)


def test_a_camera_is_not_asked_for_more_than_it_can() -> None:
    sail = Sail(CameraTrigger(1.0), 2.0)
    sail.trigger.by_distance(1.0)
    sail.run(20.0)
    gaps = [b[1] - a[1] for a, b in zip(sail.shots, sail.shots[1:], strict=False)]
    assert min(gaps) >= 1.0 - 1e-9 and sail.trigger.left_out == pytest.approx(20, abs=2)
    by_time = Sail(CameraTrigger(1.0))
    by_time.trigger.by_time(0.0, None)
    by_time.run(10.0)
    assert len(by_time.shots) == 10 and by_time.trigger.left_out == 0


def test_single_pictures_wait_until_the_camera_is_ready() -> None:
    sail = Sail(CameraTrigger(1.0))
    for _ in range(3):
        sail.trigger.shoot()
    sail.run(5.0)
    assert [t_s for _, t_s in sail.shots] == pytest.approx([0.1, 1.1, 2.1])


@pytest.mark.parametrize(
    "halt",
    [
        lambda trigger, on: setattr(trigger, "paused", not on),
        lambda trigger, on: setattr(trigger, "enabled", on),
    ],
)
def test_a_series_that_was_halted_goes_on_where_it_was(halt: Callable[[CameraTrigger, bool], None]) -> None:
    sail = Sail(CameraTrigger(0.1))
    sail.trigger.by_distance(5.0)
    sail.run(7.1)
    halt(sail.trigger, False)
    sail.run(20.0)
    assert len(sail.shots) == 1
    halt(sail.trigger, True)
    sail.run(3.2)
    assert len(sail.shots) == 2  # 2 m had been sailed of 5


def test_a_missions_series_runs_only_while_it_does() -> None:
    sail = Sail(CameraTrigger(0.1))
    sail.trigger.by_distance(2.0, by_mission=True)
    sail.run(5.1)
    sail.run(30.0, mission=False)
    assert len(sail.shots) == 2
    sail.run(1.1)
    assert len(sail.shots) == 3
    sail.trigger.stop(by_mission=True)
    assert not sail.trigger.runs


def test_an_operators_series_outlives_a_mission() -> None:
    sail = Sail(CameraTrigger(0.1))
    sail.trigger.by_distance(2.0)
    sail.trigger.stop(by_mission=True)
    sail.run(10.1, mission=False)
    assert len(sail.shots) == 5
    sail.trigger.stop()
    sail.run(10.0)
    assert len(sail.shots) == 5


def test_a_new_series_replaces_the_old() -> None:
    sail = Sail(CameraTrigger(0.1))
    sail.trigger.by_time(1.0, None)
    sail.trigger.by_distance(4.0)
    sail.run(10.0)
    assert len(sail.shots) == 2
