"""ArduPilot's Guided while no setpoints come: the boat holds and waits for one. A single position is a go-to, as
Mission Planner sends it, and so is a mission item with `current` 2, DroneKit's; a stream of setpoints begins
Offboard."""

from __future__ import annotations

import math

from companion.core.decision import ModeId, Outcome, Result, TextKind
from companion.modes.offboard import SLOWEST_S
from companion.modes.parts.offboard_target import OffboardTarget
from companion.supervisor.requests import Requests


class Guided:
    """Remembers since which choice the boat waits, and when the last setpoint came meanwhile. Another choice by a
    person, another mode and disarming end the waiting.

    Also since which choice of a mode it is `shown`: go-tos leave that as it is, as on a Rover."""

    def __init__(self, requests: Requests) -> None:
        self._requests = requests
        self._parts = requests.parts
        self._since: tuple[int, int] | None = None
        self._shown: tuple[int, int] | None = None
        self._came_s = -math.inf
        self._streams = False

    def choose(self, now_s: float) -> Outcome:
        """Hold, and wait for a setpoint."""
        outcome = self._requests.request_mode(ModeId.HOLD, now_s)
        if outcome.accepted:
            self._since, self._came_s, self._streams = self._choice, -math.inf, False
            self._shown = self._choice_of_mode
        return outcome

    def goes_to(self, target: OffboardTarget, now_s: float) -> bool:
        """Whether this setpoint is a go-to, which is done then. The second within OFFB_TIMEOUT makes a stream; within
        SLOWEST_S where it is more than a point."""
        self._streams = False
        if self._since != self._choice:
            return False
        timeout_s = self._parts.parameters["OFFB_TIMEOUT"]
        self._streams = now_s - self._came_s <= (timeout_s if target.is_point else max(timeout_s, SLOWEST_S))
        self._came_s = now_s
        point = None if self._streams or not target.is_point else target.fixed(self._parts.nav)
        if point is None or point.position is None:
            return False
        lat_deg, lon_deg = self._parts.frame_of().to_geodetic(*point.position)
        if self._requests.go_to(lat_deg, lon_deg, point.yaw_rad, None, now_s).accepted:
            self._since = self._choice
        return True

    def go(self, lat_deg: float, lon_deg: float, now_s: float) -> Outcome:
        """A point that a client sends for Guided, in degrees: a go-to, also from Offboard. It needs Guided, as on a
        Rover."""
        if not self.shown and self._parts.helm.mode.id is not ModeId.OFFBOARD:
            text = "Go-to refused: choose Guided first"
            self._parts.events.say(now_s, TextKind.REFUSAL, "refused", text)
            return Outcome(Result.TEMPORARILY_REJECTED, text)
        outcome = self._requests.go_to(lat_deg, lon_deg, None, None, now_s)
        if outcome.accepted:
            self._since, self._shown, self._streams = self._choice, self._choice_of_mode, False
        return outcome

    def taken(self, now_s: float) -> None:
        """The setpoint is valid: a stream of them begins Offboard. Where that is refused, the waiting ends."""
        if self._streams:
            self._since, self._streams = None, False
            self._requests.request_mode(ModeId.OFFBOARD, now_s)

    @property
    def shown(self) -> bool:
        """Whether the mode is Hold because Guided was chosen last."""
        return self._shown is not None and self._shown == self._choice_of_mode

    @property
    def _choice_of_mode(self) -> tuple[int, int]:
        choices, version = self._choice
        return choices - self._parts.go_tos, version

    @property
    def _choice(self) -> tuple[int, int]:
        """The last choice by a person, and the last change of mode; to arm changes nothing."""
        helm = self._parts.helm
        return self._parts.choices, helm.version + (0 if helm.armed else 1)
