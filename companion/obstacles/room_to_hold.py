"""Where a boat holds that moves about its hold point: where what lies leaves room for that."""

from __future__ import annotations

import math

import numpy as np

from companion.config.reversing import can_reverse, turns_in_place
from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.fence.allowed import Place
from companion.fence.guard import FenceGuard
from companion.guidance.bend_speed import TURN_SHARE, steady_turn_radps
from companion.obstacles.clear_way import stop_m
from companion.obstacles.open_water import Water
from companion.params.store import Parameters

_LEAST_SHARE = 0.5
_FARTHEST = 3.0  # times the room
_RINGS, _BEARINGS = 12, 24
_LAG_S = 1.5  # of a turn in a stream
_LEAST_ASTERN_MPS = 0.05


class RoomToHold:
    """Of a boat that goes on as it turns, with a rudder, a nozzle or a lone outboard: it may be anywhere in its watch
    circle (DP_WATCH_R). Others turn in place and need no room. Remembers nothing."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self._half_m = 0.5 * config.length_m
        self._hull, self._turning_nm = config.hull, TURN_SHARE * config.limits.yaw_nm
        self._moves = config.limits.sway_n <= 0.0 and not turns_in_place(config.thrusters)
        self._backs = self._moves and can_reverse(config.thrusters)

    @property
    def room_m(self) -> float:
        """How far the boat moves from the point that it holds, more than others do; 0 for those."""
        return self._parameters["DP_WATCH_R"] if self._moves else 0.0

    @property
    def least_m(self) -> float:
        """The part of it that the boat needs in most weathers: with less it looks for another place."""
        return _LEAST_SHARE * self.room_m

    def carried_m(self, stream_mps: float) -> float:
        """How far a stream from astern, at `stream_mps`, carries the boat on until its bow has come round into it; 0
        where it comes from ahead."""
        if not self._moves or stream_mps <= 0.0:
            return 0.0
        asked_radps = math.radians(self._parameters["PATH_YAW_RATE"])
        turn_radps = min(asked_radps, steady_turn_radps(self._hull, stream_mps, self._turning_nm))
        return stream_mps * (math.pi / turn_radps + _LAG_S)

    def better(self, place: Place, here: Place, water: Water) -> Place | None:
        """The nearest place with enough room that is open to a boat at `here`, else the one with the most; None where
        `place` has room enough, and where none has markedly more."""
        room_m = self.room_m
        has_m = self._gap_m(place, water)
        if has_m >= self.least_m:
            return None
        best, best_m = None, max(0.0, has_m) + self.least_m
        for ring in range(1, _RINGS + 1):
            far_m = ring / _RINGS * _FARTHEST * room_m
            for other in _around(place, far_m):
                gap_m = self._gap_m(other, water)
                if gap_m > best_m and self._is_open(here, other, water):
                    best, best_m = other, gap_m
            if best_m >= room_m:
                break
        return best

    def backs_out(self, nav: NavState, water: Water, fence: FenceGuard, backing: bool) -> bool:
        """Whether a boat that goes on as it turns, and has too little room here, goes straight astern out of it.
        `backing`: it does so already, until it has all the room."""
        here, astern_rad = (nav.north_m, nav.east_m), nav.yaw_rad + math.pi
        has_m = self._gap_m(here, water)
        if not self._backs or has_m >= (self.room_m if backing else self.least_m):
            return False
        along = math.cos(astern_rad), math.sin(astern_rad)
        aside_m = self._half_m * nav.sway_mps / max(_LEAST_ASTERN_MPS, self._parameters["DP_SPEED_ASTERN"])
        next_place = (
            here[0] + self._half_m * along[0] + aside_m * along[1],
            here[1] + self._half_m * along[1] - aside_m * along[0],
        )
        far_place = here[0] + 4.0 * self._half_m * along[0], here[1] + 4.0 * self._half_m * along[1]
        return (
            self._gap_m(next_place, water) > has_m
            and fence.room_m(here, astern_rad) > 2.0 * self._half_m
            and math.isinf(water.free_m((here, far_place)))
        )

    def _gap_m(self, place: Place, water: Water) -> float:
        """From the hull of a boat at that place to the nearest thing that lies, less the distance at which it stops."""
        kept_m = self._half_m + stop_m(self._parameters)
        circles = water.circles
        gaps = np.hypot(circles[:, 0] - place[0], circles[:, 1] - place[1]) - circles[:, 2]
        by_chart = math.inf if water.chart is None else water.chart.bare.margin(*place).distance_m
        return min(float(gaps.min(initial=math.inf)), by_chart) - kept_m

    @staticmethod
    def _is_open(here: Place, place: Place, water: Water) -> bool:
        return water.allowed.point_refusal(*place) is None and water.line_refusal((here, place)) is None


def _around(place: Place, far_m: float) -> list[Place]:
    bearings = [i * math.tau / _BEARINGS for i in range(_BEARINGS)]
    return [(place[0] + far_m * math.cos(b), place[1] + far_m * math.sin(b)) for b in bearings]
