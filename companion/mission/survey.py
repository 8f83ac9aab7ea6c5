"""What a mission does with cameras and gimbals: how many pictures, on how many transects, and what it needs aboard."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from companion.core.payload import PayloadPart
from companion.mission.commands import DESTINATIONS, PLACES, RULES, Role, name_of, stay_s
from companion.mission.cursor import Cursor
from companion.mission.payload import PASSED_ON, PICTURES
from companion.mission.plan import PlanItem
from companion.mission.tasks import Action, ByDistance, ByTime, StopPictures, TakePicture

_MOST_LEGS = 5000
_STRAIGHT_RAD = math.radians(10.0)  # legs that bend less are one line
_TURN_SHARE = 0.5  # of the longest line: shorter ones are turns, where the camera stays on in turns
_ALMOST = 1e-3  # of a step: a leg that is a hair too short has its last picture too


@dataclass(frozen=True, slots=True)
class Survey:
    """`transects`: lines that are sailed with the camera on. `spacings_m`, `intervals_s`: between pictures, each
    once. `pictures`: of one camera, at steady speed; `endless`: at least so many."""

    transects: int
    spacings_m: tuple[float, ...]
    intervals_s: tuple[float, ...]
    pictures: int
    endless: bool

    @property
    def text(self) -> str:
        """In one line, for people."""
        about = f"{'over' if self.endless else 'about'} {self.pictures} pictures"
        if not self.transects:
            return f"Mission: {about}"
        paces = [_between(self.spacings_m, "m")] if self.spacings_m else []
        paces += [_between(self.intervals_s, "s")] if self.intervals_s else []
        transects = f"{self.transects} transect{'s' if self.transects > 1 else ''}"
        return f"Survey: {transects}, every {' or '.join(paces)}, {about}"


@dataclass(slots=True)
class _Counting:
    """The boat on its way through the plan, with what its camera does."""

    spacing_m: float | None = None
    interval_s: float | None = None
    carried: float = 0.0  # way or time since the last picture
    course_rad: float | None = None  # of the line under way
    stretches: list[list[float]] = field(default_factory=list)  # with the camera on, each with the lengths of its lines
    pictures: int = 0
    spacings_m: set[float] = field(default_factory=set)
    intervals_s: set[float] = field(default_factory=set)

    def act(self, actions: Iterable[Action]) -> None:
        """The camera is told something."""
        for action in actions:
            match action:
                case TakePicture():
                    self.pictures += 1
                case ByDistance(spacing_m=spacing_m, at_once=at_once):
                    self._begin(spacing_m or None, None)
                    self.pictures += at_once
                case ByTime(interval_s=interval_s, count=None):
                    self._begin(None, max(interval_s, 1.0))
                    self.pictures += 1
                case ByTime(count=count):
                    self._begin(None, None)
                    self.pictures += count or 0
                case StopPictures():
                    self._begin(None, None)

    def _begin(self, spacing_m: float | None, interval_s: float | None) -> None:
        self.spacing_m, self.interval_s, self.carried, self.course_rad = spacing_m, interval_s, 0.0, None
        self.stretches.append([])
        self.spacings_m |= {spacing_m} if spacing_m else set()
        self.intervals_s |= {interval_s} if interval_s else set()

    def go(self, length_m: float, course_rad: float, duration_s: float) -> None:
        """A leg is sailed."""
        if self.spacing_m is None and self.interval_s is None:
            return
        if length_m > 0.0:
            lines = self.stretches[-1]
            if self.course_rad is None or abs(wrap_pi(course_rad - self.course_rad)) > _STRAIGHT_RAD:
                lines.append(0.0)
            lines[-1] += length_m
            self.course_rad = course_rad
        self._pass(length_m, duration_s)

    def _pass(self, length_m: float, duration_s: float) -> None:
        step, passed = (self.spacing_m, length_m) if self.spacing_m else (self.interval_s, duration_s)
        if step:
            taken = int((self.carried + passed) / step + _ALMOST)
            self.pictures += taken
            self.carried += passed - taken * step

    @property
    def transects(self) -> int:
        """A plan switches the camera off between transects, or leaves it on: then turns are told by their length."""
        sailed = [lines for lines in self.stretches if lines]
        if len(sailed) != 1:
            return len(sailed)
        return sum(length_m > _TURN_SHARE * max(sailed[0]) for length_m in sailed[0])

    def stay(self, duration_s: float) -> None:
        """The boat stays where it is."""
        if self.interval_s is not None:
            self._pass(0.0, duration_s)


def survey_of(items: Sequence[PlanItem], cruise_mps: float) -> Survey | None:
    """What the cameras do in the mission, with counted jumps; None if they do nothing. Bends are not counted, nor what
    comes before the first waypoint."""
    if not any(item.command in PICTURES for item in items):
        return None
    count, cursor, legs = _Counting(), Cursor(items, follow_endless=False), 0
    place: tuple[float, float] | None = None
    frame: LocalFrame | None = None
    count.act(cursor.settle())
    while (item := cursor.item) is not None and legs < _MOST_LEGS:
        legs += 1
        speed_mps = cursor.speed_mps or cruise_mps
        if item.command in PLACES:
            frame = frame or LocalFrame(item.lat_deg, item.lon_deg)
            target = frame.to_ned(item.lat_deg, item.lon_deg)
            if place is not None:
                length_m = math.dist(place, target)
                course_rad = math.atan2(target[1] - place[1], target[0] - place[0])
                count.go(length_m, course_rad, length_m / speed_mps)
            place = target
        held_s = stay_s(item) if item.command in DESTINATIONS else 0.0
        if held_s is None:
            break
        count.stay(held_s)
        count.act(cursor.advance())
    return Survey(
        count.transects,
        tuple(sorted(count.spacings_m)),
        tuple(sorted(count.intervals_s)),
        count.pictures,
        legs == _MOST_LEGS,
    )


def without_camera(items: Sequence[PlanItem]) -> str | None:
    """What is to be said of the items that take pictures where no camera is; None without such items."""
    mine = [item for item in items if item.command in PICTURES]
    return f"No camera for {_named(mine)}" if mine else None


def needs_part(items: Sequence[PlanItem], part: PayloadPart) -> str | None:
    """What is to be said of the items that are passed on to a camera or gimbal; None without such items."""
    mine = [item for item in items if item.command not in PICTURES and PASSED_ON.get(item.command) is part]
    return f"{_named(mine)}: needs a {part.value} on a link" if mine else None


def has_payload(items: Iterable[PlanItem]) -> bool:
    """Whether any item is for a camera or a gimbal."""
    return any(item.command in RULES and RULES[item.command].role is Role.PAYLOAD for item in items)


def _named(items: Sequence[PlanItem]) -> str:
    more = f" and {len(items) - 1} more" if len(items) > 1 else ""
    return f"{name_of(items[0].command)}, item {items[0].number}{more}"


def _between(values: Sequence[float], unit: str) -> str:
    least, most = values[0], values[-1]
    return f"{least:g} {unit}" if least == most else f"{least:g} to {most:g} {unit}"
