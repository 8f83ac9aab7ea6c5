"""Keeping off what comes nearer while the boat makes no way.

What moves may come to a boat at rest: any heading may lead out of its way, ahead or astern. Onto what lies, wind and
current set a boat that stops, turns on the spot or moves about its hold point: then it goes ahead or astern, since it
cannot turn in time. One without thrust astern can only turn.
The boat's motion is predicted for each choice, and the slowest one that keeps clear is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.estimate import Contact, NavState
from companion.core.events import EventLog
from companion.core.setpoint import PathSetpoint, Setpoint
from companion.fence.guard import FenceGuard
from companion.obstacles.braking import Braking, stream_along_mps
from companion.obstacles.clear_way import reach_m, stop_m
from companion.obstacles.occupancy import Floats
from companion.obstacles.open_water import Water
from companion.obstacles.ways_out import TIMES_S, Choices, WaysOut
from companion.params.store import Parameters

_SLOW_MPS = 0.5  # a boat that makes less way by its thrust keeps off; so does one that is being stopped
_STOPPED_MPS = 0.1
_COASTS_MPS = 0.2  # more way than asked for: a boat without thrust astern cannot stop now
# How far it looks for what lies, and at least until it makes way after a turn on the spot; for what moves, as far as
# its motion is predicted.
_LYING_SOON_S, _TURNED_S = 6.0, 2.0
_ROUND_SOON_S = 10.0  # the same of a boat that its nozzle turns: until it has turned round
_ACTS_S = 1.5  # before that, all choices are as near to what moves
_MOVER_M = 2.0  # water to what moves that is too little
_LYING_SHARE = 0.5  # of the distance at which the boat stops: water to what lies that is too little
_LASTS_M = 0.5  # more than enough, with which it goes on as asked
_CLOSING_M = 0.1
_OUT_M = 10.0  # how far it goes at most
_DIRECTION_RAD = math.radians(5.0)
_BETTER_M, _SAME_M, _SAME_RAD = 0.1, 1.0, math.radians(45.0)
_COST_OF_SPEED_S, _COST_OF_TURN_M = 0.1, 0.1  # of speed in m/s, and of a turn by a radian, in metres of water


@dataclass(frozen=True, slots=True)
class _Around:
    """What there is to keep off. `lying`: circles (north_m, east_m, radius_m) near the boat. `drifts`: the boat moves
    about a point that it cannot keep, slowly enough to turn."""

    movers: Sequence[Contact]
    lying: Floats
    water: Water
    drifts: bool


class KeepingOff:
    """`update(setpoint, movers, water, nav, cruise_mps, now_s)` → heading and speed, or None where the setpoint keeps
    clear by itself. Remembers which way it goes out of the way."""

    def __init__(
        self, config: VesselConfig, parameters: Parameters, fence: FenceGuard, braking: Braking, events: EventLog
    ) -> None:
        self._half_m = reach_m(config)
        self._can_sway = config.limits.sway_n > 0.0
        self._parameters = parameters
        self._fence = fence
        self._braking = braking
        self._events = events
        self._ways = WaysOut(config, parameters)
        self._soon_s = _ROUND_SOON_S if self._ways.by_nozzle else _LYING_SOON_S
        self._taken: tuple[float, float] | None = None  # heading and speed

    @property
    def coasts(self) -> bool:
        """Whether the boat has no thrust astern."""
        return self._ways.coasts

    def update(
        self,
        setpoint: Setpoint,
        movers: Sequence[Contact],
        water: Water,
        nav: NavState,
        cruise_mps: float,
        now_s: float,
        drifts: bool = False,
        way_m: float = math.inf,
    ) -> PathSetpoint | None:
        """`setpoint`: what the boat does otherwise, already limited so that it stops in time, after `way_m` at most.
        `drifts`: it moves about a point that it cannot keep."""
        asked = setpoint if isinstance(setpoint, PathSetpoint) else PathSetpoint(nav.yaw_rad)
        slow = math.hypot(nav.surge_mps, nav.sway_mps if self._can_sway else 0.0) < _SLOW_MPS
        slow = slow or abs(asked.surge_mps) < _STOPPED_MPS
        slow = slow or (self._ways.coasts and nav.surge_mps > asked.surge_mps + _COASTS_MPS)
        around = _Around(movers, self._near(water, nav), water, drifts)
        before, self._taken = self._taken, None
        slow = slow or before is not None  # what it does to get out of the way is no way that it makes
        if not slow or not (len(around.movers) or len(around.lying)):
            return None
        # It may go on as asked, or stop before what lies: what comes may pass behind the one and meet the other.
        ways_m = np.array([math.inf, way_m] if movers and math.isfinite(way_m) else [math.inf])
        asked_rad, asked_mps = np.full(len(ways_m), asked.yaw_rad), np.full(len(ways_m), asked.surge_mps)
        north, east = self._ways.places(Choices(asked_rad, asked_mps, ways_m), nav)
        soon_s = max(self._soon_s, self._ways.turning_s(asked.yaw_rad, nav) + _TURNED_S)
        room_m = min(
            float(self._rooms_of_movers_m(movers, north, east).min()),
            float(self._room_of_lying_m(around.lying, north[:1], east[:1], before is not None, soon_s)[0]),
        )
        if room_m >= (0.0 if before is None else _LASTS_M):
            return None
        self._taken = self._chosen(around, nav, (north, east), cruise_mps, before)
        if self._taken is None:
            return None
        if before is None:
            self._events.say(now_s, TextKind.ATTENTION, "obstacle_comes", "Obstacle comes near: out of its way")
        return PathSetpoint(self._taken[0], surge_mps=self._taken[1])

    def comes(self, movers: Sequence[Contact], nav: NavState) -> bool:
        """Whether something that moves comes too near to a boat that stays where it is."""
        north, east = np.array([[nav.north_m]]), np.array([[nav.east_m]])
        return bool(self._rooms_of_movers_m(movers, north, east).min() < 0.0)

    def reset(self) -> None:
        """The boat does not keep off anything."""
        self._taken = None

    @property
    def lasts(self) -> bool:
        """Whether the boat goes out of the way now. To coast is not to go."""
        return self._taken is not None and self._taken[1] != 0.0

    def _near(self, water: Water, nav: NavState) -> Floats:
        """What the boat may be set onto soon, or meet on its way out: the nearest thing in each of 72 directions; of a
        chart's obstacles, the nearest place."""
        here, lying = (nav.north_m, nav.east_m), water.circles
        if water.chart is not None:
            shore = water.chart.bare.margin(*here)
            place = here[0] + shore.distance_m * shore.north, here[1] + shore.distance_m * shore.east
            lying = np.vstack((lying, (*place, 0.0))) if math.isfinite(shore.distance_m) else lying
        if not len(lying):
            return lying
        north, east = lying[:, 0] - here[0], lying[:, 1] - here[1]
        gaps = np.hypot(north, east) - lying[:, 2] - self._half_m
        count = int((gaps < stop_m(self._parameters) + _OUT_M).sum())
        nearest = np.argsort(gaps)[:count]
        directions = np.floor(np.arctan2(east[nearest], north[nearest]) / _DIRECTION_RAD)
        near: Floats = lying[nearest[np.unique(directions, return_index=True)[1]]]
        return near

    # --- choosing ---------------------------------------------------------------------------------------------------

    def _chosen(
        self,
        around: _Around,
        nav: NavState,
        otherwise: tuple[Floats, Floats],
        cruise_mps: float,
        before: tuple[float, float] | None,
    ) -> tuple[float, float] | None:
        """Heading and speed of the slowest choice that keeps clear, else of the best; None where none is better than to
        do nothing. `otherwise`: where the boat is then, going on and stopping. `before`: what was chosen last."""
        least_m = float(self._water_m(around, *otherwise).min())
        comes = bool(self._rooms_of_movers_m(around.movers, *otherwise).min() < 0.0)
        turns = comes or self._ways.coasts or around.drifts
        goes_on = otherwise[0][:1], otherwise[1][:1]
        choices, north, east = self._choices(around.lying, goes_on, nav, cruise_mps, turns)
        water_m = self._water_m(around, north, east)
        turn = np.abs(choices.turns_rad(nav.yaw_rad))
        value = water_m - _COST_OF_SPEED_S * np.abs(choices.surge_mps) - _COST_OF_TURN_M * turn
        if before is not None:
            same = np.sign(choices.surge_mps) == np.sign(before[1])
            value[(np.abs(choices.turns_rad(before[0])) < _SAME_RAD) & same] += _SAME_M
        for one in np.argsort(-value):
            if water_m[one] > least_m + _BETTER_M and self._allowed(around, north[one], east[one], nav):
                return float(choices.yaw_rad[one]), float(choices.surge_mps[one])
        return None

    def _choices(
        self, lying: Floats, otherwise: tuple[Floats, Floats], nav: NavState, cruise_mps: float, turns: bool
    ) -> tuple[Choices, Floats, Floats]:
        """What the boat can do, each as far and as fast as what lies leaves way for it, and where it then is: places as
        of `WaysOut`."""
        speeds = [max(share * cruise_mps, min(_SLOW_MPS, cruise_mps)) for share in (0.5, 1.0)]
        choices = self._ways.choices(nav.yaw_rad, speeds, _OUT_M, turns)
        north, east = self._ways.places(choices, nav)
        out_m = self._open_m(lying, otherwise, north, east)
        surges = [
            math.copysign(min(abs(speed), self._most_mps(nav, yaw, speed, way)), speed)
            for yaw, speed, way in zip(
                choices.yaw_rad.tolist(), choices.surge_mps.tolist(), out_m.tolist(), strict=True
            )
        ]
        surge_mps = np.asarray(surges)
        kept = np.nonzero((np.abs(surge_mps) > _STOPPED_MPS) | (choices.surge_mps == 0.0))[0]
        changed = np.nonzero(((out_m < _OUT_M) | (surge_mps != choices.surge_mps))[kept])[0]
        choices, north, east = Choices(choices.yaw_rad, surge_mps, out_m).only(kept), north[kept], east[kept]
        if len(changed):  # most are not, and a jet's take long to predict
            north[changed], east[changed] = self._ways.places(choices.only(changed), nav)
        return choices, north, east

    def _most_mps(self, nav: NavState, yaw_rad: float, surge_mps: float, out_m: float) -> float:
        sign = math.copysign(1.0, surge_mps)
        stream_mps = stream_along_mps(nav, sign * math.cos(yaw_rad), sign * math.sin(yaw_rad))
        return self._braking.speed_mps(out_m, stream_mps)

    def _open_m(self, lying: Floats, otherwise: tuple[Floats, Floats], north: Floats, east: Floats) -> Floats:
        """Way along each choice, at most `_OUT_M`, until the boat is too near to what lies, and nearer than wind and
        current would take it if it did nothing; shape (n,)."""
        ways = np.cumsum(np.hypot(np.diff(north), np.diff(east)), axis=1)
        ways = np.minimum(_OUT_M, np.concatenate((np.zeros((len(ways), 1)), ways), axis=1))
        if not len(lying):
            open_m: Floats = ways[:, -1]
            return open_m
        gaps = self._gaps_m(lying, north, east)
        nearer = np.minimum(gaps[:, :1], self._gaps_m(lying, *otherwise)) - _CLOSING_M
        meets = ((gaps < stop_m(self._parameters)) & (gaps < nearer)).any(axis=2)
        least: Floats = np.where(meets, ways, _OUT_M).min(axis=1)
        return least

    def _allowed(self, around: _Around, north: Floats, east: Floats, nav: NavState) -> bool:
        """Whether a choice, places of shape (k,), stays within the fence, and clear of a chart's obstacles, until the
        boat stops."""
        line = [(nav.north_m, nav.east_m), *zip(north[1::4].tolist(), east[1::4].tolist(), strict=True)]
        chart = around.water.chart
        return self._fence.line_refusal(line) is None and (chart is None or chart.line_refusal(line) is None)

    # --- judging ----------------------------------------------------------------------------------------------------

    def _water_m(self, around: _Around, north: Floats, east: Floats) -> Floats:
        """By how much the water to everything falls short of enough, at most 0, shape (n,). Nearness that lasts counts
        beside the least water: what is too near already is to be left behind soon."""
        movers = np.minimum(0.0, self._rooms_of_movers_m(around.movers, north, east)[:, TIMES_S >= _ACTS_S])
        lying = self._room_of_lying_m(around.lying, north, east, True, self._soon_s)
        found: Floats = np.minimum(np.minimum(0.0, lying), movers.min(axis=1) + movers.mean(axis=1))
        return found

    def _gaps_m(self, lying: Floats, north: Floats, east: Floats) -> Floats:
        """Water between hull and what lies, shape (n, k, m)."""
        off_n, off_e = north[:, :, None] - lying[:, 0], east[:, :, None] - lying[:, 1]
        gaps: Floats = np.sqrt(off_n * off_n + off_e * off_e) - lying[:, 2] - self._half_m
        return gaps

    def _room_of_lying_m(self, lying: Floats, north: Floats, east: Floats, wide: bool, soon_s: float) -> Floats:
        """By how much the water to what lies, and comes nearer within `soon_s`, exceeds what is too little, shape (n,).
        `wide`: by all of the distance at which the boat stops."""
        if not len(lying):
            return np.full(len(north), math.inf)
        soon = soon_s >= TIMES_S
        gaps = self._gaps_m(lying, north[:, soon], east[:, soon])
        closing = gaps.min(axis=1) < gaps[:, 0] - _CLOSING_M
        least = np.where(closing, gaps.min(axis=1), math.inf).min(axis=1)
        room: Floats = least - (1.0 if wide else _LYING_SHARE) * stop_m(self._parameters)
        return room

    def _rooms_of_movers_m(self, movers: Sequence[Contact], north: Floats, east: Floats) -> Floats:
        """By how much the water to what moves exceeds what is too little at each of `TIMES_S`, shape (n, k). Of a boat
        that stays at one place, (n, 1) will do."""
        room = np.full((len(north), len(TIMES_S)), math.inf)
        for one in movers:
            gaps = np.hypot(one.north_m + TIMES_S * one.north_mps - north, one.east_m + TIMES_S * one.east_mps - east)
            room = np.minimum(room, gaps - one.radius_m - self._half_m - _MOVER_M)
        return room
