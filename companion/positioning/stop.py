"""Where a boat without sideways thrust holds after it was under way: where it has come to rest."""

from __future__ import annotations

import math

from companion.core.estimate import NavState


class Stop:
    """`begin`, then `place` every tick until it gives the point to hold.

    How soon a boat stops depends on its thrusters, wind and current. A point planned further ahead would have to be
    sailed to afterwards. Where the boat does not rest before the planned point, that is held: a fence may lie behind
    it. One that can brake, and is still faster than it turns back at, brakes first: in the turn it would sail on.

    Remembers where the stop began, the planned point, how fast the boat may turn back, and whether it is still
    stopping.
    """

    def __init__(self, rest_mps: float) -> None:
        """`rest_mps`: speed along the hull, over ground, that counts as rest."""
        self._rest_mps = rest_mps
        self._from = self._planned = (0.0, 0.0)
        self._turns_mps = math.inf
        self._lasts = False

    @property
    def lasts(self) -> bool:
        """Whether the boat has still to come to rest."""
        return self._lasts

    def begin(self, nav: NavState, planned: tuple[float, float], turns_mps: float = math.inf) -> None:
        """The boat is to stop. `planned`: (north_m, east_m) of the last point to do so. `turns_mps`: the highest speed
        along the hull at which it gives up to stop there, and turns; infinite where nothing brakes it."""
        self._from, self._planned, self._turns_mps = (nav.north_m, nav.east_m), planned, turns_mps
        self._lasts = abs(nav.surge_mps) > self._rest_mps

    def end(self) -> None:
        """Another point is held."""
        self._lasts = False

    def place(self, nav: NavState, carried_mps: float = 0.0) -> tuple[float, float] | None:
        """(north_m, east_m) to hold from now on; None until the boat rests. `carried_mps`: speed at which a stream
        carries the boat along its hull; it has no way of its own beyond that."""
        here = nav.north_m, nav.east_m
        past = math.dist(here, self._from) >= math.dist(self._planned, self._from)
        slow = min(0.0, carried_mps) - self._rest_mps <= nav.surge_mps <= self._rest_mps + max(0.0, carried_mps)
        if not slow and (not past or abs(nav.surge_mps) > self._turns_mps):
            return None
        self._lasts = False
        return self._planned if past else here
