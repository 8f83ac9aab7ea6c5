"""What wild_points takes for a step that is followed, and for what the estimate moves by itself."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from sitl.scenarios.measure import EstimateError
from sitl.scenarios.wild_points import followed_s, moved_by_itself_m

_STEP_S, _STEP_M, _STILL_M = 100.0, 10, 0.7
_AXIS_M = _STEP_M * math.sqrt(0.5)


def errors_of(at: Callable[[float], tuple[float, float]], until_s: float) -> list[EstimateError]:
    """Errors ten times a second, of an estimate that is off by `at(t_s)`."""
    times = [0.1 * k for k in range(round(10.0 * until_s) + 1)]
    return [EstimateError(t_s, *at(t_s), 0.0, 0.0, 0.0) for t_s in times]


def after_s(before: tuple[float, float], after: tuple[float, float], wander_m: tuple[float, float]) -> float:
    """When the step counts as followed by an estimate that goes from one error to the other after 2 s."""
    errors = errors_of(lambda t_s: before if t_s < _STEP_S + 1.95 else after, _STEP_S + 5.0)
    return followed_s(errors, {"step_s": _STEP_S, "step_m": _STEP_M, "wander_m": wander_m}, _STILL_M)


def test_a_boat_that_had_learnt_of_the_receivers_slow_error_follows_by_less_than_the_step() -> None:
    wander_m = -1.2, -1.2
    at_receiver = _AXIS_M + wander_m[0], _AXIS_M + wander_m[1]
    assert after_s((-0.2, 0.5), at_receiver, wander_m) == pytest.approx(2.0)


def test_one_that_stays_or_comes_half_way_has_not_followed() -> None:
    assert after_s((0.0, 0.0), (0.0, 0.0), (0.0, 0.0)) == math.inf
    assert after_s((0.0, 0.0), (0.5 * _AXIS_M, 0.5 * _AXIS_M), (0.0, 0.0)) == math.inf
    assert after_s((0.0, 0.0), (_AXIS_M, _AXIS_M), (0.0, 0.0)) == pytest.approx(2.0)


def test_more_windows_find_the_larger_move_of_a_receiver_that_wanders() -> None:
    errors = errors_of(lambda t_s: (0.3 * min(max(t_s - 60.0, 0.0) / 10.0, 1.0), 0.0), 105.0)
    assert moved_by_itself_m(errors, 0.0, 15.0, 2) == 0.0
    assert moved_by_itself_m(errors, 0.0, 15.0, 7) == pytest.approx(0.3)
