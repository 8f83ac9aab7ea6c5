"""Keeping off what comes nearer while the boat makes no way: ahead or astern, since it cannot turn in time.

What moves may come to a boat at rest; onto what lies, wind and current set a boat that stops or turns on the spot.
The boat's motion is predicted for each choice of speed, and the slowest one that keeps clear is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.decision import TextKind
from companion.core.estimate import Contact, NavState
from companion.core.events import EventLog
from companion.core.frames import ned_to_body
from companion.core.setpoint import PathSetpoint, Setpoint
from companion.fence.guard import FenceGuard
from companion.obstacles.braking import Braking, stream_along_mps
from companion.obstacles.clear_way import STOP_SHARE, clear_way_m
from companion.obstacles.occupancy import Floats
from companion.obstacles.open_water import Water
from companion.params.store import Parameters

_SLOW_MPS = 0.5  # a boat that makes less way keeps off; so does one that is being stopped
_STOPPED_MPS = 0.1
_SOON_S, _LYING_SOON_S, _STEP_S = 20.0, 6.0, 0.5  # how far it looks for what moves, and for what lies
_MOVER_M = 2.0  # water to what moves that is too little
_LYING_SHARE = 0.5  # of the distance at which the boat stops: water to what lies that is too little
_CLOSING_M = 0.1
_OUT_M = 10.0  # how far it goes at most
_SWAY_S = 2.5  # in which sideways motion through the water decays
_BETTER_M, _SAME_SIDE_M = 0.1, 1.0


@dataclass(frozen=True, slots=True)
class _Around:
    """What there is to keep off. `lying`: circles (north_m, east_m, radius_m) near the boat."""

    movers: Sequence[Contact]
    lying: Floats
    water: Water


class KeepingOff:
    """`update(setpoint, movers, water, nav, cruise_mps, now_s)` → speed along the heading, or None where the setpoint
    keeps clear by itself. Remembers on which side it goes out of the way."""

    def __init__(
        self, config: VesselConfig, parameters: Parameters, fence: FenceGuard, braking: Braking, events: EventLog
    ) -> None:
        self._half_m = 0.5 * config.length_m
        self._parameters = parameters
        self._fence = fence
        self._braking = braking
        self._events = events
        self._speed_mps = 0.0  # with which the boat goes out of the way

    def update(
        self,
        setpoint: Setpoint,
        movers: Sequence[Contact],
        water: Water,
        nav: NavState,
        cruise_mps: float,
        now_s: float,
    ) -> PathSetpoint | None:
        """`setpoint`: what the boat does otherwise, already limited so that it stops in time."""
        asked = setpoint if isinstance(setpoint, PathSetpoint) else PathSetpoint(nav.yaw_rad)
        slow = math.hypot(nav.north_mps, nav.east_mps) < _SLOW_MPS or abs(asked.surge_mps) < _STOPPED_MPS
        around = _Around(movers, self._near(water, nav), water)
        if not slow or not (len(around.movers) or len(around.lying)):
            self._speed_mps = 0.0
            return None
        before, room = self._speed_mps, self._room_m(around, nav, asked, math.inf, self.lasts)
        if room >= 0.0:
            self._speed_mps = 0.0
            return None
        self._speed_mps = self._chosen(around, nav, cruise_mps, room)
        if self._speed_mps == 0.0:
            return None
        if before == 0.0:
            self._events.say(now_s, TextKind.ATTENTION, "obstacle_comes", "Obstacle comes near: out of its way")
        return PathSetpoint(nav.yaw_rad, surge_mps=self._speed_mps)

    def comes(self, movers: Sequence[Contact], nav: NavState) -> bool:
        """Whether something that moves comes too near to a boat that stays where it is."""
        return self._room_of_movers_m(movers, nav.north_m, nav.east_m, np.arange(0.0, _SOON_S, _STEP_S)) < 0.0

    def reset(self) -> None:
        """The boat does not keep off anything."""
        self._speed_mps = 0.0

    @property
    def lasts(self) -> bool:
        """Whether the boat goes out of the way now."""
        return self._speed_mps != 0.0

    @property
    def _stop_m(self) -> float:
        """Water to what lies, at which the boat stops."""
        return STOP_SHARE * max(0.0, self._parameters["CP_DIST"])

    def _near(self, water: Water, nav: NavState) -> Floats:
        """What the boat may be set onto soon; of a chart's obstacles, the nearest place."""
        here, lying = (nav.north_m, nav.east_m), water.circles
        if water.chart is not None:
            shore = water.chart.bare.margin(*here)
            place = here[0] - shore.distance_m * shore.north, here[1] - shore.distance_m * shore.east
            lying = np.vstack((lying, (*place, 0.0))) if math.isfinite(shore.distance_m) else lying
        if not len(lying):
            return lying
        gaps = np.hypot(lying[:, 0] - here[0], lying[:, 1] - here[1]) - lying[:, 2] - self._half_m
        reach = self._stop_m + _LYING_SOON_S * max(_SLOW_MPS, math.hypot(nav.north_mps, nav.east_mps))
        near: Floats = lying[gaps < reach]
        return near

    def _chosen(self, around: _Around, nav: NavState, cruise_mps: float, room: float) -> float:
        """The slowest speed that keeps clear, else the best; 0 where none is better than to do nothing."""
        bow, best, chosen = (math.cos(nav.yaw_rad), math.sin(nav.yaw_rad)), room, 0.0
        here = nav.north_m, nav.east_m
        open_m: dict[float, float] = {}
        for sign in (1.0, -1.0):
            way = sign * bow[0], sign * bow[1]
            out_m = min(_OUT_M, clear_way_m(here, way, around.lying, self._half_m + self._stop_m))
            out_m = out_m if around.water.chart is None else min(out_m, around.water.chart.stop_m(here, way))
            end = here[0] + out_m * way[0], here[1] + out_m * way[1]
            open_m[sign] = out_m if self._fence.line_refusal((here, end)) is None else 0.0
        for share in (0.5, 1.0):
            for sign, out_m in open_m.items():
                stream = stream_along_mps(nav, sign * bow[0], sign * bow[1])
                most = self._braking.speed_mps(out_m, stream)
                speed = sign * min(max(share * cruise_mps, min(_SLOW_MPS, cruise_mps)), most)
                found = self._room_m(around, nav, PathSetpoint(nav.yaw_rad, surge_mps=speed), out_m, True)
                found += _SAME_SIDE_M if speed * self._speed_mps > 0.0 else 0.0
                if found > best + _BETTER_M and abs(speed) > _STOPPED_MPS:
                    best, chosen = found, speed
            if best >= 0.0:
                break
        return chosen

    def _room_m(self, around: _Around, nav: NavState, asked: PathSetpoint, out_m: float, wide: bool) -> float:
        """By how much the water to everything exceeds what is too little, if the boat sails as asked, at most `out_m`;
        below 0 it does not. `wide`: judge what lies by all of the distance at which the boat stops."""
        times = np.arange(0.0, _SOON_S, _STEP_S)
        north, east = self._places(nav, asked, out_m, times)
        room = self._room_of_movers_m(around.movers, north, east, times)
        if len(around.lying):
            soon = times <= _LYING_SOON_S
            lying = around.lying
            gaps = np.hypot(lying[:, :1] - north[soon], lying[:, 1:2] - east[soon]) - lying[:, 2:] - self._half_m
            closing = gaps.min(axis=1) < gaps[:, 0] - _CLOSING_M
            if closing.any():
                least_m = float(gaps[closing].min())
                room = min(room, least_m - (1.0 if wide else _LYING_SHARE) * self._stop_m)
        return room

    def _room_of_movers_m(
        self, movers: Sequence[Contact], north_m: Floats | float, east_m: Floats | float, times: Floats
    ) -> float:
        """The same to what moves alone, of a boat that is at these places, or at one place, at these times."""
        room = math.inf
        for one in movers:
            gaps = np.hypot(one.north_m + times * one.north_mps - north_m, one.east_m + times * one.east_mps - east_m)
            room = min(room, float(gaps.min()) - one.radius_m - self._half_m - _MOVER_M)
        return room

    def _places(self, nav: NavState, asked: PathSetpoint, out_m: float, times: Floats) -> tuple[Floats, Floats]:
        """Where the boat will be, north and east: its speed goes to the one asked for, its heading too, sideways it
        goes on with the current."""
        lag = 1.0 / self._parameters["PATH_BW_SURGE"]
        speed = asked.surge_mps + (nav.surge_mps - asked.surge_mps) * np.exp(-times / lag)
        way = np.clip(np.concatenate(([0.0], np.cumsum(0.5 * _STEP_S * (speed[1:] + speed[:-1])))), -out_m, out_m)
        turn, rate = wrap_pi(asked.yaw_rad - nav.yaw_rad), math.radians(self._parameters["PATH_YAW_RATE"])
        yaw = nav.yaw_rad + math.copysign(1.0, turn) * np.minimum(abs(turn), rate * times)
        steps = np.diff(way)
        ahead_n = np.concatenate(([0.0], np.cumsum(steps * np.cos(yaw[1:]))))
        ahead_e = np.concatenate(([0.0], np.cumsum(steps * np.sin(yaw[1:]))))
        side_m = self._side_m(nav, times)
        return (
            nav.north_m + ahead_n - side_m * math.sin(nav.yaw_rad),
            nav.east_m + ahead_e + side_m * math.cos(nav.yaw_rad),
        )

    @staticmethod
    def _side_m(nav: NavState, times: Floats) -> Floats:
        """Way to starboard. Without a known current, all of the present motion goes on."""
        if nav.current_north_mps is None or nav.current_east_mps is None:
            return nav.sway_mps * times
        _, stream = ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)
        decayed: Floats = _SWAY_S * (1.0 - np.exp(-times / _SWAY_S))
        return stream * times + (nav.sway_mps - stream) * decayed
