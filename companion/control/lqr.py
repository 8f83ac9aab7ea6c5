"""Linear-quadratic regulator for speed and heading under way: the second controller of the ÅBOAT thesis (Storbacka
2021, 4.3.4).

State x = (∫e_u, e_u, ∫e_ψ, e_ψ, v, r), inputs surge force and yaw moment; the model is the vessel's hull, linearised at
WP_SPEED (Fossen 2021, 13.1): drag by its slope, and sway and yaw coupled by m11 U r and the Munk moment (m22 − m11) U
v. K follows from the continuous algebraic Riccati equation. Bryson's rule gives the weights: an error of LQR_ERR_* is
worth as much as LQR_EFFORT of the vessel's limits.
"""

from __future__ import annotations

import math

import numpy as np

from companion.config.vessel import VesselConfig
from companion.control.riccati import stabilising
from companion.control.surge_yaw import SurgeYawErrors
from companion.core.actuation import Wrench
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters

_NAMES = frozenset({"PATH_CTRL", "WP_SPEED", "LQR_ERR_SPEED", "LQR_ERR_YAW", "LQR_ERR_RATE", "LQR_INT_T", "LQR_EFFORT"})
_LEAST_SPEED_MPS = 0.2
LQR = 1  # PATH_CTRL

Gains = tuple[tuple[float, ...], tuple[float, ...]]


def gains(config: VesselConfig, parameters: Parameters) -> Gains:
    """K (2×6): rows for surge force and yaw moment, columns for the states in their order."""
    hull, d = config.hull, config.hull.damping
    speed = max(_LEAST_SPEED_MPS, parameters["WP_SPEED"])
    slope = max(0.0, hull.drag_slope(speed))
    a = np.zeros((6, 6))
    a[0, 1] = a[2, 3] = a[3, 5] = 1.0
    a[1, 1] = -slope / hull.m11_kg
    a[4, 4], a[4, 5] = -(d.y_v + d.y_uv * speed) / hull.m22_kg, -(hull.m11_kg * speed + d.y_r) / hull.m22_kg
    a[5, 4], a[5, 5] = (
        -((hull.m22_kg - hull.m11_kg + d.n_uv) * speed + d.n_v) / hull.m33_kgm2,
        -(d.n_r + d.n_ur * speed) / hull.m33_kgm2,
    )
    b = np.zeros((6, 2))
    b[1, 0], b[5, 1] = 1.0 / hull.m11_kg, 1.0 / hull.m33_kgm2
    slow, off = parameters["LQR_ERR_SPEED"], math.radians(parameters["LQR_ERR_YAW"])
    time, turning = parameters["LQR_INT_T"], math.radians(parameters["LQR_ERR_RATE"])
    q = np.diag([1.0 / (slow * time) ** 2, 1.0 / slow**2, 1.0 / (off * time) ** 2, 1.0 / off**2, 0.0, 1.0 / turning**2])
    effort = parameters["LQR_EFFORT"]
    r = np.diag([1.0 / (effort * config.limits.surge_n) ** 2, 1.0 / (effort * config.limits.yaw_nm) ** 2])
    k = np.linalg.solve(r, b.T @ stabilising(a, b, q, r))
    surge, yaw = (tuple(float(value) for value in row) for row in k)
    return surge, yaw


class LqrTracking:
    """A `TrackingLaw`. Remembers both integrals, and K, which is computed when PATH_CTRL chooses it and when a
    parameter that it depends on changes, never in a tick."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters
        self._errors = SurgeYawErrors(config.limits)
        self._gains: Gains | None = None
        parameters.on_change(self._changed)
        self._compute()

    @property
    def chosen(self) -> bool:
        """Whether PATH_CTRL chooses this law."""
        return self._gains is not None

    def start(self) -> None:
        """Set both integrals to zero."""
        self._errors.start()

    def update(self, setpoint: PathSetpoint, nav: NavState, dt_s: float) -> Wrench:
        """The wrench for the setpoint, before saturation. Raises RuntimeError unless `chosen`."""
        if self._gains is None:
            raise RuntimeError("LqrTracking.update without PATH_CTRL 1")
        surge, yaw = self._gains
        errors = self._errors
        errors.update(setpoint, nav, surge[0], yaw[2], dt_s)
        state = (
            -errors.speed_integral_m, -errors.speed_error_mps, -errors.heading_integral_rads, -errors.heading_error_rad,
            nav.sway_mps, nav.yaw_rate_radps - setpoint.yaw_rate_radps,
        )  # fmt: skip
        return Wrench(
            -sum(k * x for k, x in zip(surge, state, strict=True)),
            0.0,
            -sum(k * x for k, x in zip(yaw, state, strict=True)),
        )

    def _changed(self, name: str, value: float) -> None:
        if name in _NAMES:
            self._compute()

    def _compute(self) -> None:
        wanted = self._parameters["PATH_CTRL"] == LQR
        if wanted and self._gains is None:
            self._errors.start()
        self._gains = gains(self._config, self._parameters) if wanted else None
