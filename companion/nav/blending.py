"""Several receivers at once, each by its weight, instead of the best one alone.

The filter weighs each fix by its variance. What it cannot know is the slow error of a receiver, metres of a plain fix:
with two receivers it would go to and fro between them, and step when one of them is lost. So each receiver has an
offset, from it to the mean of all by inverse variance, which is taken off its fixes. Where a receiver comes, goes or
changes its accuracy the offsets follow slowly. (ArduPilot blends receivers by the same weights, and absorbs their
offsets likewise: AP_GPS_Blended.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

_SMOOTH_S = 3.0  # of a receiver's distance from the estimate
_FOLLOW_S = 20.0  # time constant with which the offsets follow: a metre moves the boat by 5 cm/s at first
_FIRST_S = 1.0  # a new receiver is averaged that long before it counts
_ALIVE_S = 2.0


@dataclass(slots=True)
class _Receiver:
    """Smoothed distance from the estimate to its fixes, and the offset that is taken off them."""

    begun_s: float
    last_s: float
    north_m: float
    east_m: float
    variance_m2: float
    slow_sigma_m: float
    offset_north_m: float = 0.0
    offset_east_m: float = 0.0
    counts: bool = False

    def begin(self, t_s: float, north_m: float, east_m: float) -> None:
        """What it was off by is void: it is off by that."""
        self.begun_s = t_s
        self.north_m, self.east_m = self.offset_north_m, self.offset_east_m = north_m, east_m

    def see(self, t_s: float, north_m: float, east_m: float) -> None:
        known_s = t_s - self.begun_s
        share = (t_s - self.last_s) / min(_SMOOTH_S, max(known_s, 1e-3))
        share = min(1.0, max(0.0, share))
        self.north_m += share * (north_m - self.north_m)
        self.east_m += share * (east_m - self.east_m)
        self.last_s = t_s


class Offset:
    """What is taken off a fix, and one sigma of the slow error of the blended position."""

    __slots__ = ("east_m", "north_m", "slow_sigma_m")

    def __init__(self, north_m: float, east_m: float, slow_sigma_m: float) -> None:
        self.north_m, self.east_m, self.slow_sigma_m = north_m, east_m, slow_sigma_m


class ReceiverBlend:
    """Call `update` for each fix of each receiver that is trusted. Remembers the receivers of the last seconds."""

    def __init__(self) -> None:
        self._receivers: dict[str, _Receiver] = {}

    def clear(self) -> None:
        """Forget the offsets: the estimate has been set anew."""
        self._receivers.clear()

    def drop(self, source: str) -> None:
        """A receiver that is not trusted counts no longer."""
        self._receivers.pop(source, None)

    def update(
        self,
        source: str,
        t_s: float,
        off_m: tuple[float, float],
        sigma_m: float,
        slow_sigma_m: float,
        leads: bool,
        anew: bool = False,
    ) -> Offset | None:
        """The offset to take off a fix that is `off_m` (north, east) from the estimate, None while the receiver is new.
        `sigma_m`: of the fix on each axis, by which it is weighted; `slow_sigma_m`: of its slow error. `leads`: it is
        the receiver that would be used alone, from which blending begins. `anew`: its slow error is another one than at
        its last fix, as of another kind of fix: it begins where the boat is."""
        receivers, known = self._receivers, self._receivers.get(source)
        for name in [name for name, other in receivers.items() if t_s - other.last_s > _ALIVE_S]:
            del receivers[name]
        if known is None or t_s - known.last_s > _ALIVE_S:
            first = not receivers
            if first and not leads:
                return None
            known = receivers[source] = _Receiver(t_s, t_s, *off_m, sigma_m**2, slow_sigma_m, counts=first)
        dt_s = max(t_s - known.last_s, 0.0)
        if anew:
            known.begin(t_s, *off_m)
        known.see(t_s, *off_m)
        known.variance_m2, known.slow_sigma_m = sigma_m**2, slow_sigma_m
        if not known.counts:
            if t_s - known.begun_s < _FIRST_S:
                return None
            known.counts, known.offset_north_m, known.offset_east_m = True, known.north_m, known.east_m
        self._follow(known, dt_s)
        return Offset(known.offset_north_m, known.offset_east_m, self._slow_sigma_m())

    def _follow(self, known: _Receiver, dt_s: float) -> None:
        """Let an offset go towards the distance from the mean of all."""
        north, east = self._mean()
        share = dt_s / (dt_s + _FOLLOW_S)
        known.offset_north_m += share * (known.north_m - north - known.offset_north_m)
        known.offset_east_m += share * (known.east_m - east - known.offset_east_m)

    def _mean(self) -> tuple[float, float]:
        counting = [receiver for receiver in self._receivers.values() if receiver.counts]
        whole = sum(1.0 / receiver.variance_m2 for receiver in counting)
        return (
            sum(receiver.north_m / receiver.variance_m2 for receiver in counting) / whole,
            sum(receiver.east_m / receiver.variance_m2 for receiver in counting) / whole,
        )

    def _slow_sigma_m(self) -> float:
        """As if the slow errors were common to all (orbits and ionosphere are), with what is still to be absorbed."""
        counting = [receiver for receiver in self._receivers.values() if receiver.counts]
        whole = sum(1.0 / receiver.variance_m2 for receiver in counting)
        north = sum(receiver.offset_north_m / receiver.variance_m2 for receiver in counting) / whole
        east = sum(receiver.offset_east_m / receiver.variance_m2 for receiver in counting) / whole
        slow = sum(receiver.slow_sigma_m / receiver.variance_m2 for receiver in counting) / whole
        return math.hypot(slow, north, east)
