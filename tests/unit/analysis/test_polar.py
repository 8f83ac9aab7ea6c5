"""The capability polar against what is known of simple boats, and against the consequence check."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.allocation.geometry import thrusters_of
from companion.analysis.polar import MOST_MPS, polar, wrench_against
from companion.app import load_vessel
from companion.positioning.consequence import is_met

REVOLT = load_vessel("revolt")


def test_at_the_edge_the_thrusters_just_give_the_wrench() -> None:
    made = polar(REVOLT, directions=8)
    assert made is not None
    limits = (REVOLT.limits.surge_n, REVOLT.limits.sway_n, REVOLT.limits.yaw_nm)
    for angle, most in zip(made.from_rad, made.holds_mps, strict=True):
        assert most is not None and 1.0 < most < MOST_MPS
        assert is_met(thrusters_of(REVOLT), limits, wrench_against(REVOLT, most, angle), frozenset())
        beyond = wrench_against(REVOLT, most + 0.5, angle)
        past = any(
            abs(value) > limit
            for value, limit in zip((beyond.surge_n, beyond.sway_n, beyond.yaw_nm), limits, strict=True)
        )
        assert past or not is_met(thrusters_of(REVOLT), limits, beyond, frozenset())


def test_a_thruster_less_never_holds_more() -> None:
    made = polar(REVOLT, directions=8)
    assert made is not None
    for most, worst in zip(made.holds_mps, made.worst_mps, strict=True):
        assert most is not None and worst is not None and worst <= most
    assert made.missed[2] == "bow"  # beam wind: only the bow thruster balances the moment


def test_a_current_from_ahead_takes_what_wind_from_ahead_needs() -> None:
    calm, stream = polar(REVOLT, directions=4), polar(REVOLT, (-0.3, 0.0), directions=4)
    assert calm is not None and stream is not None
    assert calm.holds_mps[0] is not None and stream.holds_mps[0] is not None
    assert stream.holds_mps[0] < calm.holds_mps[0] - 1.0


def test_too_much_current_holds_nowhere() -> None:
    made = polar(REVOLT, (-5.0, 0.0), directions=4)
    assert made is not None and made.holds_mps == (None,) * 4


def test_a_symmetrical_boat_has_a_symmetrical_polar() -> None:
    stern = [t for t in REVOLT.thrusters if t.kind == "azimuth"]
    even = replace(
        REVOLT, thrusters=tuple(replace(t, min_n=-t.max_n, astern_n=t.ahead_n) for t in (*stern, REVOLT.thrusters[2]))
    )
    made = polar(even, directions=8)
    assert made is not None
    for i in range(1, 4):
        port, starboard = made.holds_mps[8 - i], made.holds_mps[i]
        assert port is not None and starboard is not None and port == pytest.approx(starboard, abs=0.5)


def test_a_boat_without_sideways_thrust_has_none() -> None:
    assert polar(load_vessel("rescuerunner")) is None


def test_the_wind_pushes_with_the_square_of_its_speed() -> None:
    slow, fast = wrench_against(REVOLT, 5.0, 0.5 * math.pi), wrench_against(REVOLT, 10.0, 0.5 * math.pi)
    assert fast.sway_n == pytest.approx(4.0 * slow.sway_n) and slow.sway_n > 0.0  # wind from starboard: push there


def test_an_oblique_current_turns_the_hull() -> None:
    """The Munk moment: (m22 − m11)·u·v of a hull that moves through the water."""
    hull, u, v = REVOLT.hull, 0.2, -0.1
    still, flowing = wrench_against(REVOLT, 0.0, 0.0), wrench_against(REVOLT, 0.0, 0.0, (-u, -v))
    drag_nm = hull.damping.n_v * v + hull.damping.n_vv * abs(v) * v
    assert still.yaw_nm == 0.0
    assert flowing.yaw_nm == pytest.approx((hull.m22_kg - hull.m11_kg) * u * v + drag_nm)
