"""How a boat without thrust astern turns: what turns it pushes it ahead, and nothing brakes it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig
from companion.params.store import Parameters

Floats = NDArray[np.float64]

_FASTEST_MPS, _SPEEDS = 12.0, 49
_ANSWER_S = 1.0  # in which the turn follows its moment
_EASES_S = 1.5  # before its end a turn eases off
_LEAST_ARM_M, _WIDEST_RAD = 0.1, math.radians(60.0)


class PushedTurn:
    """`predicted(…)` → speeds and headings. It never changes."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self._jet = any(t.kind == "jet" for t in config.thrusters)
        self._hull, self._most_nm = config.hull, config.limits.yaw_nm
        self._arm_m = max(_LEAST_ARM_M, *(_arm_m(thruster) for thruster in config.thrusters))
        self._speeds = np.linspace(0.0, _FASTEST_MPS, _SPEEDS)
        self._drags_n = np.array([config.hull.drag_n(float(speed)) for speed in self._speeds])

    def predicted(
        self,
        turns_rad: Floats,
        asked_mps: Floats,
        now: tuple[float, float, float],
        limits: tuple[float, float],
        times: Floats,
    ) -> tuple[Floats, Floats]:
        """Speeds over ground, and by how much the bow has turned, shape (n, k) each. `turns_rad`, `asked_mps`: the turn
        and the speed of each choice, shape (n,). `now`: speed over ground, the stream along the hull, and yaw rate.
        `limits`: yaw rate in turns, and the time constant at which the boat speeds up. `times`: shape (k,), evenly."""
        (surge_mps, stream_mps, rate_radps), (most_radps, lag_s), step_s = now, limits, float(times[1] - times[0])
        damping, mass_kg, inertia = self._hull.damping, self._hull.m11_kg, self._hull.m33_kgm2
        count, steer_n = len(turns_rad), self._parameters["JET_STEER_N"] if self._jet else math.inf
        speed, rate, turned = np.full(count, surge_mps), np.full(count, rate_radps), np.zeros(count)
        speeds, yaws = np.empty((count, len(times))), np.empty((count, len(times)))
        for k in range(len(times)):
            speeds[:, k], yaws[:, k] = speed, turned
            left = turns_rad - turned
            aim = np.clip(left / _EASES_S, -most_radps, most_radps)
            water = speed - stream_mps
            resists = (damping.n_r + damping.n_ur * np.abs(water)) * rate + damping.n_rr * rate * np.abs(rate)
            drag = np.interp(np.abs(water), self._speeds, self._drags_n) * np.sign(water)
            most_nm = np.minimum(self._most_nm, np.maximum(steer_n, drag) * self._arm_m)
            moment = np.clip(inertia * (aim - rate) / _ANSWER_S + resists, -most_nm, most_nm)
            pushed = (np.abs(moment) / self._arm_m - drag) / mass_kg
            speeds_up = np.where(asked_mps > speed, (asked_mps - speed) / lag_s, -math.inf)
            speed = speed + step_s * np.maximum(pushed, speeds_up)
            turned = turned + step_s * rate
            rate = rate + step_s * (moment - resists) / inertia
        return speeds, yaws


def _arm_m(thruster: ThrusterConfig) -> float:
    """The most yaw moment for each newton ahead."""
    if thruster.kind == "fixed":
        return abs(thruster.y_m)
    return abs(thruster.x_m) * math.tan(min(_WIDEST_RAD, thruster.azimuth_max_rad or 0.0))
