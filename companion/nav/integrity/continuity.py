"""The steps of one source against those that the boat can have made: a sum of the steps that it cannot have made."""

from __future__ import annotations

import math

_LEAST_S = 0.4  # how long, and over how many samples, a step must last to be more than an outlier
_LEAST_SAMPLES = 3
_UNSTEADY_S, _UNSTEADY_SAMPLES = 3.0, 5  # the same for a source that goes on making impossible steps
_GONE_SHARE = 0.5  # of the bound: an outlier that has gone back so near to its track is none
_AGREES_S = 1.0  # how long a source must agree with the estimate again


class Continuity:
    """Call `take` for each sample. `suspect`: the source is off by an impossible step, so this sample cannot be used;
    `jumped`: that has lasted, so it is no outlier.

    Remembers the sum of the impossible steps, when it began, and since when the source agrees with the estimate again.
    """

    def __init__(self) -> None:
        self.north = self.east = 0.0
        self.since_s = math.inf
        self._settled_s = math.inf  # since when there was no further impossible step
        self._samples = self._all_samples = 0
        self._agrees_s = math.inf
        self._before = (0.0, 0.0)  # the last step of noise before the impossible one
        self._back = (0.0, 0.0)  # by what it has gone back in small steps, before it was judged
        self._t_s = -math.inf

    @property
    def suspect(self) -> bool:
        """Whether the source is off its own track."""
        return self.since_s < math.inf

    @property
    def jumped(self) -> bool:
        """Whether it has been for longer than an outlier lasts."""
        steady = self._samples >= _LEAST_SAMPLES and self._t_s - self._settled_s >= _LEAST_S
        unsteady = self._all_samples >= _UNSTEADY_SAMPLES and self._t_s - self.since_s >= _UNSTEADY_S
        return self.suspect and (steady or unsteady)

    @property
    def size(self) -> float:
        """How far it is off."""
        return math.hypot(self.north, self.east)

    def clear(self) -> None:
        """The source is believed: it is where it says."""
        self.north = self.east = 0.0
        self.since_s = self._settled_s = self._agrees_s = math.inf
        self._samples = self._all_samples = 0
        self._before = self._back = 0.0, 0.0

    def take(self, t_s: float, north: float, east: float, bound: float, excused: bool = False) -> None:
        """`north`, `east`: the source's step less the boat's; `bound`: up to which that is noise. `excused`: what the
        boat is told to have done is the larger of the two, so the step may be its sensor's: it begins no suspicion,
        but an outlier may go back by it. An outlier may come in a step of noise before, and go back in several."""
        undecided = self.suspect and not self.jumped
        returns = undecided and math.hypot(self.north + north, self.east + east) < self.size
        self._t_s = t_s
        self._all_samples += 1
        if math.hypot(north, east) <= bound or (excused and not returns):
            self._samples += 1
            if not self.suspect:
                self._before = north, east
            elif undecided and (returns or not excused):
                self._go_back(north, east, bound)
            return
        if not self.suspect and math.hypot(north + self._before[0], east + self._before[1]) <= _GONE_SHARE * bound:
            self._before = north, east
            return
        self.north += north
        self.east += east
        if self.size <= bound:
            self.clear()
            return
        if not self.suspect:
            self.since_s, self._all_samples, self._back = t_s, 1, self._before
        self._settled_s, self._samples = t_s, 1

    def _go_back(self, north: float, east: float, bound: float) -> None:
        """A small step of a source that is not yet judged."""
        self._back = self._back[0] + north, self._back[1] + east
        if math.hypot(self.north + self._back[0], self.east + self._back[1]) <= _GONE_SHARE * bound:
            self.clear()

    def place(self, t_s: float, north: float, east: float, bound: float) -> None:
        """After a gap: how far the source is from where the boat can be by dead reckoning."""
        self.clear()
        self._t_s = t_s
        if math.hypot(north, east) > bound:
            self.north, self.east = north, east
            self.since_s = self._settled_s = t_s
            self._samples = self._all_samples = 1

    def compare(self, t_s: float, off: float, bound: float) -> None:
        """`off`: the source less the estimate. A source that agrees for a second is believed again."""
        if not self.suspect or off > bound:
            self._agrees_s = math.inf
            return
        self._agrees_s = min(self._agrees_s, t_s)
        if t_s - self._agrees_s >= _AGREES_S:
            self.clear()
