"""Bandwidths by design: as high as gain margin, phase margin and thrust allow, for an identified hull.

The loop of each axis is the controller's own (`dynamic_positioning.pole_placement`): Kp + Ki/s + Kd s behind the
low-pass DP_SMOOTH_T, the lag of the thrusters, a delay of sensors and control period, and 1/(m s² + d s).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from companion.config.hull import HullConfig
from companion.config.vessel import VesselConfig
from companion.control.dynamic_positioning import pole_placement

GAIN_MARGIN_DB, PHASE_MARGIN_DEG = 6.0, 35.0  # as the ReVolt's gains, which were tuned at sea, have them
NEEDED = (
    "DP_BW_SURGE",
    "DP_BW_SWAY",
    "DP_BW_YAW",
    "PATH_BW_YAW",
    "DP_DAMPING",
    "DP_INTEGRAL",
    "DP_SMOOTH_T",
)
"""Parameters that the design reads."""

_FULL_AT_M, _FULL_AT_RAD = 0.7, 0.3  # error at which the proportional part takes all thrust
_LOW, _HIGH, _STEPS = 0.05, 3.0, 60
_PATH_DAMPING, _PATH_INTEGRAL = 0.9, 0.1
_ESTIMATE_S = 0.1  # delay of the estimate


@dataclass(frozen=True, slots=True)
class Design:
    """One bandwidth: parameter, value before and now in rad/s, margins of the loop now, and what limits it."""

    name: str
    before: float
    value: float
    gain_margin_db: float
    phase_margin_deg: float
    limit: str

    @property
    def text(self) -> str:
        """One line for people."""
        return (
            f"{self.name} {self.before:.2f} -> {self.value:.2f} rad/s: gain margin {self.gain_margin_db:.1f} dB, "
            f"phase margin {self.phase_margin_deg:.0f} deg, limited by {self.limit}"
        )


@dataclass(frozen=True, slots=True)
class Loop:
    """What one loop is made of. `smooth_s`: low-pass of the feedback, 0: none."""

    inertia: float
    drag: float
    lag_s: float
    delay_s: float
    smooth_s: float
    damping: float
    integral: float

    def margins(self, bandwidth_radps: float) -> tuple[float, float]:
        """(gain margin in dB, phase margin in degrees); infinite where the response never crosses."""
        kp, ki, kd = pole_placement(self.inertia, self.drag, bandwidth_radps, self.damping, self.integral)
        w = np.geomspace(0.02 * bandwidth_radps, 100.0 * max(bandwidth_radps, 0.1), 1500)
        s = 1j * w
        control = (kp + kd * s) / (1.0 + self.smooth_s * s) + ki / s
        plant = np.exp(-self.delay_s * s) / (1.0 + self.lag_s * s) / (self.inertia * s * s + max(self.drag, 0.0) * s)
        response = control * plant
        size, phase = np.abs(response), np.unwrap(np.angle(response))
        phase -= 2.0 * math.pi * round((phase[0] + math.pi) / (2.0 * math.pi))
        crossing = np.flatnonzero((size[:-1] >= 1.0) & (size[1:] < 1.0))
        lowest = min((180.0 + math.degrees(phase[i]) for i in crossing), default=math.inf)
        turning = np.flatnonzero((phase[:-1] >= -math.pi) & (phase[1:] < -math.pi) & (w[:-1] > bandwidth_radps))
        highest = max((20.0 * math.log10(size[i]) for i in turning), default=-math.inf)
        return -highest, lowest

    def highest(self, most_radps: float) -> tuple[float, bool]:
        """(highest bandwidth that keeps both margins, whether the margins limit it)."""
        best = _LOW
        for value in np.geomspace(_LOW, max(_LOW, most_radps), _STEPS).tolist():
            gain_db, phase_deg = self.margins(value)
            if gain_db < GAIN_MARGIN_DB or phase_deg < PHASE_MARGIN_DEG:
                return best, True
            best = value
        return best, False


def designed(
    config: VesselConfig, hull: HullConfig, lag_s: float, parameters: Mapping[str, float]
) -> tuple[Design, ...]:
    """The bandwidths of positioning and path for that hull, with the thrust of `config`'s limits."""
    delay_s = 0.5 / config.control_rate_hz + _ESTIMATE_S
    damping, integral, smooth_s = (parameters[name] for name in ("DP_DAMPING", "DP_INTEGRAL", "DP_SMOOTH_T"))
    d, limits = hull.damping, config.limits
    rows = [
        ("DP_BW_SURGE", hull.m11_kg, d.x_u, limits.surge_n / _FULL_AT_M, False),
        ("DP_BW_SWAY", hull.m22_kg, d.y_v, limits.sway_n / _FULL_AT_M, False),
        ("DP_BW_YAW", hull.m33_kgm2, d.n_r, limits.yaw_nm / _FULL_AT_RAD, False),
        ("PATH_BW_YAW", hull.m33_kgm2, d.n_r, limits.yaw_nm / _FULL_AT_RAD, True),
    ]
    found = []
    for name, inertia, drag, full, path in rows:
        if full <= 0.0:
            continue
        loop = (
            Loop(inertia, drag, lag_s, delay_s, 0.0, _PATH_DAMPING, _PATH_INTEGRAL)
            if path
            else Loop(inertia, drag, lag_s, delay_s, smooth_s, damping, integral)
        )
        most = min(_HIGH, math.sqrt(full / inertia), _receiver_most(config, name))
        value, by_margin = loop.highest(most)
        limit = "the margins" if by_margin else "the receiver" if most == _receiver_most(config, name) else "thrust"
        found.append(Design(name, parameters[name], round(value, 3), *loop.margins(value), limit))
    return tuple(found)


def _receiver_most(config: VesselConfig, name: str) -> float:
    """The bandwidth up to which the noise of the receiver is not chased, rad/s."""
    if name not in ("DP_BW_SURGE", "DP_BW_SWAY"):
        return math.inf
    grade = config.sitl.gnss if config.sitl is not None else "rtk"
    return {"standalone": 0.25, "sbas": 0.35}.get(grade, 0.6)
