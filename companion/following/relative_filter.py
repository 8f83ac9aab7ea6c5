"""The lead boat's place relative to this boat: a Kalman filter over what two receivers say of it.

The state is, on each axis, the relative position p, an error b of the relative velocity that moves it, and the slow
error e by which the difference of the two receivers' positions is wrong:

    p' = v + b,   b and e first-order Gauss–Markov processes,   difference = p + e + noise,   moving base = p + noise

v is the difference of both boats' velocities over ground. Receivers measure these by Doppler, to centimetres a second,
while multipath moves their positions for a minute by decimetres: so p follows v, and the differences with the time
that the two errors ask for. While a moving base gives p, the filter learns e and b, and carries p on without it.

Both axes have the same errors: one 3×3 covariance serves for both. Sources: Bar-Shalom, Li & Kirubarajan (2001), 8.2,
on coloured noise by a larger state; Misra & Enge (2011), 5.4, on which errors two receivers share.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_VELOCITY_MPS, _VELOCITY_TAU_S = 0.01, 5.0  # b: steady part of a Doppler velocity's error, and of the boat's own
_WALK_M = 0.02  # m/√s: what changes faster than b
_SLOW_TAU_S = 60.0  # e: multipath of receivers under way, and constellations that differ by a satellite
_UNKNOWN_M = 1000.0

_P, _B, _E = range(3)
_DIFFERENCE = np.array([1.0, 0.0, 1.0])
_BASE = np.array([1.0, 0.0, 0.0])


class RelativeFilter:
    """`advance` and the updates in order of time. Positions are (north, east) in m of the lead boat from this one.

    Remembers state, covariance and the sigma of the slow error.
    """

    __slots__ = ("_covariance", "_slow_m", "_state")

    def __init__(self) -> None:
        self._slow_m = 0.0
        self._state: NDArray[np.float64] = np.zeros((3, 2))
        self._covariance: NDArray[np.float64] = np.zeros((3, 3))
        self.forget()

    def forget(self) -> None:
        """Begin anew, with nothing known."""
        self._state[:] = 0.0
        self._covariance[:] = np.diag([_UNKNOWN_M**2, _VELOCITY_MPS**2, self._slow_m**2])

    @property
    def position_m(self) -> tuple[float, float]:
        """(north, east) of the lead boat from this one, m."""
        return float(self._state[_P, 0]), float(self._state[_P, 1])

    @property
    def sigma_m(self) -> float:
        """One sigma of the position on each axis, m."""
        return math.sqrt(self._covariance[_P, _P])

    @property
    def difference_m(self) -> tuple[float, float, float]:
        """(north, east) that the receivers' difference should be now, and its sigma on each axis, without noise."""
        north, east = _DIFFERENCE @ self._state
        return float(north), float(east), math.sqrt(_DIFFERENCE @ self._covariance @ _DIFFERENCE)

    def suppose(self, slow_m: float) -> None:
        """Sigma of the slow error of the difference, on each axis. Another value begins that error anew."""
        if math.isclose(slow_m, self._slow_m, rel_tol=0.1):
            return
        self._slow_m = slow_m
        self._state[_E] = 0.0
        self._covariance[_E, :] = self._covariance[:, _E] = 0.0
        self._covariance[_E, _E] = slow_m * slow_m

    def advance(self, moved_m: tuple[float, float], dt_s: float) -> None:
        """`dt_s` later, in which the velocities moved the lead boat by that much from this one, (north, east)."""
        keeps_b, keeps_e = math.exp(-dt_s / _VELOCITY_TAU_S), math.exp(-dt_s / _SLOW_TAU_S)
        reach_s = _VELOCITY_TAU_S * (1.0 - keeps_b)
        step = np.array([[1.0, reach_s, 0.0], [0.0, keeps_b, 0.0], [0.0, 0.0, keeps_e]])
        self._state = step @ self._state
        self._state[_P] += moved_m
        covariance = step @ self._covariance @ step.T
        covariance[_P, _P] += _WALK_M**2 * dt_s
        covariance[_B, _B] += _VELOCITY_MPS**2 * (1.0 - keeps_b**2)
        covariance[_E, _E] += self._slow_m**2 * (1.0 - keeps_e**2)
        self._covariance = covariance

    def take_difference(self, north_m: float, east_m: float, noise_m: float) -> None:
        """Update by the difference of both receivers' positions now. `noise_m`: one sigma of what is not slow."""
        self._take(_DIFFERENCE, (north_m, east_m), noise_m)

    def take_base(self, north_m: float, east_m: float, sigma_m: float) -> None:
        """Update by the vector of a moving base now."""
        self._take(_BASE, (north_m, east_m), sigma_m)

    def _take(self, row: NDArray[np.float64], measured_m: tuple[float, float], sigma_m: float) -> None:
        covariance = self._covariance
        spread = covariance @ row
        gain = spread / (row @ spread + sigma_m * sigma_m)
        self._state += np.outer(gain, np.array(measured_m) - row @ self._state)
        rest = np.eye(3) - np.outer(gain, row)
        self._covariance = rest @ covariance @ rest.T + sigma_m * sigma_m * np.outer(gain, gain)
