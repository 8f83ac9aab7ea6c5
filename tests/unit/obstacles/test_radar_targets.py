"""Radar targets: what moves and what lies, by sentences with a motion and by positions alone."""

from __future__ import annotations

import math

import pytest

from companion.core.geodesy import LocalFrame
from companion.core.readings import RadarTarget
from companion.obstacles.radar_targets import RadarTargets
from tests.unit.estimates import AT_REST

FRAME = LocalFrame(63.44, 10.40)


def by_ttm(t_s: float, east_m: float) -> RadarTarget:
    return RadarTarget(t_s, "radar", 3, east_m, math.pi / 2, False, None, None, math.pi / 2, 2.0, False, False)


def by_tll(t_s: float, east_m: float) -> RadarTarget:
    return RadarTarget(t_s, "radar", 3, None, None, False, *FRAME.to_geodetic(0.0, east_m), None, None, False, False)


def test_a_target_that_comes_by_ttm_and_tll_in_turn_moves_steadily() -> None:
    targets = RadarTargets()
    for n in range(20):
        t_s = 1.5 * n
        targets.take((by_ttm if n % 2 == 0 else by_tll)(t_s, 100.0 + 2.0 * t_s), AT_REST, FRAME)
        (mover,) = targets.movers(t_s + 1.0)
        assert (mover.north_m, mover.east_m) == pytest.approx((0.0, 102.0 + 2.0 * t_s), abs=0.01)
        assert targets.circles() == []


def test_positions_alone_lie_and_an_old_motion_ends() -> None:
    targets = RadarTargets()
    targets.take(by_tll(0.0, 50.0), AT_REST, FRAME)
    assert targets.movers(0.0) == [] and len(targets.circles()) == 1
    targets.take(by_ttm(1.0, 50.0), AT_REST, FRAME)
    for t_s in range(2, 20):
        targets.take(by_tll(float(t_s), 50.0), AT_REST, FRAME)
        assert bool(targets.circles()) == (t_s > 16), t_s
