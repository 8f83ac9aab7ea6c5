"""The cruise speed, learnt from how the operator sails by stick while a switch of the transmitter is on."""

from __future__ import annotations

from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.params.store import Parameters
from companion.supervisor.helm import Helm

LEAST_S = 5.0  # shorter than that is no average
_PARAMETER = "WP_SPEED"


class CruiseLearning:
    """`switched(on, nav, now_s)` when the switch moves, `update(nav, achieved, now_s)` once a tick. Switched off, the
    mean speed ahead over the ground since it was switched on becomes WP_SPEED.

    Remembers since when it learns, None while it does not, and the sums of speed and thrust.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, helm: Helm, events: EventLog) -> None:
        self._most_n = config.limits.surge_n
        self._parameters = parameters
        self._helm = helm
        self._events = events
        self._since_s: float | None = None
        self._count = 0
        self._speed_sum_mps = 0.0
        self._thrust_sum_n = 0.0

    def switched(self, on: bool, nav: NavState, now_s: float) -> None:
        """Begin, or end and set the speed. What is refused is announced."""
        if not on:
            self._end(now_s)
        elif (reason := self._objection(nav)) is not None:
            self._refuse(reason, now_s)
        else:
            self._since_s, self._count = now_s, 0
            self._speed_sum_mps = self._thrust_sum_n = 0.0
            self._events.say(now_s, TextKind.ROUTINE, "cruise_learning", "Learning the cruise speed: sail it now")

    def update(self, nav: NavState, achieved: Wrench, now_s: float) -> None:
        """Add this tick. `achieved`: what the thrusters gave in the last one."""
        if self._since_s is None:
            return
        if (reason := self._objection(nav)) is not None:
            self._since_s = None
            self._refuse(reason, now_s)
            return
        self._count += 1
        self._speed_sum_mps += nav.surge_mps
        self._thrust_sum_n += achieved.surge_n

    def _objection(self, nav: NavState) -> str | None:
        if not self._helm.armed:
            return "arm first"
        if not self._helm.mode.by_stick:
            return f"{self._helm.mode.id.value} sails by itself"
        return None if nav.position_valid and nav.heading_valid else "speed not known"

    def _end(self, now_s: float) -> None:
        since_s, self._since_s = self._since_s, None
        if since_s is None:
            return
        if now_s - since_s < LEAST_S or not self._count:
            self._refuse(f"sail {LEAST_S:.0f} s or more", now_s)
            return
        speed_mps = min(self._speed_sum_mps / self._count, self._parameters["MPC_XY_VEL_MAX"])
        if self._parameters.set(_PARAMETER, speed_mps) is not None:
            self._refuse(f"{speed_mps:.2f} m/s is no {_PARAMETER}", now_s)
            return
        share = f" at {100.0 * self._thrust_sum_n / self._count / self._most_n:.0f} % thrust" if self._most_n else ""
        self._events.say(now_s, TextKind.ROUTINE, "cruise_learnt", f"{_PARAMETER} learnt: {speed_mps:.2f} m/s{share}")

    def _refuse(self, reason: str, now_s: float) -> None:
        self._events.say(now_s, TextKind.REFUSAL, "cruise_not_learnt", f"Cruise speed not learnt: {reason}")
