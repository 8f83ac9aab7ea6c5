"""Where a boat goes that a jet's nozzle turns: the thrust that turns it drives it on, and it goes on turning."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.allocation.jet import steering_thrust_n
from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.obstacles.occupancy import Floats
from companion.params.store import Parameters

_LAG_S = 0.7  # of impeller and nozzle
_TURNS_S, _COARSE_S = 12.0, 2.0  # a turn has come round by then: longer steps will do
_COMES_S = 1.0  # in which the heading loop takes back what is left of a turn
_FASTEST_MPS, _STEP_MPS = 30.0, 0.1  # of the table of the drag


@dataclass(frozen=True, slots=True)
class Predicted:
    """Velocity over ground, north and east, and heading; shape (n, k) each."""

    north_mps: Floats
    east_mps: Floats
    yaw_rad: Floats


@dataclass(frozen=True, slots=True)
class _Motion:
    """Speeds ahead and to starboard through the water, and yaw rate; shape (n,) each."""

    surge_mps: Floats
    sway_mps: Floats
    yaw_rate_radps: Floats


class NozzleTurn:
    """`predicted(yaw_rad, surge_mps, nav)`: the boat's motion towards headings and speeds. Remembers nothing.

    Surge, sway and yaw by the hull of the vessel's file (Fossen 2021, 6.5), with the thrust that `JetAllocator` gives
    for a turn. Impeller and nozzle follow with a lag, from no thrust.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, step_s: float, count: int) -> None:
        """`count` instants, `step_s` apart."""
        thruster = config.thrusters[0]
        self._parameters = parameters
        self._hull, self._limits = config.hull, config.limits
        stop_rad = min(abs(thruster.azimuth_min_rad or 0.0), abs(thruster.azimuth_max_rad or 0.0))
        self._lever_m = abs(thruster.x_m)
        self._turning_m = max(1e-3, self._lever_m * math.sin(stop_rad))  # moment for each newton of thrust, at the stop
        times = np.arange(count) * step_s
        fine = round(min(_TURNS_S, float(times[-1])) / step_s)
        coarse = max(0, math.ceil((count - 1 - fine) * step_s / _COARSE_S))
        self._steps_s = [step_s] * fine + [_COARSE_S] * coarse
        nodes = np.concatenate(([0.0], np.cumsum(self._steps_s)))
        self._before = np.minimum(np.searchsorted(nodes, times + 1e-9, side="right") - 1, len(nodes) - 2)
        self._after = (times - nodes[self._before]) / np.diff(nodes)[self._before]
        self._speeds = np.arange(0.0, _FASTEST_MPS, _STEP_MPS)
        self._drags = np.array([config.hull.drag_n(speed) for speed in self._speeds.tolist()])

    def predicted(self, yaw_rad: Floats, surge_mps: Floats, nav: NavState, out_m: Floats) -> Predicted:
        """The motion at 0, `step_s`, …, shape (n, count), of a boat that moves as `nav` says and is asked for headings
        and speeds over ground, and for no more speed after the way `out_m`; shape (n,) each."""
        stream_n, stream_e = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        stream = ned_to_body(stream_n, stream_e, nav.yaw_rad)
        size, asked = len(yaw_rad), surge_mps - stream[0]
        way_m = np.zeros(size)
        motion = _Motion(
            np.full(size, nav.surge_mps - stream[0]),
            np.full(size, nav.sway_mps - stream[1]),
            np.full(size, nav.yaw_rate_radps),
        )
        yaw, short_s = np.full(size, nav.yaw_rad), np.zeros(size)
        push_n, turning_nm = np.zeros(size), np.zeros(size)
        surges, sways, headings = [motion.surge_mps], [motion.sway_mps], [yaw]
        for step_s in self._steps_s:
            asked_nm = self._asked_nm(yaw_rad - yaw, motion, step_s)
            drag_n = np.interp(np.abs(motion.surge_mps), self._speeds, self._drags)
            faster_mps = np.where(way_m < out_m, asked, -stream[0]) - motion.surge_mps
            ahead_n, given_nm, short = self._given(asked_nm, faster_mps, drag_n, short_s)
            way_m = way_m + step_s * np.abs(motion.surge_mps)
            short_s = np.where(short, short_s + step_s, 0.0)
            share = -math.expm1(-step_s / _LAG_S)
            push_n = push_n + share * (ahead_n - push_n)
            turning_nm = turning_nm + share * (given_nm - turning_nm)
            after = self._moved(motion, drag_n, push_n, turning_nm, step_s)
            yaw = yaw + 0.5 * step_s * (motion.yaw_rate_radps + after.yaw_rate_radps)
            motion = after
            surges.append(motion.surge_mps)
            sways.append(motion.sway_mps)
            headings.append(yaw)
        u, v, yaws = self._at_times(surges), self._at_times(sways), self._at_times(headings)
        c, s = np.cos(yaws), np.sin(yaws)
        return Predicted(stream_n + c * u - s * v, stream_e + s * u + c * v, yaws)

    def _at_times(self, nodes: list[Floats]) -> Floats:
        """Of values at the ends of steps, those at the instants that are asked for, shape (n, count)."""
        values = np.stack(nodes, axis=1)
        before = values[:, self._before]
        found: Floats = before + self._after * (values[:, self._before + 1] - before)
        return found

    def _asked_nm(self, turn_rad: Floats, motion: _Motion, step_s: float) -> Floats:
        """The moment that the heading loop asks for, with the shorter turn to go."""
        turn = np.remainder(turn_rad + math.pi, math.tau) - math.pi
        fastest = math.radians(self._parameters["PATH_YAW_RATE"])
        wanted, d = _within(turn / _COMES_S, fastest), self._hull.damping
        resisting_nms = d.n_r + d.n_ur * np.abs(motion.surge_mps) + d.n_rr * np.abs(wanted)
        asked_nm = self._hull.m33_kgm2 * (wanted - motion.yaw_rate_radps) / step_s + resisting_nms * wanted
        return _within(asked_nm, self._limits.yaw_nm)

    def _given(
        self, asked_nm: Floats, faster_mps: Floats, drag_n: Floats, short_s: Floats
    ) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Force ahead, moment, and whether the thrust for steering is too little; it has been for `short_s`.
        `faster_mps`: by how much it is to go faster."""
        more_n = self._hull.m11_kg * self._parameters["PATH_BW_SURGE"] * faster_mps
        ahead_n = np.minimum(np.maximum(drag_n + more_n, 0.0), self._limits.surge_n)
        wanted_n, usual_n = np.abs(asked_nm) / self._turning_m, self._parameters["JET_STEER_N"]
        short = wanted_n > np.maximum(np.maximum(usual_n, drag_n), ahead_n)
        most_n = np.maximum(steering_thrust_n(usual_n, short_s), drag_n)
        thrust_n = np.maximum(ahead_n, np.minimum(wanted_n, most_n))
        given_nm = _within(asked_nm, thrust_n * self._turning_m)
        return np.sqrt(thrust_n**2 - (given_nm / self._lever_m) ** 2), given_nm, short

    def _moved(self, before: _Motion, drag_n: Floats, push_n: Floats, moment_nm: Floats, step_s: float) -> _Motion:
        """The motion a step later; what resists it is implicit."""
        hull, d = self._hull, self._hull.damping
        u, v, r = before.surge_mps, before.sway_mps, before.yaw_rate_radps
        au, av, ar = np.abs(u), np.abs(v), np.abs(r)
        resisting = drag_n / np.maximum(au, _STEP_MPS)
        surge = u + step_s * (push_n + hull.m22_kg * v * r) / hull.m11_kg
        across_n = -moment_nm / self._lever_m - (hull.m11_kg * u + d.y_r + d.y_vr * av + d.y_rr * ar) * r
        sway_damping = d.y_v + d.y_vv * av + d.y_rv * ar + d.y_uv * au
        munk = (hull.m22_kg - hull.m11_kg) * u + d.n_v + d.n_vv * av + d.n_rv * ar + d.n_uv * au
        yaw_damping = d.n_r + d.n_vr * av + d.n_rr * ar + d.n_ur * au
        return _Motion(
            surge / (1.0 + step_s * resisting / hull.m11_kg),
            (v + step_s * across_n / hull.m22_kg) / (1.0 + step_s * sway_damping / hull.m22_kg),
            (r + step_s * (moment_nm - munk * v) / hull.m33_kgm2) / (1.0 + step_s * yaw_damping / hull.m33_kgm2),
        )


def _within(value: Floats, most: Floats | float) -> Floats:
    """The value, within `most` to either side."""
    held: Floats = np.minimum(np.maximum(value, -most), most)
    return held
