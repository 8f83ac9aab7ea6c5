"""The thesis's filter: steady speeds, consistency, and the same interface."""

from __future__ import annotations

import math

import pytest

from companion.baselines.reference import ThesisReference
from companion.params.store import Parameters


def test_steady_speed_is_a_fifth_of_the_carrot() -> None:
    for ahead_m in (1.5, 1.0):
        reference = ThesisReference(Parameters({"DPT_LEAD_AHEAD": ahead_m}))
        reference.start(0.0, 0.0, 0.0)
        reference.retarget(50.0, 0.0, 0.0)
        points = [reference.update(0.2) for _ in range(200)]
        assert points[-1].surge_mps == pytest.approx(0.2 * ahead_m, rel=1e-3)


def test_port_and_starboard_differ_and_heading_turns_the_short_way() -> None:
    reference = ThesisReference(Parameters())
    reference.start(0.0, 0.0, 3.0)
    reference.retarget(0.0, 0.0, -3.0)
    rates = [reference.update(0.1).yaw_rate_radps for _ in range(50)]
    assert min(rates) >= 0.0
    reference.start(0.0, 0.0, 0.0)
    reference.retarget(0.0, 50.0, 0.0)
    assert [reference.update(0.1).sway_mps for _ in range(300)][-1] == pytest.approx(0.12, rel=1e-2)
    reference.start(0.0, 0.0, 0.0)
    reference.retarget(0.0, -50.0, 0.0)
    assert [reference.update(0.1).sway_mps for _ in range(300)][-1] == pytest.approx(-0.1, rel=1e-2)


def test_it_arrives() -> None:
    reference = ThesisReference(Parameters())
    reference.start(0.0, 0.0, 0.0)
    reference.retarget(5.0, -5.0, math.radians(-45.0))
    for _ in range(1200):
        point = reference.update(0.1)
    assert reference.arrived
    assert point.north_m == pytest.approx(5.0, abs=0.01)
    assert point.east_m == pytest.approx(-5.0, abs=0.01)


def test_speed_shortens_the_carrot() -> None:
    reference = ThesisReference(Parameters())
    reference.start(0.0, 0.0, 0.0)
    reference.retarget(20.0, 0.0, 0.0, speed_mps=0.1)
    assert max(reference.update(0.1).surge_mps for _ in range(400)) == pytest.approx(0.1, rel=0.02)
