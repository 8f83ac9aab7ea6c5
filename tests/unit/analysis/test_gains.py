"""Bandwidths by design, against loops whose margins can be worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.analysis.gains import GAIN_MARGIN_DB, PHASE_MARGIN_DEG, Loop, designed
from companion.app import load_vessel
from companion.params.table import table_of

REVOLT = load_vessel("revolt")
PARAMETERS = {spec.name: spec.default for spec in table_of(REVOLT)}


def test_margins_of_a_double_integrator_with_pd_and_delay() -> None:
    """ω = 0.5, ζ = 0.7, no drag, no lag: |L| = 1 at w with w⁴ = ω⁴ + (2 ζ ω w)²; the delay takes w·T of the phase."""
    w0, zeta = 0.5, 0.7
    b = 2.0 * zeta * zeta
    w = w0 * math.sqrt(b + math.sqrt(b * b + 1.0))
    phase = math.degrees(math.atan2(2.0 * zeta * w / w0, 1.0))
    for delay_s in (0.0, 0.4):
        loop = Loop(100.0, 0.0, 0.0, delay_s, 0.0, zeta, 0.0)
        gain_db, margin = loop.margins(w0)
        assert margin == pytest.approx(phase - math.degrees(w * delay_s), abs=0.5)
        assert math.isinf(gain_db) == (delay_s == 0.0)


def test_lag_lowers_what_is_possible_and_the_margins_are_kept() -> None:
    found = []
    for lag_s in (0.1, 0.5, 1.5):
        loop = Loop(100.0, 10.0, lag_s, 0.15, 0.3, 0.8, 0.1)
        value, limited = loop.highest(3.0)
        gain_db, phase_deg = loop.margins(value)
        assert limited and gain_db >= GAIN_MARGIN_DB and phase_deg >= PHASE_MARGIN_DEG
        found.append(value)
    assert found[0] > found[1] > found[2]


def test_thrust_and_receiver_limit_too() -> None:
    hull = REVOLT.hull
    designs = {d.name: d for d in designed(REVOLT, hull, 0.05, PARAMETERS | {"DP_SMOOTH_T": 0.0})}
    assert set(designs) == {"DP_BW_SURGE", "DP_BW_SWAY", "DP_BW_YAW", "PATH_BW_YAW"}
    assert designs["DP_BW_SWAY"].limit == "thrust"
    assert designs["DP_BW_SWAY"].value == pytest.approx(math.sqrt(REVOLT.limits.sway_n / 0.7 / hull.m22_kg), abs=0.01)
    strong = replace(REVOLT, limits=replace(REVOLT.limits, surge_n=5000.0))
    assert designed(strong, hull, 0.05, PARAMETERS | {"DP_SMOOTH_T": 0.0})[0].value == pytest.approx(0.6, abs=0.01)
    aside = replace(REVOLT, limits=replace(REVOLT.limits, sway_n=0.0))
    assert "DP_BW_SWAY" not in {d.name for d in designed(aside, hull, 0.3, PARAMETERS)}
