"""Lift and drag of sails and fins against theory, and against each other at the edges of the formulae."""

from __future__ import annotations

import math

import pytest

from sitl.foil import Foil

FIN = Foil(4.0, math.radians(18.0), 0.01)
SAIL = Foil(2.5, math.radians(18.0), 0.04, math.radians(5.0), math.radians(5.0), 0.1)


def test_small_angles_follow_the_lifting_line() -> None:
    lift, drag = FIN.coefficients(math.radians(6.0))
    assert lift == pytest.approx(2.0 * math.pi * 4.0 / 6.0 * math.radians(6.0))
    assert drag == pytest.approx(0.01 + lift**2 / (0.9 * math.pi * 4.0))


@pytest.mark.parametrize("foil", [FIN, SAIL])
def test_it_is_continuous_at_the_stall_and_a_plate_across_the_flow(foil: Foil) -> None:
    before, after = (foil.coefficients(math.radians(18.0 + step)) for step in (-1e-6, 1e-6))
    assert before == pytest.approx(after, abs=1e-4)
    lift, drag = foil.coefficients(math.radians(90.0))
    assert abs(lift) < 1e-9
    assert 1.1 < drag < 1.2


def test_the_other_side_mirrors_the_lift_and_keeps_the_drag() -> None:
    for degrees in (3.0, 15.0, 40.0, 80.0, 120.0, 170.0):
        (lift, drag), (other, same) = FIN.coefficients(math.radians(degrees)), FIN.coefficients(-math.radians(degrees))
        assert (other, same) == pytest.approx((-lift, drag))


def test_a_soft_sail_luffs_in_the_wind_and_lifts_as_in_the_wind_tunnel() -> None:
    lift, drag = SAIL.coefficients(0.0)
    assert lift == 0.0
    assert drag == pytest.approx(0.14)
    most = max(SAIL.coefficients(math.radians(degrees))[0] for degrees in range(91))
    assert 1.3 < most < 1.5
