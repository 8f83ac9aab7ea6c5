"""Waves in a log are found by their period, and what is slower is kept."""

from __future__ import annotations

import numpy as np
import pytest

from companion.analysis.band import band_of, wave_period_s
from companion.analysis.disturbance import Array

PERIOD_S = 0.1
T_S = np.arange(0.0, 300.0, PERIOD_S)
WHOLE = ((0, len(T_S)),)


def sailing(wave_mps: float, wave_s: float = 2.0) -> Array:
    """(n, 3): slow manoeuvres, noise of the estimate, and waves that carry the boat to and fro."""
    noise = np.random.default_rng(3).normal(0.0, 0.003, (len(T_S), 3))
    slow = np.stack([0.5 * np.sin(0.08 * T_S), 0.2 * np.sin(0.13 * T_S), 0.2 * np.sin(0.11 * T_S)], axis=1)
    waves = wave_mps * np.sin(2.0 * np.pi / wave_s * T_S)
    return np.asarray(slow + noise + np.stack([waves, 0.6 * waves, 0.0 * waves], axis=1))


def test_waves_are_found_by_their_period() -> None:
    found = wave_period_s(sailing(0.05), WHOLE, PERIOD_S)
    assert found == pytest.approx(2.0, rel=0.15)


def test_calm_water_has_no_waves() -> None:
    assert wave_period_s(sailing(0.0), WHOLE, PERIOD_S) is None
    assert wave_period_s(sailing(0.05), ((0, 100),), PERIOD_S) is None  # too short to tell


def test_the_band_ends_below_the_waves() -> None:
    calm, rough = band_of(None, WHOLE, PERIOD_S), band_of(2.0, WHOLE, PERIOD_S)
    assert not calm.waves and rough.waves and rough.highest_hz == pytest.approx(0.25)
    assert rough.every > calm.every and rough.period_s == pytest.approx(rough.every * PERIOD_S)
    left = rough.calm(sailing(0.05)) - sailing(0.0)
    inside = slice(100, -100)
    assert np.abs(left[inside, 0]).max() < 0.02  # of 0.05
    assert np.abs(rough.calm(sailing(0.0))[inside] - sailing(0.0)[inside]).max() < 0.02


def test_samples_are_those_of_their_stretches() -> None:
    stretches = ((0, 1001), (1500, 3000))
    band = band_of(2.0, stretches, PERIOD_S)
    columns = sailing(0.05)
    sampled, calm = band.sampled(columns), band.calm(columns)
    assert len(sampled) == band.stretches[-1][1]
    for (first, end), (begin, stop) in zip(stretches, band.stretches, strict=True):
        assert sampled[begin:stop] == pytest.approx(calm[first : end : band.every])
    assert (calm[1001:1500] == columns[1001:1500]).all()
