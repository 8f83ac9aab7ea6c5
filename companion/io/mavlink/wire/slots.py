"""Which endpoint leaves a link whose slots are all taken when somebody new comes.

Heartbeats are cheap, and so is a port number: what counts is the address, and what an endpoint has asked for.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from companion.io.mavlink.wire.endpoint import Endpoint

MAX_PEERS = 16
IDLE_S = 10.0  # after which who has sent heartbeats alone makes room for a newcomer


class Slot(NamedTuple):
    """One endpoint, and the address from which it comes."""

    host: str
    endpoint: Endpoint


def to_leave(slots: Sequence[Slot], host: str, trusted: bool, now_s: float, timeout_s: float) -> Slot | None:
    """The endpoint that makes room for a newcomer from `host`; None: the newcomer has to wait.

    In this order: one that is gone, was never heard, or has been silent for `timeout_s`; of the address with most
    endpoints, if the newcomer's has fewer, the least useful; one that has sent nothing but heartbeats for IDLE_S. A
    `trusted` newcomer gets the place of the least useful endpoint that is not trusted.
    """
    silent = min(slots, key=lambda slot: _heard_s(slot.endpoint))
    if silent.endpoint.gone or now_s - _heard_s(silent.endpoint) >= timeout_s:
        return silent
    strangers = sorted((slot for slot in slots if not slot.endpoint.trusted), key=lambda slot: _use(slot.endpoint))
    if not strangers:
        return None
    counts = Counter(slot.host for slot in strangers)
    crowd, most = counts.most_common(1)[0]
    if most > 1 and most > counts[host]:
        return next(slot for slot in strangers if slot.host == crowd)
    least = strangers[0]
    if trusted or (least.endpoint.asked_s is None and now_s - _since_s(least.endpoint) >= IDLE_S):
        return least
    return None


def _heard_s(endpoint: Endpoint) -> float:
    return -math.inf if endpoint.last_heard_s is None else endpoint.last_heard_s


def _since_s(endpoint: Endpoint) -> float:
    return -math.inf if endpoint.first_heard_s is None else endpoint.first_heard_s


def _use(endpoint: Endpoint) -> tuple[float, float]:
    """Sorts the least useful first: by when it asked for something last, then by when it came."""
    return (-math.inf if endpoint.asked_s is None else endpoint.asked_s, _since_s(endpoint))
