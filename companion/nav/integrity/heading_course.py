"""A fast boat does not point where it goes: the heading differs from the course by more than drift explains. A boat
that pushes astern may go stern first, or still ahead."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from companion.nav.integrity.evidence import Channel, Evidence, HeadingSeen, Hypothesis, LieFound, Sense

_SPEED_MPS = 3.0  # slower boats drift, and may go sideways or astern
_DRIFT_MPS = 0.7  # by wind and current, across the course
_LEAST_RAD = math.radians(10.0)
_WANDERS = 3.0
_LASTS_S = 8.0  # of straight course
_GAP_S, _FORGOTTEN_S = 2.5, 30.0  # between two headings that are compared: longer is no part of that; it begins anew
_TURN_RADPS = math.radians(5.0)  # in turns a boat slips
_MEASURED_S = 1.5  # age of the last velocity up to which the course is measured: dead reckoning drifts


@dataclass(slots=True)
class _Source:
    """Since when heading and course differ, and for how long a straight course has shown it."""

    since_s: float | None = None
    lasted_s: float = 0.0
    compared_s: float = -math.inf
    found: bool = False


class HeadingCourse(Hypothesis):
    """Remembers for each source since when it differs from the course, and when a velocity was last measured."""

    def __init__(self) -> None:
        self._sources: dict[str, _Source] = defaultdict(_Source)
        self._velocity_s = -math.inf

    def clear(self) -> None:
        """Begin anew."""
        self._sources.clear()

    def accept(self, channel: Channel) -> None:
        """The boat points where that source says, and goes elsewhere."""
        self._sources.pop(channel.source, None)

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Sources whose heading is not that of a boat on this course."""
        self.doubt = 0.0
        turning = evidence.inertial is None or abs(evidence.turn_radps) > _TURN_RADPS
        speed_mps = math.hypot(evidence.north_mps, evidence.east_mps)
        measured = self._is_measured(evidence, now_s)
        if evidence.driven and speed_mps >= _SPEED_MPS and measured and not turning:
            course_rad = math.atan2(evidence.east_mps, evidence.north_mps)
            explained_rad = _LEAST_RAD + math.asin(min(_DRIFT_MPS / speed_mps, 1.0))
            for seen in evidence.headings[-4:]:
                self._compare(seen, course_rad, explained_rad, evidence.astern)
        return [
            LieFound(Channel(Sense.HEADING, name), "is not on course", source.since_s, asks=True, widens=True)
            for name, source in self._sources.items()
            if source.found and source.since_s is not None
        ]

    def _is_measured(self, evidence: Evidence, now_s: float) -> bool:
        """Whether the course is that of a receiver. Where it is not, what has differed for less than it must begins
        anew."""
        for seen in evidence.velocities:
            if Channel(Sense.VELOCITY, seen.source) not in evidence.distrusted:
                self._velocity_s = seen.t_s
        measured = now_s - self._velocity_s <= _MEASURED_S
        if not measured:
            for source in self._sources.values():
                source.since_s = source.since_s if source.found else None
        return measured

    def _compare(self, seen: HeadingSeen, course_rad: float, explained_rad: float, astern: bool) -> None:
        source = self._sources[seen.source]
        off_rad = abs(wrap_pi(course_rad - seen.yaw_rad))
        if astern:
            off_rad = min(off_rad, math.pi - off_rad)
        passed_s, source.compared_s = seen.t_s - source.compared_s, seen.t_s
        if off_rad <= explained_rad + _WANDERS * seen.wander_rad:
            source.since_s, source.found = None, False
            return
        if source.since_s is None or (passed_s > _FORGOTTEN_S and not source.found):
            source.since_s, source.lasted_s = seen.t_s, 0.0
        elif passed_s <= _GAP_S:
            source.lasted_s += passed_s
        doubt = source.lasted_s / _LASTS_S
        self.doubt = max(self.doubt, min(doubt, 1.0))
        source.found = source.found or doubt >= 1.0
