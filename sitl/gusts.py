"""Gusts by a published spectrum, and the wind's profile with height. The mean wind is then that at 10 m."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from companion.config.vessel import ConfigError
from companion.core.angles import TWO_PI
from sitl.environment import parse_directed
from sitl.noise import stream

Array = NDArray[np.float64]
Spectrum = Callable[[Array, float, float], Array]

_DRAG = 0.0015  # of the sea's surface (Davenport's κ)
_ROUGH_M, _KARMAN = 0.0002, 0.4  # open sea (DNV-RP-C205, table 2-1)
_COUNT, _FINE = 48, 60
_SLOWEST_HZ, _FASTEST_HZ = 1.0 / 600.0, 1.0
_HALVINGS = 40
_STORM_MPS = 1000.0  # no profile with such a wind at 10 m means anything


def davenport(f_hz: Array, mean_mps: float, height_m: float) -> Array:
    """Davenport 1961, the same at all heights: f S = 4 κ U² χ²/(1 + χ²)^(4/3), χ = 1200 f/U, U at 10 m."""
    ratio = 1200.0 * f_hz / mean_mps
    made: Array = 4.0 * _DRAG * mean_mps**2 * ratio**2 / (1.0 + ratio**2) ** (4.0 / 3.0) / f_hz
    return made


def kaimal(f_hz: Array, mean_mps: float, height_m: float) -> Array:
    """Kaimal et al. 1972: f S = 105 u*² n/(1 + 33 n)^(5/3), n = f z/U(z), u* of the logarithmic profile."""
    friction = _KARMAN * mean_mps / math.log(10.0 / _ROUGH_M)
    reduced = f_hz * height_m / _logarithmic(mean_mps, height_m)
    made: Array = 105.0 * friction**2 * reduced / (1.0 + 33.0 * reduced) ** (5.0 / 3.0) / f_hz
    return made


def npd(f_hz: Array, mean_mps: float, height_m: float) -> Array:
    """NPD (Frøya; DNV-RP-C205, 2.3.4.11): S = 320 (U/10)² (z/10)^0.45/(1 + x^0.468)^(5/1.404), x = 172 f (z/10)^⅔
    (U/10)^−0.75, U at 10 m."""
    at = 172.0 * f_hz * (height_m / 10.0) ** (2.0 / 3.0) * (mean_mps / 10.0) ** -0.75
    made: Array = 320.0 * (mean_mps / 10.0) ** 2 * (height_m / 10.0) ** 0.45 / (1.0 + at**0.468) ** (5.0 / 1.404)
    return made


def _logarithmic(mean_mps: float, height_m: float) -> float:
    return mean_mps * math.log(height_m / _ROUGH_M) / math.log(10.0 / _ROUGH_M)


def _npd_profile(mean_mps: float, height_m: float) -> float:
    """U(z) = U (1 + C ln z/10), C = 0.0573 √(1 + 0.15 U)."""
    return mean_mps * (1.0 + 0.0573 * math.sqrt(1.0 + 0.15 * mean_mps) * math.log(height_m / 10.0))


SPECTRA: Mapping[str, tuple[Spectrum, Callable[[float, float], float]]] = {
    "davenport": (davenport, _logarithmic),
    "kaimal": (kaimal, _logarithmic),
    "npd": (npd, _npd_profile),
}


def parse_wind(text: str) -> tuple[float, float | None, str]:
    """`6@45/npd` → (6 m/s, 45° in radians, "npd"); without a direction None, without a spectrum "". Raises
    ConfigError."""
    wind, slash, name = text.partition("/")
    if name.strip() == "s":
        raise ConfigError([f"wind '{text}': write MPS@DEG, as 2@45, or MPS alone, without a unit"])
    if slash and name not in SPECTRA:
        raise ConfigError(
            [f"wind '{text}': gusts by {', '.join(SPECTRA)}, as 6@45/npd, or nothing behind the direction"]
        )
    return *parse_directed(wind, "wind"), name


def at_height(name: str, mean_mps: float, height_m: float) -> float:
    """Mean wind at a height above the water, of that at 10 m."""
    return SPECTRA[name][1](mean_mps, height_m)


def at_ten_metres(name: str, mean_mps: float, height_m: float) -> float:
    """Mean wind at 10 m, of that at a lower height above the water. Raises ConfigError for one that no wind at 10 m
    makes there: near the water NPD's profile slows a stronger wind more than it is stronger."""
    low, high = mean_mps, mean_mps
    while at_height(name, high, height_m) < mean_mps:
        high *= 2.0
        if high > _STORM_MPS:
            high = _windiest(name, mean_mps, height_m)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if at_height(name, middle, height_m) < mean_mps else (low, middle)
    return high


def _windiest(name: str, mean_mps: float, height_m: float) -> float:
    """The wind at 10 m that makes the strongest one at that height. Raises ConfigError where that is weaker than
    `mean_mps`."""
    winds = [0.1 * tenth for tenth in range(1, round(10.0 * _STORM_MPS))]
    best = max(winds, key=lambda wind_mps: at_height(name, wind_mps, height_m))
    most_mps = at_height(name, best, height_m)
    if most_mps < mean_mps:
        raise ConfigError(
            [
                f"wind of {mean_mps:g} m/s at the boat, {height_m:.2g} m above the water: by the spectrum '{name}' it "
                f"has {most_mps:.1f} m/s there at most; ask for less, or for gusts by davenport or kaimal"
            ]
        )
    return best


class Gusts:
    """Sum of harmonics whose bands have the spectrum's energy, 0.1 to 60 in a minute; `value` is the speed beside the
    mean. Remembers the time."""

    def __init__(self, name: str, mean_mps: float, height_m: float, seed: int) -> None:
        """`mean_mps`: at 10 m."""
        rng = stream(seed, f"wind {name}")
        edges = np.geomspace(_SLOWEST_HZ, _FASTEST_HZ, _COUNT + 1)
        sigma2 = []
        for low, high in pairwise(edges):
            f_hz = np.linspace(low, high, _FINE)
            density = SPECTRA[name][0](f_hz, mean_mps, height_m)
            sigma2.append(float(np.sum(0.5 * (density[1:] + density[:-1]) * np.diff(f_hz))))
        self._amplitudes = np.sqrt(2.0 * np.array(sigma2))
        share = np.array([rng.random() for _ in range(_COUNT)])
        self._omegas = TWO_PI * (edges[:-1] + share * np.diff(edges))
        self._phases = np.array([rng.uniform(0.0, TWO_PI) for _ in range(_COUNT)])
        self._t_s = 0.0
        self.value = self.update(0.0)

    def update(self, dt_s: float) -> float:
        """Advance by `dt_s`; returns the new value."""
        self._t_s += dt_s
        self.value = float(self._amplitudes @ np.cos(self._omegas * self._t_s + self._phases))
        return self.value
