"""Arming by the transmitter's yaw stick, as ArduPilot's ARMING_RUDDER: held over for a while at no thrust."""

from __future__ import annotations

import math

from companion.core.estimate import NavState
from companion.core.readings import ManualInput
from companion.params.store import Parameters
from companion.params.transmitter import RUDDER_BOTH, RUDDER_OFF
from companion.supervisor.authority import RequestedAction
from companion.supervisor.helm import Helm
from companion.supervisor.sticks import is_centred

HELD_S = 2.0
_OVER = 0.9
_STILL_MPS = 0.3


class RudderArming:
    """`update(sticks, nav, now_s)` once a tick → ARM, DISARM or None. Only in modes that sticks steer.

    The stick must have been centred before, since the transmitter was last heard, and again after each gesture.
    Remembers that, and since when it has been held over to which side.
    """

    def __init__(self, parameters: Parameters, helm: Helm) -> None:
        self._parameters = parameters
        self._helm = helm
        self._centred = False
        self._side = 0
        self._since_s = 0.0

    def update(self, sticks: ManualInput | None, nav: NavState, now_s: float) -> RequestedAction | None:
        """`sticks`: the transmitter's; None while it is not heard."""
        wanted = int(self._parameters["ARMING_RUDDER"])
        if sticks is None or sticks.yaw is None or wanted == RUDDER_OFF:
            self._centred, self._side = False, 0
            return None
        if is_centred(sticks):
            self._centred = True
        side = int(math.copysign(1, sticks.yaw)) if abs(sticks.yaw) >= _OVER and _no_thrust(sticks) else 0
        if side != self._side or not self._centred or not self._helm.mode.by_stick:
            self._side, self._since_s = side, now_s
            return None
        if not side or now_s - self._since_s < HELD_S - 1e-9:
            return None
        self._centred = False
        if side > 0:
            return None if self._helm.armed else RequestedAction.ARM
        disarms = wanted == RUDDER_BOTH and self._helm.armed and _is_still(nav)
        return RequestedAction.DISARM if disarms else None


def _no_thrust(sticks: ManualInput) -> bool:
    return is_centred(ManualInput(sticks.t_s, sticks.source, sticks.surge, sticks.sway, None))


def _is_still(nav: NavState) -> bool:
    """At rest as far as is known: without a position the stick decides alone."""
    return not nav.position_valid or math.hypot(nav.north_mps, nav.east_mps) <= _STILL_MPS
