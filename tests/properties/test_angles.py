"""Angles and frames hold for every input."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.angles import nearest_turn, wrap_pi, wrap_two_pi
from companion.core.frames import body_to_ned, ned_to_body

ANGLES = st.floats(-1e4, 1e4)
QUICK = settings(deadline=None, derandomize=True, max_examples=100)


@QUICK
@given(ANGLES)
def test_wrapping_keeps_the_direction(angle_rad: float) -> None:
    for wrapped, low, high in ((wrap_pi(angle_rad), -math.pi, math.pi), (wrap_two_pi(angle_rad), 0.0, 2 * math.pi)):
        assert low <= wrapped <= high
        assert math.isclose(math.cos(wrapped), math.cos(angle_rad), abs_tol=1e-9)
        assert math.isclose(math.sin(wrapped), math.sin(angle_rad), abs_tol=1e-9)


@QUICK
@given(ANGLES, ANGLES)
def test_nearest_turn_is_within_half_a_turn(angle_rad: float, near_rad: float) -> None:
    assert abs(nearest_turn(angle_rad, near_rad) - near_rad) <= math.pi + 1e-9


def test_half_a_turn_has_one_name() -> None:
    assert wrap_pi(-math.pi) == math.pi == wrap_pi(math.pi)
    assert wrap_two_pi(-1e-20) == 0.0


@QUICK
@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(-10.0, 10.0))
def test_body_and_ned_are_inverse(x: float, y: float, yaw_rad: float) -> None:
    back = ned_to_body(*body_to_ned(x, y, yaw_rad), yaw_rad)
    assert math.isclose(back[0], x, abs_tol=1e-9) and math.isclose(back[1], y, abs_tol=1e-9)


def test_starboard_is_east_when_heading_north() -> None:
    assert body_to_ned(0.0, 1.0, 0.0) == (0.0, 1.0)
