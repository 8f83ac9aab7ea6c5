"""Where a boat goes that a jet's nozzle turns: the thrust that turns it drives it on, and it goes on turning."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from companion.allocation.jet import steering_thrust_n
from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.obstacles.occupancy import Floats
from companion.params.store import Parameters

_LAG_S = 0.7  # of impeller and nozzle
_TURNS_S, _COARSE_S = 12.0, 2.0  # a turn has come round by then: longer steps will do
_COMES_S = 1.0  # in which the heading loop takes back what is left of a turn
_FASTEST_MPS, _PER_MPS = 30.0, 10.0  # of the table of the drag: its end, and its steps


@dataclass(frozen=True, slots=True)
class Predicted:
    """Velocity over ground, north and east, and heading; shape (n, k) each."""

    north_mps: Floats
    east_mps: Floats
    yaw_rad: Floats


class NozzleTurn:
    """`predicted(yaw_rad, surge_mps, nav)`: the boat's motion towards headings and speeds. Remembers nothing.

    Surge, sway and yaw by the hull of the vessel's file (Fossen 2021, 6.5), with the thrust that `JetAllocator` gives
    for a turn. Impeller and nozzle follow with a lag, from no thrust. In plain floats, which for one choice take a
    tenth of the time of arrays, and for two dozen no longer.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, step_s: float, count: int) -> None:
        """`count` instants, `step_s` apart."""
        thruster, hull, d = config.thrusters[0], config.hull, config.hull.damping
        self._parameters = parameters
        stop_rad = min(abs(thruster.azimuth_min_rad or 0.0), abs(thruster.azimuth_max_rad or 0.0))
        self._lever_m = max(2e-3, abs(thruster.x_m))
        self._turning_m = max(1e-3, self._lever_m * math.sin(stop_rad))  # moment for each newton of thrust, at the stop
        self._most_n, self._most_nm = config.limits.surge_n, config.limits.yaw_nm
        self._m11, self._m22, self._m33 = hull.m11_kg, hull.m22_kg, hull.m33_kgm2
        self._y_v, self._y_vv, self._y_rv, self._y_uv = d.y_v, d.y_vv, d.y_rv, d.y_uv
        self._y_r, self._y_vr, self._y_rr = d.y_r, d.y_vr, d.y_rr
        self._n_v, self._n_vv, self._n_rv, self._n_uv = d.n_v, d.n_vv, d.n_rv, d.n_uv
        self._n_r, self._n_vr, self._n_rr, self._n_ur = d.n_r, d.n_vr, d.n_rr, d.n_ur
        self._drags = [hull.drag_n(i / _PER_MPS) for i in range(round(_FASTEST_MPS * _PER_MPS) + 1)]
        self._rises = [*(after - drag for drag, after in pairwise(self._drags)), 0.0]
        self._lay_steps(step_s, count)

    def _lay_steps(self, step_s: float, count: int) -> None:
        """The steps of the prediction, and between which of their ends the instants lie."""
        times = np.arange(count) * step_s
        fine = round(min(_TURNS_S, float(times[-1])) / step_s)
        coarse = max(0, math.ceil((count - 1 - fine) * step_s / _COARSE_S))
        steps_s = [step_s] * fine + [_COARSE_S] * coarse
        self._steps = [(step, -math.expm1(-step / _LAG_S)) for step in steps_s]
        nodes = np.concatenate(([0.0], np.cumsum(steps_s)))
        self._before = np.minimum(np.searchsorted(nodes, times + 1e-9, side="right") - 1, len(nodes) - 2)
        self._after = (times - nodes[self._before]) / np.diff(nodes)[self._before]

    def predicted(self, yaw_rad: Floats, surge_mps: Floats, nav: NavState, out_m: Floats) -> Predicted:
        """The motion at 0, `step_s`, …, shape (n, count), of a boat that moves as `nav` says and is asked for headings
        and speeds over ground, and for no more speed after the way `out_m`; shape (n,) each."""
        stream_n, stream_e = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        stream = ned_to_body(stream_n, stream_e, nav.yaw_rad)
        nodes = np.empty((len(yaw_rad), 3, len(self._steps) + 1))
        choices = zip(yaw_rad.tolist(), surge_mps.tolist(), out_m.tolist(), strict=True)
        for i, (yaw, surge, out) in enumerate(choices):
            nodes[i] = self._nodes(yaw, surge - stream[0], out, nav, stream)
        before = nodes[:, :, self._before]
        found = before + self._after * (nodes[:, :, self._before + 1] - before)
        u, v, yaws = found[:, 0], found[:, 1], found[:, 2]
        c, s = np.cos(yaws), np.sin(yaws)
        return Predicted(stream_n + c * u - s * v, stream_e + s * u + c * v, yaws)

    def _nodes(
        self, to_rad: float, asked_mps: float, out_m: float, nav: NavState, stream: tuple[float, float]
    ) -> tuple[list[float], list[float], list[float]]:
        """Speeds ahead and to starboard through the water, and heading, before the first step and after each."""
        fastest = math.radians(self._parameters["PATH_YAW_RATE"])
        usual_n, gain = self._parameters["JET_STEER_N"], self._m11 * self._parameters["PATH_BW_SURGE"]
        most_n, most_nm, turning_m, lever_m = self._most_n, self._most_nm, self._turning_m, self._lever_m
        u, v, r, yaw = nav.surge_mps - stream[0], nav.sway_mps - stream[1], nav.yaw_rate_radps, nav.yaw_rad
        way_m = short_s = push_n = pushed_nm = 0.0
        surges, sways, yaws = [u], [v], [yaw]
        for step_s, share in self._steps:
            speed_mps = abs(u)
            drag_n = self._drag_n(speed_mps)
            # The heading loop asks for a moment, the speed loop for thrust.
            rate = _within(((to_rad - yaw + math.pi) % math.tau - math.pi) / _COMES_S, fastest)
            resisting_nms = self._n_r + self._n_ur * speed_mps + self._n_rr * abs(rate)
            asked_nm = _within(self._m33 * (rate - r) / step_s + resisting_nms * rate, most_nm)
            faster_mps = (asked_mps if way_m < out_m else -stream[0]) - u
            ahead_n = min(max(drag_n + gain * faster_mps, 0.0), most_n)
            # The jet gives what it may for the turn.
            wanted_n, thrust_n = abs(asked_nm) / turning_m, ahead_n
            if wanted_n > ahead_n:
                thrust_n = max(ahead_n, min(wanted_n, max(steering_thrust_n(usual_n, short_s), drag_n)))
            given_nm = _within(asked_nm, thrust_n * turning_m)
            short_s = short_s + step_s if wanted_n > ahead_n and wanted_n > drag_n and wanted_n > usual_n else 0.0
            way_m += step_s * speed_mps
            push_n += share * (math.sqrt(thrust_n * thrust_n - (given_nm / lever_m) ** 2) - push_n)
            pushed_nm += share * (given_nm - pushed_nm)
            before = r
            u, v, r = self._moved(u, v, r, drag_n, push_n, pushed_nm, step_s)
            yaw += 0.5 * step_s * (before + r)
            surges.append(u)
            sways.append(v)
            yaws.append(yaw)
        return surges, sways, yaws

    def _moved(
        self, u: float, v: float, r: float, drag_n: float, push_n: float, pushed_nm: float, step_s: float
    ) -> tuple[float, float, float]:
        """Speeds ahead and to starboard and yaw rate a step later; what resists them is implicit."""
        au, av, ar = abs(u), abs(v), abs(r)
        m11, m22, m33 = self._m11, self._m22, self._m33
        across_n = -pushed_nm / self._lever_m - (m11 * u + self._y_r + self._y_vr * av + self._y_rr * ar) * r
        sway_damping = self._y_v + self._y_vv * av + self._y_rv * ar + self._y_uv * au
        munk = (m22 - m11) * u + self._n_v + self._n_vv * av + self._n_rv * ar + self._n_uv * au
        yaw_damping = self._n_r + self._n_vr * av + self._n_rr * ar + self._n_ur * au
        return (
            (u + step_s * (push_n + m22 * v * r) / m11) / (1.0 + step_s * drag_n / max(au, 1.0 / _PER_MPS) / m11),
            (v + step_s * across_n / m22) / (1.0 + step_s * sway_damping / m22),
            (r + step_s * (pushed_nm - munk * v) / m33) / (1.0 + step_s * yaw_damping / m33),
        )

    def _drag_n(self, speed_mps: float) -> float:
        """By the table, which a hull's own function would take longer for."""
        place = min(_FASTEST_MPS * _PER_MPS, speed_mps * _PER_MPS)  # its end for what is no number
        below = int(place)
        return self._drags[below] + (place - below) * self._rises[below]


def _within(value: float, most: float) -> float:
    """The value, within `most` to either side."""
    return most if value > most else -most if value < -most else value
