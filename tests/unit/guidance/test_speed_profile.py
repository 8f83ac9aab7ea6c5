"""Speeds along a track against the formulas they follow."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from companion.guidance.speed_profile import BendLimits, SpeedProfile

S_M = [0.1 * i for i in range(1001)]


def profile(
    curvature: list[float] | None = None,
    ends: tuple[float, ...] = (100.0,),
    speeds: tuple[float, ...] = (1.0,),
    stop: bool = True,
) -> SpeedProfile:
    limits = BendLimits(0.1, math.radians(12.0))
    return SpeedProfile(S_M, curvature or [0.0] * len(S_M), ends, speeds, limits, 0.08, stop)


def test_braking_to_a_stop_has_the_given_deceleration() -> None:
    speeds = profile()
    assert speeds.at(50.0) == 1.0
    assert speeds.at(100.0) == 0.0
    for s in (95.0, 98.0, 99.5):
        assert speeds.at(s) == pytest.approx(math.sqrt(2.0 * 0.08 * (100.0 - s)), rel=1e-6)
    assert profile(stop=False).at(100.0) == 1.0


def test_bends_limit_by_sideways_acceleration_and_by_yaw_rate() -> None:
    gentle = profile([0.15 if 400 <= i <= 600 else 0.0 for i in range(1001)])
    assert gentle.at(50.0) == pytest.approx(math.sqrt(0.1 / 0.15))
    tight = profile([0.8 if 400 <= i <= 600 else 0.0 for i in range(1001)])
    assert tight.at(50.0) == pytest.approx(math.radians(12.0) / 0.8)
    assert tight.at(39.0) == pytest.approx(math.sqrt(tight.at(40.0) ** 2 + 2.0 * 0.08 * 1.0), rel=1e-6), (
        "braked for before the bend"
    )
    assert tight.at(61.0) == pytest.approx(math.sqrt(tight.at(60.0) ** 2 + 2.0 * 0.08 * 1.0), rel=1e-6), (
        "left at the same rate"
    )


def test_no_bend_stops_the_boat() -> None:
    hairpin = profile([1000.0 if i == 500 else 0.0 for i in range(1001)])
    assert hairpin.at(50.0) == pytest.approx(0.25)


def test_each_leg_has_its_speed() -> None:
    legs = profile(ends=(30.0, 60.0, 100.0), speeds=(1.0, 0.5, 0.8))
    assert legs.at(10.0) == 1.0
    assert legs.at(31.0) == 0.5
    assert legs.at(30.2) <= 0.5 + 0.02, "braked for before the slower leg"
    assert legs.at(75.0) == pytest.approx(0.8)


def test_acceleration_is_bounded_everywhere() -> None:
    rng = np.random.default_rng(4)
    speeds = profile(list(rng.uniform(-1.0, 1.0, len(S_M))))
    values = [speeds.at(s) for s in S_M]
    for a, b in itertools.pairwise(values):
        assert abs(b * b - a * a) <= 2.0 * 0.08 * 0.1 + 1e-9


@pytest.mark.parametrize("last_mps", [0.0, 0.1, 0.3, 0.6, 1.0])
@pytest.mark.parametrize("s_m", [98.0, 99.0, 99.5, 99.9])
def test_the_speed_allowed_soon_is_that_of_the_place_it_leads_to(s_m: float, last_mps: float) -> None:
    """v² = 2a (left − T v) has one solution; asked for tick by tick, the speed stays at it."""
    speeds, lag_s = profile(), 2.0
    exact = math.sqrt((lag_s * 0.08) ** 2 + 2.0 * 0.08 * (100.0 - s_m)) - lag_s * 0.08
    assert speeds.soon(s_m, lag_s, last_mps) == pytest.approx(exact, abs=2e-3)
    assert speeds.soon(s_m, lag_s, exact) == pytest.approx(exact, abs=2e-3)


def test_where_nothing_slows_it_the_speed_allowed_soon_is_that_ahead() -> None:
    speeds = profile(ends=(30.0, 60.0, 100.0), speeds=(0.5, 1.0, 0.8))
    assert speeds.soon(10.0, 0.5, 0.2) == pytest.approx(0.5)
    assert speeds.soon(30.2, 0.5, 0.5) == pytest.approx(speeds.at(30.2 + 0.5 * speeds.soon(30.2, 0.5, 0.5)), abs=0.02)
    assert speeds.soon(30.2, 0.5, 0.5) > 0.5, "it speeds up"
