"""Setpoints of another computer, from any ground station or component on any link."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.core.decision import TextKind
from companion.io.mavlink.services.offboard_codec import read_global, read_local
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel
from companion.modes.parts.offboard_target import OffboardTarget

_AGAIN_S = 5.0  # after which a sender that goes on is told another reason
_MOST_TOLD = 64


class OffboardService:
    """In: SET_POSITION_TARGET_LOCAL_NED, SET_POSITION_TARGET_GLOBAL_INT. Out: setpoints to the supervisor. Their sender
    gets a text why one is refused, since these messages have no acknowledgement. Remembers who was told when."""

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._told_s: dict[tuple[int, Endpoint], float] = {}
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: self._on_local,
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: self._on_global,
        }

    def update(self, now_s: float) -> None:
        """Nothing: the supervisor watches for setpoints that stop."""

    def _on_local(self, message: Any, peer: Peer, now_s: float) -> None:
        self._give(read_local(message), message, peer, now_s)

    def _on_global(self, message: Any, peer: Peer, now_s: float) -> None:
        self._give(read_global(message, self._vessel.frame), message, peer, now_s)

    def _give(self, target: OffboardTarget | str, message: Any, peer: Peer, now_s: float) -> None:
        if message.target_system != self._hub.system:  # a message to all moves no boat
            return
        guided = peer.endpoint.persona.offboard_may_wait
        reason = target if isinstance(target, str) else self._vessel.supervisor.offboard_setpoint(target, now_s, guided)
        if reason is None:
            return
        source = (peer.system, peer.endpoint)
        told_s = self._told_s.get(source)
        if told_s is not None and now_s - told_s < _AGAIN_S * self._hub.patience:
            return
        if told_s is None and len(self._told_s) >= _MOST_TOLD:
            del self._told_s[next(iter(self._told_s))]
        self._told_s[source] = now_s
        self._hub.say(peer, TextKind.REFUSAL, f"Setpoint refused: {reason}")
