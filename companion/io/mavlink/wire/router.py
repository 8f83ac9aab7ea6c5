"""Forwarding: passes packets of other systems between links. Source: MAVLink guide, "Routing".

A broadcast goes to all other links. An addressed packet goes to the links on which its target was heard. Packets are
forwarded unchanged, signatures included.

A packet never goes back to its link, nor to a link on which its sender was heard: a system with two links to us needs
no echo, and two routers must not make a loop. A packet that still comes round another way is recognised and dropped.
SETUP_SIGNING (it has the key) and RADIO_STATUS (of the modem itself, as in ArduPilot) are never forwarded.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterable
from typing import Any

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.guard import RADIO_STATUS
from companion.io.mavlink.wire.link_options import Route

FORGET_S = 30.0  # of silence, after which an address is forgotten
_AGAIN_S = 2.0  # within it, the same bytes are the same packet: sequence numbers take longer to wrap
_MOST_ADDRESSES, _MOST_PACKETS = 32, 1024
_LOCAL = frozenset({mavlink.MAVLINK_MSG_ID_SETUP_SIGNING, RADIO_STATUS})
_Address = tuple[int, int]  # system, component


class Router:
    """Remembers who was heard on each endpoint, and the packets of the last two seconds."""

    def __init__(self, own: _Address, patience: float = 1.0) -> None:
        """`own`: our system and component. `patience`: factor on FORGET_S, where vessel time runs fast."""
        self._own = own
        self._forget_s = FORGET_S * patience
        self._heard: weakref.WeakKeyDictionary[Endpoint, dict[_Address, float]] = weakref.WeakKeyDictionary()
        self._recent: dict[bytes, float] = {}

    def take(self, message: Any, source: Endpoint, endpoints: Iterable[Endpoint], now_s: float) -> None:
        """Learn the sender of an admitted message, and forward the message to those of `endpoints` that it is for."""
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

    def _is_for(
        self, endpoint: Endpoint, source: Endpoint, sender: _Address, target: _Address | None, now_s: float
    ) -> bool:
        """Whether a packet from `source` is forwarded to `endpoint`."""
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
        """Note that `address` was heard there; when there are too many, the one silent longest is forgotten."""
        heard = self._heard.setdefault(endpoint, {})
        if address not in heard and len(heard) >= _MOST_ADDRESSES:
            del heard[min(heard, key=lambda one: heard[one])]
        heard[address] = now_s

    def _known(self, endpoint: Endpoint, now_s: float) -> dict[_Address, float]:
        """The addresses heard on the endpoint, each with when; silent ones are forgotten."""
        heard = self._heard.get(endpoint, {})
        for address in [address for address, heard_s in heard.items() if now_s - heard_s > self._forget_s]:
            del heard[address]
        return heard

    def _came_before(self, data: bytes, now_s: float) -> bool:
        """Whether the same packet came a moment ago; it is remembered."""
        before_s = self._recent.pop(data, None)
        self._recent[data] = now_s
        if len(self._recent) > _MOST_PACKETS:
            del self._recent[next(iter(self._recent))]
        return before_s is not None and now_s - before_s <= _AGAIN_S


def _target(message: Any) -> _Address | None:
    """The address that a message is for; component 0: all of that system. None: a broadcast."""
    system = getattr(message, "target_system", None)
    if system is None and message.get_msgId() == mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL:
        system = message.target
    return (system, getattr(message, "target_component", 0)) if system else None
