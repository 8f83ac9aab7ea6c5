"""Speed, heading and turn along a track, from what the boat can do: planned once, then read by arc length.

The speed is the highest that keeps, everywhere, the legs' limits, v ≤ √(a_lat/κ) in bends, the sideways speed where the
bow is not along the track, and the acceleration and braking that the planned thrust leaves at that course and speed in
the present current and wind (v² changes by at most 2∫a ds, forward and backward). The heading is the mean of the
track's course over a window of time around each place: a sharp corner, through which the boat passes slowly, becomes a
turn at the boat's yaw rate, half before and half after the corner.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.guidance.agility import Agility, Weather
from companion.guidance.planned_thrust import PlannedThrust
from companion.guidance.steps import Steps
from companion.guidance.track import Track

_STRAIGHT_1PM = 1.0e-6
_ROUNDS = 3  # speed and heading depend on each other
_SAMPLES_PER_M, _RAD_PER_SAMPLE = 4.0, 0.02  # of the track: as dense as a straight leg and a bend need
_STEP_S = 0.1  # of the table of headings
_MOST_STEPS = 20_000  # even ones
_LONGEST_STEP_S = 0.25  # a way that even steps are longer on has steps of this near bends, and those of the track else
# A step of the track below both, a share of its longest one and a time, is near a bend.
_NEAR_SHARE, _NEAR_S = 0.6, 4.0
_BRIEF_S = 1.0e-3  # steps of a way so short that a window has too many of them
_SHORTEST_S, _LONGEST_S = 0.8, 30.0  # windows of the mean
_GROWTH = 1.3
# The last means of speed and heading: thrust and yaw acceleration change as slowly as azimuths turn. The windows widen
# steadily too: where one steps, the moment steps.
_SPEED_MEAN_S, _WIDTH_MEAN_S, _LAST_MEANS_S = 2.5, 2.0, (3.0, 2.0)
# Shares of the limits, as parts of the share that a plan may take. Speed that is lost in a bend must be made again, and
# costs more thrust and time than the bend itself.
_SIDEWAYS, _TURNING = 1.85, 2.0
# In a sharp corner the boat all but stops, whatever it takes: there a slower tip and a slower turn (a part of the rate,
# but not below one that swings it round meanwhile) cost little time, and save much thrust. The course is compared so
# long before and after, at the leg's speed.
_SHARP_SIDEWAYS, _SHARP_RATE, _SHARP_RADPS = 0.7, 0.7, math.radians(20.0)
_SQUARE_RAD, _SHARP_RAD, _SHARP_S = math.radians(100.0), math.radians(130.0), 1.2
# Two plans agree where they differ by no more, now and a little later.
_AGREE_S, _AGREE_MPS, _AGREE_RAD = 2.0, 0.05, math.radians(3.0)

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PlanLimits:
    """What a plan keeps. `share`: of the boat's limits that it may take; `sway_mps`: largest sideways speed; `slowest`:
    no bend slows the boat below it, in m/s."""

    agility: Agility
    share: float
    sway_mps: float
    slowest_mps: float
    weather: Weather


class PathPlan:
    """It never changes. Times are those of a boat that sails at the planned speed from the track's beginning."""

    def __init__(
        self,
        track: Track,
        leg_end_s_m: Sequence[float],
        leg_speed_mps: Sequence[float],
        limits: PlanLimits,
        stop_at_end: bool,
    ) -> None:
        """`leg_end_s_m`, `leg_speed_mps`: end and speed limit of each leg, in order."""
        leg_end = np.asarray(leg_end_s_m)
        s, course, bend = _sparse(track, leg_end)
        most = np.asarray(leg_speed_mps)[np.searchsorted(leg_end[:-1], s)]
        thrust = PlannedThrust(s, course, most, limits.agility, limits.weather)
        sharp = _sharpness(s, course, _SHARP_S * most)
        sideways_share = (_SIDEWAYS + (_SHARP_SIDEWAYS - _SIDEWAYS) * sharp) * limits.share
        by_bend = np.sqrt(limits.agility.laterals_mps2(sideways_share) / bend)
        speed = np.minimum(most, np.maximum(by_bend, limits.slowest_mps))
        for _ in range(_ROUNDS):
            kept = thrust.followed(speed, limits.share, stop_at_end)
            grid, at, bow = _bow(s, course, kept, sharp, limits)
            sideways = np.abs(np.sin(np.clip(np.interp(s, at, bow) - course, -0.5 * math.pi, 0.5 * math.pi)))
            by_sway = limits.sway_mps / np.maximum(sideways, 1.0e-3)
            speed = np.minimum(speed, np.maximum(by_sway, np.minimum(most, limits.slowest_mps)))
        kept = _smooth_speed(s, thrust.followed(speed, limits.share, stop_at_end))
        grid, at, bow = _bow(s, course, kept, sharp, limits)
        self._limits = limits
        self._step_s = max(1.0e-3, float(grid.places[-1]) / (len(at) - 1))
        self._time: list[float] | None = None if grid.step is not None else grid.places.tolist()
        self._s: list[float] = s.tolist()
        self._square: list[float] = (kept * kept).tolist()
        self._course: list[float] = course.tolist()
        self._high_n: list[float] = thrust.high_n.tolist()
        self._low_n: list[float] = thrust.low_n.tolist()
        self._at: list[float] = at.tolist()
        self._bow: list[float] = bow.tolist()

    def course_rad(self, s_m: float) -> float:
        """The course of the bow planned at that arc length, not wrapped."""
        j, y = _place(self._at, s_m)
        return self._bow[j] + y * (self._bow[j + 1] - self._bow[j])

    def reach_mps2(self, s_m: float, speed_mps: float) -> tuple[float, float]:
        """Acceleration and braking of a boat that has that speed there, by the thrust that is planned with."""
        i, _ = _place(self._s, s_m)
        limits, agility = self._limits, self._limits.agility
        resisting = agility.resisting_n(speed_mps, self._course[i], limits.weather)
        return agility.gain_mps2(self._high_n[i] - resisting), agility.gain_mps2(resisting - self._low_n[i])

    def ahead_m(self, s_m: float, after_s: float, speed_mps: float) -> float:
        """The arc length that the boat reaches `after_s` after it is at `s_m`, at `speed_mps` there."""
        planned = self.speed_mps(s_m)
        pace = min(1.0, speed_mps / planned) if planned > 0.0 else 1.0
        i, x = _place(self._at, s_m)
        if self._time is not None:
            begin_s = self._time[i] + x * (self._time[i + 1] - self._time[i])
            j, y = _place(self._time, begin_s + pace * after_s)
            return self._at[j] + y * (self._at[j + 1] - self._at[j])
        index = min(len(self._at) - 1.0, i + x + pace * after_s / self._step_s)
        j = min(len(self._at) - 2, int(index))
        return self._at[j] + (index - j) * (self._at[j + 1] - self._at[j])

    def agrees(self, other: PathPlan, s_m: float) -> bool:
        """Whether a boat at `s_m` can change to the other plan of the same track without a jerk."""
        later_m = self.ahead_m(s_m, _AGREE_S, self.speed_mps(s_m))
        return all(
            abs(self.speed_mps(at_m) - other.speed_mps(at_m)) <= _AGREE_MPS
            and abs(self.course_rad(at_m) - other.course_rad(at_m)) <= _AGREE_RAD
            for at_m in (s_m, later_m)
        )

    def speed_mps(self, s_m: float) -> float:
        """The speed planned at that arc length; the square is interpolated, which gives constant acceleration."""
        i, x = _place(self._s, s_m)
        return math.sqrt(max(0.0, self._square[i] + x * (self._square[i + 1] - self._square[i])))


def _place(table: list[float], s_m: float) -> tuple[int, float]:
    """Index at or before `s_m`, never the last, and the share of the way to the next."""
    i = min(len(table) - 2, max(0, bisect_right(table, s_m) - 1))
    width = table[i + 1] - table[i]
    return i, min(1.0, max(0.0, (s_m - table[i]) / width)) if width > 0.0 else 0.0


def _sparse(track: Track, leg_end_s_m: Floats) -> tuple[Floats, Floats, Floats]:
    """(arc length, course, absolute curvature) at the samples of the track that a plan needs."""
    s, course = np.asarray(track.s_m), np.asarray(track.course_rad)
    bend = np.maximum(np.abs(np.asarray(track.curvature_1pm)), _STRAIGHT_1PM)
    dense = np.maximum(_SAMPLES_PER_M, np.maximum(bend[1:], bend[:-1]) / _RAD_PER_SAMPLE) * np.diff(s)
    number = np.floor(np.concatenate(([0.0], np.cumsum(dense))))
    keep = np.concatenate(([True], np.diff(number) > 0.0))
    keep[np.clip(np.searchsorted(s, leg_end_s_m), 0, len(s) - 1)] = True
    keep[-1] = True
    return s[keep], course[keep], bend[keep]


def _sharpness(s: Floats, course: Floats, near_m: Floats) -> Floats:
    """How sharp a corner the course turns within `near_m` of each sample: 0 up to 100°, which a swing through a right
    angle turns, 1 from 130° on."""
    turned = np.abs(np.interp(s + near_m, s, course) - np.interp(s - near_m, s, course))
    sharp: Floats = np.clip((turned - _SQUARE_RAD) / (_SHARP_RAD - _SQUARE_RAD), 0.0, 1.0)
    return sharp


def _times(s: Floats, speed: Floats) -> Floats:
    pace = np.maximum(0.5 * (speed[1:] + speed[:-1]), 0.02)
    return np.concatenate(([0.0], np.cumsum(np.diff(s) / pace)))


def _smooth_speed(s: Floats, speed: Floats) -> Floats:
    """The mean of the speed over a window of time, shorter towards the ends, where the speed is kept."""
    t = _times(s, speed)
    steps = _steps(s, t)
    grid = steps.places
    room = 2.0 * np.minimum(grid, grid[-1] - grid)
    width = np.minimum(_SPEED_MEAN_S, np.maximum(room, 1.0e-3))
    smooth: Floats = np.interp(t, grid, _mean(steps, np.interp(grid, t, speed), width))
    smooth[[0, -1]] = speed[[0, -1]]
    return smooth


def _steps(s: Floats, t: Floats) -> Steps:
    """Steps of time; `t`: the time at each arc length."""
    count = max(3.0, math.ceil(t[-1] / _STEP_S) + 1)
    if t[-1] <= _MOST_STEPS * _LONGEST_STEP_S:
        even = np.linspace(0.0, t[-1], int(min(_MOST_STEPS, count)))
        return Steps(even, float(even[1] - even[0]))
    near = (np.diff(s) < _NEAR_SHARE * np.max(np.diff(s))) & (np.diff(t) < _NEAR_S)
    parts = np.where(near, np.ceil(np.diff(t) / _LONGEST_STEP_S), 1.0)
    ends = np.concatenate(([0.0], np.cumsum(parts)))
    return Steps(np.interp(np.arange(ends[-1] + 1.0), ends, t), None)


def _bow(s: Floats, course: Floats, speed: Floats, sharp: Floats, limits: PlanLimits) -> tuple[Steps, Floats, Floats]:
    """(steps of time, arc length there, course of the bow there)."""
    t = _times(s, speed)
    steps = _steps(s, t)
    grid, count = steps.places, len(steps.places)
    at, along = np.interp(grid, t, s), np.interp(grid, t, course)
    agility, pace = limits.agility, np.interp(grid, t, speed)
    part = 1.0 + (_SHARP_RATE - 1.0) * np.interp(grid, t, sharp)
    port, starboard = (
        _eased_rate(agility.turns_radps(_TURNING * limits.share * side, pace), part)
        for side in (agility.port_share, agility.starboard_share)
    )
    width = _mean(steps, _widths(steps, along, port, starboard), np.full(count, _WIDTH_MEAN_S))
    smooth = _mean(steps, along, width)
    for last_s in _LAST_MEANS_S:
        smooth = _mean(steps, smooth, np.full(count, last_s))
    return steps, at, smooth


def _eased_rate(rate: Floats, part: Floats) -> Floats:
    """That part of the rate, but not below _SHARP_RADPS where the rate is above it."""
    eased: Floats = np.minimum(rate, np.maximum(part * rate, _SHARP_RADPS))
    return eased


def _widths(steps: Steps, along: Floats, port_radps: Floats, starboard_radps: Floats) -> Floats:
    """The window at each time: the shortest over which the course turns no faster than the rate there of that side, and
    as wide all around a turn as the turn needs."""
    grid = steps.places
    width = np.full(len(grid), _SHORTEST_S)
    candidate = _SHORTEST_S
    while candidate < _LONGEST_S:
        half = 0.5 * candidate
        turned = np.interp(grid + half, grid, along) - np.interp(grid - half, grid, along)
        fast = np.abs(turned) > np.where(turned < 0.0, port_radps, starboard_radps) * candidate
        if not np.any(fast):
            break
        candidate *= _GROWTH
        total = np.concatenate(([0], np.cumsum(fast)))
        first, behind = _reached(steps, 0.5 * candidate)
        width[total[behind] > total[first]] = candidate
    return width


def _reached(steps: Steps, reach: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Of each place, the index of the first that it reaches, and of the first behind those."""
    places = steps.places
    if steps.step is None:
        return np.searchsorted(places, places - reach), np.searchsorted(places, places + reach, side="right")
    count, index = math.ceil(reach / max(steps.step, 1.0e-9)), np.arange(len(places))
    return np.maximum(index - count, 0), np.minimum(index + count + 1, len(places))


def _mean(steps: Steps, values: Floats, width: Floats) -> Floats:
    """Mean of the piecewise linear `values` over each window; values beyond the ends are those of the ends."""
    grid, step = steps.places, steps.step
    most = 0.5 * float(np.max(width))
    if step is not None and step <= 0.0:
        return values
    if step is None or step < _BRIEF_S:
        step, pad, times = None, 1, np.concatenate(([grid[0] - most - 1.0], grid, [grid[-1] + most + 1.0]))
    else:
        pad = math.ceil(most / step) + 1
        times = float(grid[0]) - pad * step + step * np.arange(len(values) + 2 * pad)
    longer = np.concatenate((np.full(pad, values[0]), values, np.full(pad, values[-1])))
    half = 0.5 * width
    mean: Floats = Steps(times, step).integral(longer, grid - half, grid + half) / width
    return mean
