"""Position and velocity of the lead boat from fixes at irregular times: a Kalman filter with the turn rate as input.

x' = v, v' = ω × v + a v/|v| + w, where w is white acceleration noise (Bar-Shalom, Li & Kirubarajan 2001, 11.7, with the
turn rate ω and the acceleration a as inputs). Both axes have the same errors, so one 2×2 covariance serves for both,
and a turn does not change it.
"""

from __future__ import annotations

import math

_ACCELERATION = 0.5  # process noise in m/s² √s: manoeuvres beyond the measured turn and acceleration
_POSITION_GATE = 25.0  # in variances of the innovation, squared distance: one good fix in 270,000 is rejected
_VELOCITY_GATE_MPS = 6.0
_TURN_FADES_S, _PUSH_FADES_S = 3.0, 1.0  # time constants with which a turn and an acceleration fade without a fix


class LeaderFilter:
    """`advance(t_s)` and the updates in order of time. Positions in metres in any local plane, axes north and east.

    Remembers position, velocity, turn, acceleration along the way and the covariance, all valid at `t_s`. `turn_radps`
    and `acceleration_mps2` are inputs that the caller sets.
    """

    __slots__ = (
        "_pp",
        "_pv",
        "_vv",
        "acceleration_mps2",
        "east_m",
        "east_mps",
        "north_m",
        "north_mps",
        "t_s",
        "turn_radps",
    )

    def __init__(self, t_s: float, north_m: float, east_m: float, sigma_m: float) -> None:
        self.t_s = t_s
        self.north_m, self.east_m = north_m, east_m
        self.north_mps = self.east_mps = self.turn_radps = self.acceleration_mps2 = 0.0
        self._pp, self._pv, self._vv = sigma_m * sigma_m, 0.0, 100.0

    @property
    def sigma_m(self) -> float:
        """One sigma of the position on each axis."""
        return math.sqrt(self._pp)

    def at(self, t_s: float) -> tuple[float, float, float, float]:
        """(north_m, east_m, north_mps, east_mps), predicted for a time from `t_s` on, or shortly before."""
        dt_s = t_s - self.t_s
        turned = self.turn_radps * _faded(dt_s, _TURN_FADES_S)
        speed = math.hypot(self.north_mps, self.east_mps)
        gained = self.acceleration_mps2 * _faded(dt_s, _PUSH_FADES_S)
        after = max(0.0, 1.0 + gained / speed) if speed > 0.0 else 1.0
        c, s = math.cos(0.5 * turned), math.sin(0.5 * turned)
        way_s = 0.5 * (1.0 + after) * dt_s
        north, east = c * self.north_mps - s * self.east_mps, s * self.north_mps + c * self.east_mps  # half-way round
        north_m, east_m = self.north_m + way_s * north, self.east_m + way_s * east
        return north_m, east_m, after * (c * north - s * east), after * (s * north + c * east)

    def advance(self, t_s: float) -> None:
        """Predict to `t_s`, which must not lie before the last update."""
        dt_s = t_s - self.t_s
        self.north_m, self.east_m, self.north_mps, self.east_mps = self.at(t_s)
        self.t_s = t_s
        q = _ACCELERATION * _ACCELERATION
        self._pp += dt_s * (2.0 * self._pv + dt_s * (self._vv + q * dt_s / 3.0))
        self._pv += dt_s * (self._vv + 0.5 * q * dt_s)
        self._vv += q * dt_s

    def take_position(self, north_m: float, east_m: float, sigma_m: float) -> bool:
        """Update by a position at `t_s`. Returns False where it is rejected as an outlier; then nothing changes."""
        off_north, off_east = north_m - self.north_m, east_m - self.east_m
        total = self._pp + sigma_m * sigma_m
        if off_north * off_north + off_east * off_east > _POSITION_GATE * total:
            return False
        gain, gain_v = self._pp / total, self._pv / total
        self.north_m += gain * off_north
        self.east_m += gain * off_east
        self.north_mps += gain_v * off_north
        self.east_mps += gain_v * off_east
        self._vv -= gain_v * self._pv
        self._pv -= gain * self._pv
        self._pp -= gain * self._pp
        return True

    def take_velocity(self, north_mps: float, east_mps: float, sigma_mps: float) -> None:
        """Update by a velocity at `t_s`; an outlier is rejected, unless the velocity is still uncertain."""
        off_north, off_east = north_mps - self.north_mps, east_mps - self.east_mps
        total = self._vv + sigma_mps * sigma_mps
        if math.hypot(off_north, off_east) > _VELOCITY_GATE_MPS + 3.0 * math.sqrt(total):
            return
        gain, gain_p = self._vv / total, self._pv / total
        self.north_mps += gain * off_north
        self.east_mps += gain * off_east
        self.north_m += gain_p * off_north
        self.east_m += gain_p * off_east
        self._pp -= gain_p * self._pv
        self._pv -= gain_p * self._vv
        self._vv -= gain * self._vv


def _faded(dt_s: float, fades_s: float) -> float:
    """Effective duration of an input that fades exponentially: ∫ exp(−t/τ) dt from 0 to `dt_s`."""
    return fades_s * (1.0 - math.exp(-dt_s / fades_s)) if dt_s > 0.0 else dt_s
