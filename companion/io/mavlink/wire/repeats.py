"""Refusals that would be said again and again to the same ground station."""

from __future__ import annotations

import weakref

from companion.core.decision import TextKind
from companion.io.mavlink.wire.endpoint import Endpoint

AGAIN_S = 30.0


class Repeats:
    """`says(endpoint, kind, text, now_s)`. Remembers the refusals of the last `again_s`, for each endpoint.

    By endpoint, because a STATUSTEXT has no addressee: whoever is behind an endpoint hears it.
    """

    def __init__(self, again_s: float = AGAIN_S) -> None:
        self._again_s = again_s
        self._said_s: weakref.WeakKeyDictionary[Endpoint, dict[str, float]] = weakref.WeakKeyDictionary()

    def says(self, endpoint: Endpoint, kind: TextKind, text: str, now_s: float) -> bool:
        """Whether the text is to be said there: always, but for a refusal that was said there a moment ago."""
        if kind not in (TextKind.REFUSAL, TextKind.HINT):
            return True
        before = self._said_s.get(endpoint, {})
        recent = {said: at_s for said, at_s in before.items() if now_s - at_s < self._again_s}
        new = text not in recent
        if new:
            recent[text] = now_s
        self._said_s[endpoint] = recent
        return new
