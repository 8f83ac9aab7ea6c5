"""Levelling of an inertial sensor that begins, or comes back, under way."""

from __future__ import annotations

import math

import pytest

from companion.nav.levelling import Levelling

GRAVITY_MPS2 = 9.81


def levelled(sideways_mps2: float, turn_radps: float) -> Levelling:
    levelling = Levelling()
    for k in range(200):
        levelling.update(0.01 * k, (0.0, sideways_mps2, -GRAVITY_MPS2), turn_radps)
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
