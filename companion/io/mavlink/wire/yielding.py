"""Who gives up a place at a service whose places are all taken: the one who made least use of it.

A request is cheap, and so is a system id. What counts is when a holder last got something done, from how many places
its endpoint holds, and whether it is trusted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TypeVar

from companion.io.mavlink.wire.endpoint import Endpoint

IDLE_S = 5.0  # without anything useful, after which a place goes to who asks for it

K = TypeVar("K")


def to_yield(
    holders: Mapping[K, tuple[Endpoint, float]], newcomer: Endpoint, now_s: float, idle_s: float = IDLE_S
) -> K | None:
    """The holder that makes room for `newcomer`; None: it has to wait. `holders`: the endpoint of each, and when it
    last got something done.

    In this order: one whose endpoint is gone; of the endpoint with most places, if the newcomer's has fewer by two at
    least, the least useful; one that is idle. A trusted newcomer gets the place of the least useful one that is not
    trusted.
    """
    ranked = sorted(holders, key=lambda key: holders[key][1])
    gone = next((key for key in ranked if holders[key][0].gone), None)
    if gone is not None or not ranked:
        return gone
    counts = Counter(id(endpoint) for endpoint, _ in holders.values())
    crowd, most = counts.most_common(1)[0]
    if most > counts[id(newcomer)] + 1:
        return next(key for key in ranked if id(holders[key][0]) == crowd)
    least = next((key for key in ranked if not holders[key][0].trusted), ranked[0])
    endpoint, used_s = holders[least]
    outranked = newcomer.trusted and not endpoint.trusted
    return least if outranked or now_s - used_s >= idle_s else None
