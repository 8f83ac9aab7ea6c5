"""How a boat turns: what it slides, and how steeply it may come back to a line."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.config.vessel import find, load
from companion.guidance.turning import UNKNOWN, Turning, turning_of

OTTER = load(find("otter"))
ARC = Turning(arc=OTTER.hull)


def test_the_course_is_late_by_the_lag_of_the_sway() -> None:
    hull = replace(OTTER.hull, m22_kg=300.0, damping=replace(OTTER.hull.damping, y_v=50.0, y_uv=100.0, y_vv=0.0))
    assert Turning(arc=hull).late_s(1.0, 0.3) == pytest.approx(2.0)
    assert Turning(arc=hull).late_s(2.5, 0.3) == pytest.approx(1.0)


def test_at_rest_it_is_late_by_no_more_than_a_bound() -> None:
    hull = replace(OTTER.hull, damping=replace(OTTER.hull.damping, y_v=0.0, y_uv=100.0, y_vv=0.0))
    assert ARC.late_s(0.0, 0.0) <= 6.0
    assert Turning(arc=hull).late_s(0.0, 0.0) == 0.0  # nothing is known there


def test_only_a_rudder_turns_a_boat_along_an_arc() -> None:
    assert turning_of(OTTER, on_the_spot=True).arc is None
    rudder = replace(OTTER, thrusters=(replace(OTTER.thrusters[0], kind="rudder"),))
    assert turning_of(rudder, on_the_spot=False).arc == OTTER.hull
    assert UNKNOWN.late_s(1.0, 0.2) == 0.0
    assert UNKNOWN.steepest_rad(0.1, 10.0, 1.0) == pytest.approx(0.5 * math.pi)


@given(st.floats(0.0, 60.0), st.floats(0.1, 30.0), st.floats(0.0, 5.0))
def test_a_turn_from_the_steepest_course_ends_on_the_line(off_m: float, radius_m: float, late_m: float) -> None:
    steepest = ARC.steepest_rad(off_m, radius_m, late_m)
    assert -1e-9 <= steepest <= 0.5 * math.pi + 1e-9
    needed_m = radius_m * (1.0 - math.cos(steepest)) + late_m * math.sin(steepest)
    assert needed_m == pytest.approx(min(off_m, radius_m + late_m), abs=1e-9)
