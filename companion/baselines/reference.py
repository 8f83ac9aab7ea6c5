"""The reference filter of the ReVolt thesis (3.1, 3.6): third order in north, east and yaw. Its input leads it by a
"carrot" limited in body axes.

η''' + (2Δ+I)Ω η'' + (2Δ+I)Ω² η' + Ω³ η = Ω³ η_in,   η_in = η + R(ψ) sat(R(ψ)ᵀ (η_target − η))
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from companion.core.frames import body_to_ned, ned_to_body
from companion.core.setpoint import PoseSetpoint
from companion.guidance.pose_setpoint import pose_setpoint
from companion.guidance.stopping import stopping_time_s
from companion.params.store import Parameters

_OMEGA_RADPS = 0.6
_DAMPING = 1.0
_ARRIVED_M = 0.01
_ARRIVED_RAD = math.radians(0.5)


@dataclass(frozen=True, slots=True)
class Carrot:
    """How far ahead of the reference its input may lie. The steady speed is Ω/(2Δ+1) = 0.2 1/s times that."""

    ahead_m: float
    astern_m: float
    starboard_m: float
    port_m: float
    yaw_rad: float


def carrot_of(parameters: Parameters) -> Carrot:
    """The carrot by the parameters DPT_LEAD_*; their defaults are those of the sea trial in the thesis."""
    return Carrot(
        parameters["DPT_LEAD_AHEAD"],
        parameters["DPT_LEAD_ASTERN"],
        parameters["DPT_LEAD_STBD"],
        parameters["DPT_LEAD_PORT"],
        math.radians(parameters["DPT_LEAD_YAW"]),
    )


class ThesisReference:
    """Same interface as `ReferenceGenerator`. Euler integration, stable for dt ≤ 2/Ω. Remembers η, η', η'' and the
    target."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._speed_mps: float | None = None
        self.start(0.0, 0.0, 0.0)

    def start(
        self,
        north_m: float,
        east_m: float,
        yaw_rad: float,
        surge_mps: float = 0.0,
        sway_mps: float = 0.0,
        yaw_rate_radps: float = 0.0,
    ) -> None:
        """Begin at this state; the target is where the boat comes to rest from it."""
        vn, ve = body_to_ned(surge_mps, sway_mps, yaw_rad)
        half = 0.5 * stopping_time_s(surge_mps, sway_mps, yaw_rate_radps, self._parameters)
        self._pose = [north_m, east_m, yaw_rad]
        self._velocity = [vn, ve, yaw_rate_radps]
        self._acceleration = [0.0, 0.0, 0.0]
        self._target = (north_m + vn * half, east_m + ve * half, yaw_rad + yaw_rate_radps * half)
        self._speed_mps = None

    def retarget(
        self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None = None, hurries: bool = False
    ) -> None:
        """Go on to another pose. `speed_mps`: largest speed, which shortens the carrot; None: as the carrot allows.
        `hurries` is not used."""
        self._target = (north_m, east_m, yaw_rad)
        self._speed_mps = speed_mps

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) that the reference leads to."""
        return self._target[0], self._target[1], wrap_pi(self._target[2])

    @property
    def arrived(self) -> bool:
        """Whether the reference is at its target, within tolerances: the filter only approaches it."""
        dn, de, dy = self._errors()
        return math.hypot(dn, de) < _ARRIVED_M and abs(dy) < _ARRIVED_RAD

    def update(self, dt_s: float, pace: float = 1.0) -> PoseSetpoint:
        """The reference `dt_s` later. `pace` is not used."""
        dn, de, dy = self._errors()
        x, y = ned_to_body(dn, de, self._pose[2])
        carrot = carrot_of(self._parameters)
        cap = math.inf if self._speed_mps is None else self._speed_mps * (2.0 * _DAMPING + 1.0) / _OMEGA_RADPS
        x = max(-min(carrot.astern_m, cap), min(carrot.ahead_m, cap, x))
        y = max(-min(carrot.port_m, cap), min(carrot.starboard_m, cap, y))
        leads = (*body_to_ned(x, y, self._pose[2]), max(-carrot.yaw_rad, min(carrot.yaw_rad, dy)))
        damping = 2.0 * _DAMPING + 1.0
        for i, lead in enumerate(leads):
            velocity, acceleration = self._velocity[i], self._acceleration[i]
            jerk = _OMEGA_RADPS**3 * lead - damping * _OMEGA_RADPS**2 * velocity - damping * _OMEGA_RADPS * acceleration
            self._pose[i] += velocity * dt_s
            self._velocity[i] += acceleration * dt_s
            self._acceleration[i] += jerk * dt_s
        return pose_setpoint(self._pose, self._velocity, self._acceleration, self._target)

    def _errors(self) -> tuple[float, float, float]:
        north, east, yaw = self._pose
        return self._target[0] - north, self._target[1] - east, wrap_pi(self._target[2] - yaw)
