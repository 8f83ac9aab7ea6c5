"""The least distance of a follow position: outside the keep-out circle, and astern as far as the boat needs to lose its
way when the leader stops."""

from __future__ import annotations

import math

from companion.config.reversing import can_reverse
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.following.clearance import Clearance
from companion.following.keep_out import round_m
from companion.params.store import Parameters

_COUNT = ("FOLL_MIN_DIST", "FOLL_MARGIN", "PATH_ACC", "PATH_YAW_RATE", "MPC_XY_VEL_MAX")
_SPEEDS_MPS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)  # a faster leader goes on further than it needs


class KeptDistance:
    """`of(follow_position)` → the distance in m that is kept for one that is asked for, (distance_m, bearing_rad).

    Astern, a leader of any speed may stop: the boat then coasts, brakes or turns aside, as `Clearance` predicts it, and
    keeps out of the circle by what `Clearance` calls near. Remembers that distance until a parameter changes.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self._clearance = Clearance(config, parameters, can_reverse(config.thrusters))
        self._top_mps = top_speed_mps(config)
        self._astern_m: float | None = None
        parameters.on_change(lambda name, _value: self._forget(name))

    def of(self, follow_position: tuple[float, float]) -> float:
        """No less than the distance asked for."""
        asked_m, bearing_rad = follow_position
        if self._astern_m is None:
            self._astern_m = self._clearance.near_m + self._nearer_m()
        beside_m = round_m(self._parameters)
        behind = max(0.0, math.cos(wrap_pi(bearing_rad - math.pi)))  # beside the leader, the boat passes it
        return max(asked_m, beside_m + behind * max(0.0, self._astern_m - beside_m))

    def _nearer_m(self) -> float:
        most_mps = min(self._top_mps, self._parameters["MPC_XY_VEL_MAX"])
        return max(self._clearance.nearer_m(min(speed_mps, most_mps)) for speed_mps in _SPEEDS_MPS)

    def _forget(self, name: str) -> None:
        if name in _COUNT:
            self._astern_m = None
