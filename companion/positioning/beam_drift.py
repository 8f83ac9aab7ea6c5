"""The drift that carries a boat sideways, from its own sideways motion.

The estimated current is one velocity for all headings. Wind on the beam of a light boat pushes it many times harder
than on the bow, so wind and current that oppose each other may carry the same boat ahead with one and sideways with the
other. A boat without sideways thrust that lies bow to the wrong one of both is in an unstable balance: as it turns its
bow to one side, it is carried to the other.
"""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState

_FIRST_MPS = 0.3  # one sigma on each axis before any motion was seen
_WANDER_MPS_RTS = 0.008  # of the weather
_GUST_MPS, _GUST_S = 0.08, 5.0  # a sideways motion that is no drift, and how long it lasts
_OWN_DOUBT = 0.4  # share of the motion by the boat's own turn that is uncertain
_LEAST_SWAY_MPS = 0.1  # a slower motion through the water counts as that: damping is nearly none there
_LONGEST_LAG_S = 15.0


class BeamDrift:
    """`see(nav, ahead_mps, dt_s)` every tick → `north_mps`, `east_mps`: the drift B.

    Sideways nothing but the weather moves a boat on a steady heading ψ: v = B·(−sin ψ, cos ψ), after the lag of its
    sway T = m22 / Y(v). A turn adds what the model tells: the centripetal part −m11/m22 u r, and the push N/x of a lone
    thruster at x that steers by its direction with the moment N = m33 ṙ + N(r). A low-pass filter of T over both sides
    takes the derivatives away, and a Kalman filter finds B from what is left. A slide that was there at the beginning
    may be of a turn before: it counts as doubt, until that time has passed. The filter sees the component along the
    hull only as the heading changes; `sigma_mps` is that of the worse axis.
    """

    def __init__(self, config: VesselConfig) -> None:
        self._hull = config.hull
        lone = config.thrusters[0] if len(config.thrusters) == 1 else None
        steers = lone is not None and lone.turns and lone.x_m != 0.0
        self._per_lever = -1.0 / (config.hull.m22_kg * lone.x_m) if lone is not None and steers else 0.0
        self.begin((0.0, 0.0))

    @property
    def pivot_m(self) -> float:
        """How far ahead of the middle the point lies that a push of the steering thruster leaves in place (the centre
        of percussion), negative where that thruster is ahead of it; 0 where the boat turns without a push aside."""
        return self._hull.m33_kgm2 * self._per_lever

    @property
    def sigma_mps(self) -> float:
        """One sigma of the worse axis."""
        return math.sqrt(max(self._p[0], self._p[2]))

    def begin(self, drift: tuple[float, float]) -> None:
        """Forget what was seen, and begin with the drift (north, east) in m/s."""
        self.north_mps, self.east_mps = drift
        self._p = (_FIRST_MPS**2, 0.0, _FIRST_MPS**2)
        self._across: tuple[float, float] | None = None  # direction to starboard, low-pass filtered
        self._rate_radps = self._turned_mps = 0.0
        self._slide_mps = 0.0  # of the motion at the beginning, that may have been the boat's own

    def see(self, nav: NavState, ahead_mps: float, dt_s: float) -> None:
        """`ahead_mps`: the boat's speed ahead through the water."""
        c, s = math.cos(nav.yaw_rad), math.sin(nav.yaw_rad)
        sway_mps, rate = nav.east_mps * c - nav.north_mps * s, nav.yaw_rate_radps
        if self._across is None:
            self._across, self._rate_radps = (-s, c), rate
            self._slide_mps = abs(sway_mps - self.east_mps * c + self.north_mps * s)
        lag_s = self._lag_s(sway_mps, self.east_mps * c - self.north_mps * s)
        share = dt_s / (dt_s + lag_s)
        north, east = self._across
        self._across = north + share * (-s - north), east + share * (c - east)
        self._rate_radps += share * (rate - self._rate_radps)
        hull, d = self._hull, self._hull.damping
        slowing_nm = (d.n_r + d.n_rr * abs(rate)) * rate
        turned_mps = lag_s * (slowing_nm * self._per_lever + hull.m11_kg / hull.m22_kg * ahead_mps * rate)
        self._turned_mps += share * (turned_mps - self._turned_mps)
        own_mps = self.pivot_m * (rate - self._rate_radps) + self._turned_mps
        self._slide_mps -= share * self._slide_mps
        sigma_mps = math.hypot(_GUST_MPS, _OWN_DOUBT * own_mps, self._slide_mps)
        self._correct(sway_mps + own_mps, sigma_mps, self._across, dt_s)

    def _lag_s(self, sway_mps: float, drift_mps: float) -> float:
        through_mps = max(_LEAST_SWAY_MPS, abs(sway_mps - drift_mps), abs(drift_mps))
        return min(_LONGEST_LAG_S, self._hull.sway_lag_s(0.0, through_mps))

    def _correct(self, seen_mps: float, sigma_mps: float, across: tuple[float, float], dt_s: float) -> None:
        """Fuse `seen_mps` = B·`across`; its error is correlated over _GUST_S."""
        north, east = across
        grown = _WANDER_MPS_RTS**2 * dt_s
        p_nn, p_ne, p_ee = self._p[0] + grown, self._p[1], self._p[2] + grown
        to_north, to_east = p_nn * north + p_ne * east, p_ne * north + p_ee * east
        variance = to_north * north + to_east * east + sigma_mps**2 * 2.0 * _GUST_S / dt_s
        off = (seen_mps - north * self.north_mps - east * self.east_mps) / variance
        self.north_mps += to_north * off
        self.east_mps += to_east * off
        self._p = (
            p_nn - to_north * to_north / variance,
            p_ne - to_north * to_east / variance,
            p_ee - to_east * to_east / variance,
        )
