"""A sea as a sum of regular waves: spectrum, spread of directions, components from the seed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.config.dimensions.form import GRAVITY_MPS2
from companion.config.sea import SeaState, parse_waves
from companion.config.vessel import ConfigError
from companion.core.angles import TWO_PI
from sitl.noise import stream

Array = NDArray[np.float64]

COUNT = 48
LOWEST, HIGHEST = 0.55, 3.5  # of the peak's frequency: a part in a million lies below, less than a hundredth above
_FINE = 4000
_EVEN = 0.4  # share of the components that is spread evenly over frequency, so that the tail has some too


def parse_sea(text: str) -> SeaState | None:
    """As `parse_waves`. Raises ConfigError."""
    try:
        return parse_waves(text)
    except ValueError as error:
        raise ConfigError([str(error)]) from error


def peakedness(height_m: float, peak_s: float) -> float:
    """γ of the JONSWAP spectrum by steepness: 5 of the steepest sea, 1 (Pierson–Moskowitz) of a flat one
    (DNV-RP-C205, 3.5.5)."""
    steepness = peak_s / math.sqrt(height_m)
    return 5.0 if steepness <= 3.6 else math.exp(5.75 - 1.15 * steepness) if steepness < 5.0 else 1.0


def spectrum(omega: Array, height_m: float, peak_s: float) -> Array:
    """JONSWAP: spectral density of the elevation in m² s over angular frequencies in rad/s (Hasselmann et al. 1973,
    normalised as in DNV-RP-C205, 3.5.5)."""
    peak, gamma = TWO_PI / peak_s, peakedness(height_m, peak_s)
    width = np.where(omega <= peak, 0.07, 0.09)
    ratio = peak / omega
    pierson = 5.0 / 16.0 * height_m**2 * peak**4 * omega**-5.0 * np.exp(-1.25 * ratio**4)
    enhanced = gamma ** np.exp(-0.5 * ((omega - peak) / (width * peak)) ** 2)
    made: Array = (1.0 - 0.287 * math.log(gamma)) * pierson * enhanced
    return made


@dataclass(frozen=True, slots=True)
class Components:
    """Regular waves: elevation Σ a cos(ω t − k·x + ε), each with a frequency and a direction of its own, so that the
    mean of what is quadratic does not depend on the place. `towards`: directions in rad, (N,) each."""

    amplitude_m: Array
    omega_radps: Array
    number_radpm: Array
    towards_rad: Array
    phase_rad: Array


def components(state: SeaState, from_rad: float, seed: int, count: int = COUNT) -> Components:
    """The components of a sea that comes from `from_rad` in the mean.

    Each stands for a band of the spectrum, at a random place in it, with the band's energy; together they have the
    variance HS²/16. Directions are spread by cos² (DNV-RP-C205, 3.5.8, n = 2).
    """
    rng = stream(seed, "sea")
    peak = TWO_PI / state.peak_s
    fine = np.linspace(LOWEST * peak, HIGHEST * peak, _FINE)
    density = spectrum(fine, state.height_m, state.peak_s)
    energy = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(fine))])
    energy *= state.height_m**2 / 16.0 / energy[-1]
    mixed = (1.0 - _EVEN) * energy / energy[-1] + _EVEN * np.linspace(0.0, 1.0, _FINE)
    edges = np.interp(np.linspace(0.0, 1.0, count + 1), mixed, fine)
    omega = edges[:-1] + np.diff(edges) * np.array([rng.random() for _ in range(count)])
    shares = [(i + rng.random()) / count for i in range(count)]
    rng.shuffle(shares)
    return Components(
        np.sqrt(2.0 * np.diff(np.interp(edges, fine, energy))),
        omega,
        omega * omega / GRAVITY_MPS2,
        from_rad + math.pi + _spread(np.array(shares)),
        np.array([rng.uniform(0.0, TWO_PI) for _ in range(count)]),
    )


def _spread(share: Array) -> Array:
    """Angle below which that share of the energy lies: the inverse of ½ + (θ + sin θ cos θ)/π."""
    angle = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 721)
    made: Array = np.interp(share, 0.5 + (angle + np.sin(angle) * np.cos(angle)) / math.pi, angle)
    return made
