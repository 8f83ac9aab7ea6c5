"""The way along the track: what counts as way, and what is noise or a leap."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.payload.odometer import CHORD_M, Odometer


def way(points: list[tuple[float, float]], speed_mps: float = 1.0, dt_s: float = 0.1) -> float:
    odometer = Odometer()
    for point in points:
        odometer.update(*point, speed_mps, dt_s)
    return odometer.way_m


@given(st.floats(0.02, 15.0), st.floats(0.0, 2.0 * math.pi), st.integers(1, 400))
def test_a_straight_way_is_its_length(speed_mps: float, course_rad: float, ticks: int) -> None:
    step_m = 0.1 * speed_mps
    points = [(i * step_m * math.cos(course_rad), i * step_m * math.sin(course_rad)) for i in range(ticks + 1)]
    assert way(points, speed_mps) == pytest.approx(ticks * step_m, rel=1e-6, abs=1e-9)


def test_a_circle_is_its_circumference() -> None:
    points = [(10.0 * math.cos(i / 100.0), 10.0 * math.sin(i / 100.0)) for i in range(628)]
    assert way(points) == pytest.approx(62.7, abs=0.1)


@given(st.integers(0, 10_000))
def test_a_boat_at_rest_makes_no_way(seed: int) -> None:
    noise = random.Random(seed)
    points = [(noise.gauss(0.0, 0.03), noise.gauss(0.0, 0.03)) for _ in range(600)]
    assert way(points, 0.05) <= CHORD_M


def test_there_and_back_counts_both() -> None:
    there = [(0.1 * i, 0.0) for i in range(101)]
    assert way([*there, *reversed(there)]) == pytest.approx(20.0, abs=CHORD_M)


def test_a_leap_of_the_estimate_is_no_way() -> None:
    before = [(0.1 * i, 0.0) for i in range(51)]
    after = [(0.1 * i, 40.0) for i in range(51, 101)]
    assert way([*before, *after]) == pytest.approx(9.9, abs=0.01)


def test_nothing_counts_while_the_position_is_not_valid() -> None:
    odometer = Odometer()
    for i in range(51):
        odometer.update(0.1 * i, 0.0, 1.0, 0.1)
    assert odometer.lose() == pytest.approx(5.0)
    assert odometer.lose() == pytest.approx(5.0)
    for i in range(51):
        odometer.update(30.0 + 0.1 * i, 0.0, 1.0, 0.1)
    assert odometer.way_m == pytest.approx(10.0)
