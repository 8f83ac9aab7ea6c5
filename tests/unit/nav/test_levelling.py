"""Levelling of an inertial sensor that begins, or comes back, under way."""

from __future__ import annotations

import math

import pytest

from companion.nav.levelling import Levelling

GRAVITY_MPS2 = 9.81


def levelled(sideways_mps2: float, turn_radps: float) -> Levelling:
    levelling = Levelling()
    for k in range(200):
        levelling.update(0.01 * k, (0.0, sideways_mps2, -GRAVITY_MPS2), (0.0, 0.0, turn_radps))
    return levelling


def test_a_turn_is_no_heel() -> None:
    """8 m/s and 0.4 rad/s push by 3.2 m/s², as a heel of 18° would."""
    levelling = levelled(8.0 * 0.4, 0.4)
    assert levelling.tilt() == pytest.approx((-math.atan2(3.2, GRAVITY_MPS2), 0.0), abs=1e-6)
    assert levelling.tilt(8.0) == pytest.approx((0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize(("surge_mps", "least_deg", "most_deg"), [(0.0, 2.0, 2.0), (0.4, 2.0, 2.0), (8.0, 10.0, 15.0)])
def test_the_faster_the_boat_the_less_sure_the_tilt(surge_mps: float, least_deg: float, most_deg: float) -> None:
    sigma_deg = math.degrees(levelled(0.0, 0.4).sigma_rad(surge_mps))
    assert least_deg - 1e-9 <= sigma_deg <= most_deg + 1e-9


@pytest.mark.parametrize("since_s", [1.1, 1.7, 2.3, 2.9])
def test_a_boat_that_rolls_is_where_it_is_now(since_s: float) -> None:
    """Every 3 s by 20°: the mean force alone was up to 19° off, with a claimed sigma of 2°."""
    levelling, roll = Levelling(), math.radians(20.0)
    for k in range(round(100 * since_s) + 1):
        angle, rate = roll * math.sin(2.1 * 0.01 * k), 2.1 * roll * math.cos(2.1 * 0.01 * (k - 0.5))
        force = 0.0, -GRAVITY_MPS2 * math.sin(angle), -GRAVITY_MPS2 * math.cos(angle)
        levelling.update(0.01 * k, force, (rate, 0.0, 0.0))
    assert levelling.tilt() == pytest.approx((angle, 0.0), abs=math.radians(0.3))
