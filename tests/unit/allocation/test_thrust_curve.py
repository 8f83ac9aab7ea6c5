"""Force against throttle."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.allocation.thrust_curve import ThrustCurve
from tests.unit.control.simple_boat import REVOLT

BOW = REVOLT.thrusters[2]


def test_the_thesis_figures() -> None:
    curve = ThrustCurve(BOW)
    assert curve.force_n(0.5) == pytest.approx(1.518e-3 * 50**2)
    assert curve.force_n(-0.5) == pytest.approx(-6.172e-4 * 50**2)
    assert curve.force_n(1.0) == 14.0, "held to the limit"
    assert curve.force_n(-1.0) == -6.1


@pytest.mark.parametrize("force", [-6.0, -1.0, -0.01, 0.0, 0.02, 3.0, 13.9])
def test_there_and_back(force: float) -> None:
    curve = ThrustCurve(BOW)
    assert curve.force_n(curve.throttle(force)) == pytest.approx(force, abs=1e-12)


def test_limits_hold_for_any_force() -> None:
    curve = ThrustCurve(BOW)
    assert curve.throttle(1000.0) == pytest.approx((14.0 / 15.18) ** 0.5)
    assert curve.throttle(-1000.0) == pytest.approx(-((6.1 / 6.172) ** 0.5))


def test_a_force_inside_the_dead_band_becomes_0_or_its_edge() -> None:
    curve = ThrustCurve(replace(BOW, dead_band=0.1))
    edge = 15.18 * 0.01
    assert curve.force_n(0.09) == 0.0
    assert curve.throttle(0.4 * edge) == 0.0
    assert curve.throttle(0.6 * edge) == pytest.approx(0.1)
    assert curve.throttle(-0.06) == pytest.approx(-0.1)


def test_a_thruster_without_astern() -> None:
    curve = ThrustCurve(replace(BOW, min_n=0.0))
    assert curve.throttle(-5.0) == 0.0
