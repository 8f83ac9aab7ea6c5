"""A sea by its spectrum: what was asked for is what the components have, in the mean and over half an hour."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from companion.config.sea import SeaState, parse_waves
from companion.config.vessel import ConfigError
from sitl.sea_state import HIGHEST, LOWEST, components, parse_sea, peakedness, spectrum


def test_texts() -> None:
    assert parse_waves("") is None and parse_waves("0") is None
    assert parse_waves("0.25") == SeaState(0.25, None, 4.2 * 0.5)
    assert parse_waves("0.2@90/2.5") == SeaState(0.2, math.radians(90.0), 2.5)
    assert parse_waves("0.2/2.5") == SeaState(0.2, None, 2.5)
    assert parse_waves("0.2@-90") == parse_waves("0.2@270")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("high", "write HS"),
        ("0.2@north", "write HS"),
        ("0.2/", "write HS"),
        ("-1", "height must be 0 to 10 m"),
        ("nan", "height must be"),
        ("0.2@1000", "must be in degrees"),
        ("0.2/0.1", "period must be 0.3 to 25 s"),
        ("0.5/1", "so steep they break; 0.5 m needs a period above 1.5 s"),
    ],
)
def test_what_no_sea_has_is_refused(text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        parse_sea(text)


@pytest.mark.parametrize(("height_m", "peak_s"), [(0.1, 1.33), (0.5, 2.97), (0.3, 1.9), (0.4, 5.0)])
def test_the_spectrum_holds_the_variance_of_the_height(height_m: float, peak_s: float) -> None:
    """Hs²/16; the constant of JONSWAP (1 − 0.287 ln γ) is itself a fit to within 2 %."""
    peak = math.tau / peak_s

    def density(omega: float) -> float:
        return float(spectrum(np.array([omega]), height_m, peak_s)[0])

    total = quad(density, 0.3 * peak, 2.0 * peak, limit=400)[0] + quad(density, 2.0 * peak, 40.0 * peak, limit=400)[0]
    assert total == pytest.approx(height_m**2 / 16.0, rel=0.02)


def test_a_long_sea_has_the_spectrum_of_pierson_and_moskowitz() -> None:
    """0.0081 g² ω⁻⁵ e^(−1.25 (ω_p/ω)⁴), where a sea's height belongs to its period as theirs does: 0.0081 g² = 5/16 H²
    ω_p⁴."""
    peak_s = 5.0
    peak = math.tau / peak_s
    height_m = math.sqrt(0.0081 * 9.81**2 * 16.0 / 5.0) / peak**2
    assert peakedness(height_m, 5.0 * math.sqrt(height_m)) == 1.0
    omega = np.linspace(0.7, 3.0, 30) * peak
    theirs = 0.0081 * 9.81**2 * omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4)
    gamma = peakedness(height_m, peak_s)
    away = (omega < 0.75 * peak) | (omega > 1.6 * peak)  # from the peak, which γ raises
    ours = spectrum(omega, height_m, peak_s) / (1.0 - 0.287 * math.log(gamma))
    assert ours[away] == pytest.approx(theirs[away], rel=0.02)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_components_have_the_energy_of_their_bands(seed: int) -> None:
    """Below each edge, within the width of one band, lies what the spectrum has there; all of it is Hs²/16."""
    state = SeaState(0.3, None, 2.3)
    sea = components(state, 0.0, seed)
    energy = 0.5 * sea.amplitude_m**2
    assert energy.sum() == pytest.approx(0.3**2 / 16.0, rel=1e-9)
    assert all(a < b for a, b in pairwise(sea.omega_radps))
    assert sea.number_radpm == pytest.approx(sea.omega_radps**2 / 9.81)
    peak = math.tau / 2.3
    for ratio in (0.9, 1.1, 1.5, 2.0):
        below = quad(lambda w: float(spectrum(np.array([w]), 0.3, 2.3)[0]), LOWEST * peak, ratio * peak)[0]
        assert energy[sea.omega_radps < ratio * peak].sum() == pytest.approx(below, abs=0.06 * 0.3**2 / 16.0)
    assert sea.omega_radps[0] > LOWEST * peak and sea.omega_radps[-1] < HIGHEST * peak


def test_the_height_is_found_again_in_half_an_hour() -> None:
    """Four standard deviations of the elevation at one place, over 30 min."""
    for seed in range(4):
        sea = components(SeaState(0.2, None, 1.88), 1.0, seed)
        t = np.arange(0.0, 1800.0, 0.1)[:, None]
        elevation = (sea.amplitude_m * np.cos(sea.omega_radps * t + sea.phase_rad)).sum(axis=1)
        assert 4.0 * elevation.std() == pytest.approx(0.2, rel=0.05)


def test_directions_are_spread_about_the_way_it_goes() -> None:
    """By cos²: a standard deviation of √(π²/12 − ½) = 32.5°, none beyond 90°."""
    angles = np.concatenate(
        [components(SeaState(0.2, None, 1.88), math.radians(30.0), seed).towards_rad for seed in range(20)]
    )
    off = angles - math.radians(210.0)
    assert np.degrees(off.mean()) == pytest.approx(0.0, abs=2.0)
    assert np.degrees(off.std()) == pytest.approx(32.5, abs=1.0)
    assert np.degrees(np.abs(off)).max() < 90.0


def test_a_sea_is_that_of_its_seed() -> None:
    state = SeaState(0.2, None, 1.88)
    first, again, other = (components(state, 0.0, seed) for seed in (1, 1, 2))
    assert (first.phase_rad == again.phase_rad).all() and (first.phase_rad != other.phase_rad).any()
