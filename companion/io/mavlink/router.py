"""Between links: what others send to others. Source: MAVLink guide, "Routing".

A broadcast goes to all other links, an addressed packet where its target has been heard; untouched, signatures and all; never back to the link it came from.
Not where its sender has been heard too: who has two links to us needs no echo, and two routers no circle; what comes round by another way all the same is
known again. The key of signatures (SETUP_SIGNING) and the modem's own RADIO_STATUS stay where they came in (the latter as ArduPilot does).
"""

from __future__ import annotations

import weakref
from collections.abc import Iterable
from typing import Any

from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.endpoint import Endpoint
from companion.io.mavlink.guard import RADIO_STATUS
from companion.io.mavlink.link_options import Route

FORGET_S = 30.0  # addresses of who is silent
_AGAIN_S = 2.0  # within which the same bytes are the same packet: sequence numbers need longer to come round
_MOST_ADDRESSES, _MOST_PACKETS = 32, 1024
_LOCAL = frozenset({mavlink.MAVLINK_MSG_ID_SETUP_SIGNING, RADIO_STATUS})
_Address = tuple[int, int]  # system, component


class Router:
    """Remembers who was heard on each endpoint, and the packets of the last two seconds."""

    def __init__(self, own: _Address, patience: float = 1.0) -> None:
        """`own`: our address; `patience`: by what the others' time runs slower."""
        self._own = own
        self._forget_s = FORGET_S * patience
        self._heard: weakref.WeakKeyDictionary[Endpoint, dict[_Address, float]] = weakref.WeakKeyDictionary()
        self._recent: dict[bytes, float] = {}

    def take(self, message: Any, source: Endpoint, endpoints: Iterable[Endpoint], now_s: float) -> None:
        """Learn from a message that has been let in, and pass it on to those of `endpoints` that it is for."""
        number, sender = message.get_msgId(), (message.get_srcSystem(), message.get_srcComponent())
        if sender == self._own or number in _LOCAL:
            return
        self._learn(source, sender, now_s)
        target = _target(message)
        if source.guard.options.route is Route.NO or target == self._own:
            return
        others = [endpoint for endpoint in endpoints if self._is_for(endpoint, source, sender, target, now_s)]
        if not others:
            return
        data = bytes(message.get_msgbuf())
        if self._came_before(data, now_s):
            return
        urgent = target is not None or number == mavlink.MAVLINK_MSG_ID_HEARTBEAT
        for endpoint in others:
            endpoint.forward(data, urgent, now_s)

    def _is_for(self, endpoint: Endpoint, source: Endpoint, sender: _Address, target: _Address | None, now_s: float) -> bool:
        if endpoint.guard is source.guard or endpoint.guard.options.route is not Route.YES:
            return False
        heard = self._known(endpoint, now_s)
        if sender in heard:
            return False
        if target is None:
            return True
        system, component = target
        return target in heard if component else any(one == system for one, _ in heard)

    def _learn(self, endpoint: Endpoint, address: _Address, now_s: float) -> None:
        heard = self._heard.setdefault(endpoint, {})
        if address not in heard and len(heard) >= _MOST_ADDRESSES:
            del heard[min(heard, key=lambda one: heard[one])]
        heard[address] = now_s

    def _known(self, endpoint: Endpoint, now_s: float) -> dict[_Address, float]:
        heard = self._heard.get(endpoint, {})
        for address in [address for address, heard_s in heard.items() if now_s - heard_s > self._forget_s]:
            del heard[address]
        return heard

    def _came_before(self, data: bytes, now_s: float) -> bool:
        before_s = self._recent.pop(data, None)
        self._recent[data] = now_s
        if len(self._recent) > _MOST_PACKETS:
            del self._recent[next(iter(self._recent))]
        return before_s is not None and now_s - before_s <= _AGAIN_S


def _target(message: Any) -> _Address | None:
    """Whom a message is for, component 0 for all of a system; None: everybody."""
    system = getattr(message, "target_system", None)
    if system is None and message.get_msgId() == mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL:
        system = message.target
    return (system, getattr(message, "target_component", 0)) if system else None
