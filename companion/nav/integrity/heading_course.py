"""A fast boat does not point where it goes: the heading differs from the course by more than drift explains. A boat
that pushes astern may go stern first, or still ahead.

On one course nobody can tell a compass that is off from a current across it: a boat at 4 m/s whose compass is 25° off
goes as one in 1.7 m/s of current. So that counts at once only where not even a tidal race explains it. A current stays
where it is when the boat turns round, and sets it off to the other side; what a compass is off by turns with the boat:
on opposite courses it goes off to the same side.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.core.angles import wrap_pi
from companion.nav.integrity.evidence import Channel, Evidence, HeadingSeen, Hypothesis, LieFound, Sense

_SPEED_MPS = 3.0  # slower boats drift, and may go sideways or astern
_DRIFT_MPS = 0.7  # by wind and waves, which may go with the boat when it turns
_RACE_MPS = 3.5  # of the strongest current that may set a boat off
_LEAST_RAD = math.radians(10.0)
_WANDERS = 3.0
_LASTS_S = 8.0  # of straight course
_GAP_S, _FORGOTTEN_S = 2.5, 30.0  # between two headings that are compared: longer is no part of that; it begins anew
_SECTOR_RAD, _OPPOSITE_RAD = math.radians(20.0), math.radians(150.0)  # of a leg; from one to another
_TIDE_S = 900.0  # up to which a leg counts: the current is another one then
_TURN_RADPS = math.radians(5.0)  # in turns a boat slips
_MEASURED_S = 1.5  # age of the last velocity up to which the course is measured: dead reckoning drifts


@dataclass(slots=True)
class _Leg:
    """A course on which the boat has gone off to one `side`: −1 port, 1 starboard."""

    side: float
    yaw_rad: float = 0.0
    lasted_s: float = 0.0
    t_s: float = 0.0


@dataclass(slots=True)
class _Source:
    """Since when heading and course differ, for how long a straight course has shown that by more than any current
    makes, and the legs on which they differ to the same side, by the sector of their heading."""

    since_s: float | None = None
    lasted_s: float = 0.0
    compared_s: float = -math.inf
    found: bool = False
    legs: dict[int, _Leg] = field(default_factory=dict)

    def agree(self) -> None:
        """Heading and course do not differ."""
        self.since_s, self.lasted_s, self.found = None, 0.0, False
        self.legs.clear()

    def go_off(self, seen: HeadingSeen, side: float, passed_s: float) -> float:
        """The boat goes off to that side for `passed_s` more. Returns for how long it has done so on this leg and on an
        opposite one."""
        for sector, leg in list(self.legs.items()):
            if leg.side != side or seen.t_s - leg.t_s > _TIDE_S:
                del self.legs[sector]
        here = self.legs.setdefault(int(seen.yaw_rad % math.tau / _SECTOR_RAD), _Leg(side))
        here.yaw_rad, here.t_s = seen.yaw_rad, seen.t_s
        here.lasted_s += passed_s
        return max(
            (
                min(here.lasted_s, leg.lasted_s)
                for leg in self.legs.values()
                if abs(wrap_pi(leg.yaw_rad - here.yaw_rad)) >= _OPPOSITE_RAD
            ),
            default=0.0,
        )


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
            for seen in evidence.headings[-4:]:
                self._compare(seen, course_rad, speed_mps, evidence.astern)
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

    def _compare(self, seen: HeadingSeen, course_rad: float, speed_mps: float, astern: bool) -> None:
        source = self._sources[seen.source]
        off_rad = wrap_pi(course_rad - seen.yaw_rad)
        if astern and abs(off_rad) > 0.5 * math.pi:
            off_rad = wrap_pi(off_rad + math.pi)
        passed_s, source.compared_s = seen.t_s - source.compared_s, seen.t_s
        beyond_rad = max(abs(off_rad) - _LEAST_RAD - _WANDERS * seen.wander_rad, 0.0)
        drift_mps = speed_mps * math.sin(min(beyond_rad, 0.5 * math.pi))  # that would explain it, at any speed ahead
        if drift_mps <= _DRIFT_MPS:
            source.agree()
            return
        if source.since_s is None or (passed_s > _FORGOTTEN_S and not source.found):
            source.since_s, source.lasted_s = seen.t_s, 0.0
        passed_s = passed_s if passed_s <= _GAP_S else 0.0
        source.lasted_s = source.lasted_s + passed_s if drift_mps > _RACE_MPS else 0.0
        lasted_s = max(source.lasted_s, source.go_off(seen, math.copysign(1.0, off_rad), passed_s))
        doubt = lasted_s / _LASTS_S
        self.doubt = max(self.doubt, min(doubt, 1.0))
        source.found = source.found or doubt >= 1.0
