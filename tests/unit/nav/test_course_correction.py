"""The slow turn of the heading towards the course: gain and gate of the thesis, and what wind and current may
explain."""

from __future__ import annotations

import math

import pytest

from companion.nav.course_correction import CourseCorrection

ERROR_RAD = math.radians(45.0)


def corrected(
    seconds: float,
    speed_mps: float = 8.0,
    drift_mps: float | None = None,
    rate_radps: float = 0.0,
    hz: float = 200.0,
    time_s: float = 50.0,
) -> float:
    """Degrees that a heading 45° off has been turned, course north."""
    correction, turned = CourseCorrection(), 0.0
    for k in range(round(seconds * hz)):
        t_s = k / hz
        if k % round(hz / 10.0) == 0:
            correction.velocity(t_s, speed_mps, 0.0)
        turned += correction.update(t_s, -ERROR_RAD + turned, rate_radps, time_s, drift_mps)
    return math.degrees(turned)


def test_a_third_of_45_degrees_in_20_s() -> None:
    """After the 10 s of the gate; the thesis saw about a third, (1 − 1e-4)^4000 leaves 0.670."""
    assert (
        corrected(30.0) / 45.0 == pytest.approx(1.0 - (1.0 - 1e-4) ** 4000, abs=0.001) == pytest.approx(1 / 3, abs=0.01)
    )
    assert corrected(30.0, hz=10.0) == pytest.approx(corrected(30.0), abs=0.2)


def test_only_after_10_s_above_5_mps() -> None:
    assert corrected(9.9) == 0.0
    assert corrected(60.0, speed_mps=5.0) == 0.0
    assert corrected(60.0, time_s=0.0) == 0.0


def test_a_slow_second_starts_the_10_s_anew() -> None:
    correction, turned = CourseCorrection(), 0.0
    for k in range(290):
        t_s = 0.1 * k
        correction.velocity(t_s, 4.9 if 190 <= k < 192 else 8.0, 0.0)
        step = correction.update(t_s, -ERROR_RAD, 0.0, 50.0, None)
        turned += step
        assert (step != 0.0) == (100 < k < 190), k
    assert turned > 0.0


def test_what_drift_explains_is_not_corrected() -> None:
    assert corrected(1000.0, drift_mps=0.5) == pytest.approx(45.0 - math.degrees(math.asin(0.5 / 8.0)), abs=0.1)
    assert corrected(1000.0, drift_mps=0.0) == pytest.approx(45.0, abs=0.1)


def test_nothing_is_corrected_while_the_boat_turns() -> None:
    turning = math.radians(5.0)
    assert corrected(60.0, drift_mps=0.5, rate_radps=turning) == 0.0
    assert corrected(60.0, rate_radps=turning) > 25.0  # the thesis goes on


def test_an_old_course_is_not_used() -> None:
    correction = CourseCorrection()
    for k in range(200):
        correction.velocity(0.1 * k, 8.0, 0.0)
        correction.update(0.1 * k, 0.5, 0.0, 50.0, None)
    assert correction.update(20.5, 0.5, 0.0, 50.0, None) != 0.0
    assert correction.update(21.1, 0.5, 0.0, 50.0, None) == 0.0
