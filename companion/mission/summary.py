"""Length and duration of a mission."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from companion.core.angles import wrap_two_pi
from companion.core.geodesy import distance_and_bearing
from companion.mission.commands import (
    DESTINATIONS,
    PLACES,
    RULES,
    Command,
    Role,
    heading_rad,
    must_stay,
    name_of,
    stay_s,
)
from companion.mission.cursor import Cursor
from companion.mission.jumps import JUMPS, is_endless, target_of
from companion.mission.plan import PlanItem, item_number
from companion.mission.survey import Survey, survey_of
from companion.mission.tasks import SetHome

_MOST_LEGS = 100_000
_MOST_PLACES = 5


@dataclass(frozen=True, slots=True)
class Leg:
    """The way to item `seq` and the stay there. Length and course are None if the place before is not known."""

    seq: int
    command: int
    length_m: float | None
    course_rad: float | None
    speed_mps: float
    sailing_s: float
    hold_s: float


@dataclass(frozen=True, slots=True)
class Summary:
    """`length_m` and `time_s` are sums over `legs`, at steady speed, without bends, turns on the spot or weather.

    `waypoints`, `holds`, `jumps` and `ignored` count items, `items` all of them. `notes`: what the sums do not include.
    `survey`: what cameras do.
    """

    legs: tuple[Leg, ...]
    length_m: float
    time_s: float
    items: int
    waypoints: int
    holds: int
    jumps: int
    ignored: int
    notes: tuple[str, ...]
    survey: Survey | None = None


Place = tuple[float, float]
Measure = Callable[[float, float, float, float], tuple[float, float]]
"""(lat1_deg, lon1_deg, lat2_deg, lon2_deg) → (distance_m, bearing_rad)."""


@dataclass(slots=True)
class _Voyage:
    """State of the estimate: place of the boat, home, and the legs so far."""

    cruise_speed_mps: float
    place: Place | None
    home: Place | None
    measure: Measure
    most_speed_mps: float = math.inf
    most_astern_mps: float = math.inf
    astern: bool = False
    legs: list[Leg] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    lines: dict[tuple[Place, Place], tuple[float, float]] = field(default_factory=dict)  # laps sail the same legs again

    def sail(self, seq: int, command: int, target: Place | None, speed_mps: float | None, hold_s: float) -> None:
        """Add the leg to `target` and move there; without a target, only the time to hold."""
        most_mps = self.most_astern_mps if self.astern else math.inf
        speed = min(speed_mps or self.cruise_speed_mps, self.most_speed_mps, most_mps)
        if self.place is None or target is None:
            self.legs.append(Leg(seq, command, None, None, speed, 0.0, hold_s))
        else:
            line = (self.place, target)
            if line not in self.lines:
                self.lines[line] = self.measure(*self.place, *target)
            length_m, course_rad = self.lines[line]
            self.legs.append(Leg(seq, command, length_m, course_rad, speed, length_m / speed, hold_s))
        self.place = target or self.place


class Reckoning:
    """Sails a mission on paper, some legs at a time. `advance(most_legs)` until it returns True.

    Counted jumps, speed changes and holds are followed. Endless jumps are not taken; a stay for ever ends the mission.
    """

    def __init__(
        self,
        cursor: Cursor,
        cruise_speed_mps: float,
        start: Place | None,
        home: Place | None,
        measure: Measure = distance_and_bearing,
        most_speed_mps: float = math.inf,
        most_astern_mps: float = math.inf,
    ) -> None:
        """`cursor` is moved: it follows no endless jumps. `start`: where the boat is; `home`: where it returns to.
        `most_speed_mps` caps the speeds of the mission, `most_astern_mps` those of legs that are sailed stern first."""
        self._cursor = cursor
        self._voyage = _Voyage(cruise_speed_mps, start, home, measure, most_speed_mps, most_astern_mps)
        self.length_m = self.time_s = 0.0
        _move_home(self._voyage, cursor.settle())

    @property
    def legs(self) -> Sequence[Leg]:
        """The legs so far."""
        return self._voyage.legs

    @property
    def notes(self) -> list[str]:
        """What the sums do not include."""
        return self._voyage.notes

    def advance(self, most_legs: int) -> bool:
        """Sail so many legs more; returns whether the mission is at its end."""
        for _ in range(most_legs):
            item = self._cursor.item
            if item is None:
                return True
            if len(self.legs) == _MOST_LEGS:
                self.notes.append(f"only the first {_MOST_LEGS} legs are counted")
                return True
            self._voyage.astern = self._cursor.astern
            goes_on = _follow(self._voyage, item, self._cursor.speed_mps)
            self.length_m += self.legs[-1].length_m or 0.0
            self.time_s += self.legs[-1].sailing_s + self.legs[-1].hold_s
            if not goes_on:
                return True
            _move_home(self._voyage, self._cursor.advance())
        return self._cursor.item is None


def summarise(
    items: Sequence[PlanItem],
    cruise_speed_mps: float,
    home: tuple[float, float, float] | None = None,
    most_speed_mps: float = math.inf,
    most_astern_mps: float = math.inf,
    docks: bool = True,
) -> Summary:
    """The summary of `items` from `home` (lat_deg, lon_deg, altitude_m), with counted jumps, speed changes and holds.

    `most_speed_mps` caps the speeds that the mission sets, `most_astern_mps` those of legs that are sailed stern first.
    `docks`: whether the boat comes alongside at NAV_LAND; else it holds there. Lengths are geodesics on WGS 84. Endless
    jumps are not taken; a stay for ever ends the mission.
    """
    start = home[:2] if home is not None else None
    cursor = Cursor(items, follow_endless=False)
    voyage = Reckoning(cursor, cruise_speed_mps, start, start, distance_and_bearing, most_speed_mps, most_astern_mps)
    voyage.advance(_MOST_LEGS + 1)
    notes = [*voyage.notes, *_without_effect(items)]
    notes += [_landing(i, docks) for i in items if i.command == Command.NAV_LAND]
    notes += [
        f"item {i.number} hands over to Follow: the way until the mission is resumed is not counted"
        for i in items
        if i.command == Command.DO_FOLLOW
    ]
    notes += [
        f"item {i.number} jumps to item {(target_of(items, i) or 0) + 1} for ever: one lap is counted"
        for i in items
        if is_endless(i)
    ]
    return Summary(
        tuple(voyage.legs),
        voyage.length_m,
        voyage.time_s,
        len(items),
        sum(item.command in DESTINATIONS for item in items),
        sum(item.command in DESTINATIONS and must_stay(item) for item in items),
        sum(item.command in JUMPS for item in items),
        sum(item.command in RULES and RULES[item.command].role is Role.IGNORED for item in items),
        tuple(dict.fromkeys(notes)),
        survey_of(items, cruise_speed_mps),
    )


def first_leg(legs: Sequence[Leg]) -> Leg | None:
    """The way to the first place of the mission; None if there is none, or its length is not known."""
    leg = next((leg for leg in legs if leg.command in PLACES), None)
    return None if leg is None or leg.length_m is None else leg


def format_summary(summary: Summary) -> str:
    """A table for people, with one line for each leg, without a newline at the end."""
    lines = ["item  command               length m  course °  speed m/s   sails   holds"]
    for leg in summary.legs:
        length = f"{leg.length_m:8.1f}" if leg.length_m is not None else "       –"
        course = (
            f"{math.degrees(wrap_two_pi(leg.course_rad)):8.0f}"
            if leg.course_rad is not None and leg.length_m
            else "       –"
        )
        lines.append(
            f"{item_number(leg.seq):4d}  {name_of(leg.command):20.20s}  {length}  {course}  {leg.speed_mps:9.2f}"
            f"  {_clock(leg.sailing_s):>6s}  {_clock(leg.hold_s) if leg.hold_s else '–':>6s}"
        )
    lines.append(
        f"{summary.items} items: {summary.waypoints} waypoints, {summary.holds} of them with a stay; "
        f"{summary.jumps} jumps; {summary.ignored} without effect"
    )
    lines.append(f"length {summary.length_m:.1f} m, time {_clock(summary.time_s)}")
    if summary.survey is not None:
        lines.append(summary.survey.text)
    lines += [f"note: {note}" for note in summary.notes]
    return "\n".join(lines)


def _follow(voyage: _Voyage, item: PlanItem, speed_mps: float | None) -> bool:
    """Add the way to `item` and the stay there; False if the mission ends with it."""
    ends = item.command in DESTINATIONS and stay_s(item) is None
    if ends:
        voyage.notes.append(f"the boat stays at item {item.number} for ever")
    target, hold_s = _target_and_hold_s(voyage, item, speed_mps)
    voyage.sail(item.seq, item.command, target, speed_mps, hold_s)
    return not ends


def _target_and_hold_s(voyage: _Voyage, item: PlanItem, speed_mps: float | None) -> tuple[Place | None, float]:
    """Where the boat sails for `item`, and how long it stays there; a note for what does not count."""
    target, hold_s = voyage.place, 0.0
    if item.command in DESTINATIONS:
        target, hold_s = (item.x / 1e7, item.y / 1e7), _duration_s(stay_s(item) or 0.0)
    elif item.command == Command.NAV_LOITER_TURNS:
        target = (item.lat_deg, item.lon_deg)
        hold_s = _orbit_s(item, speed_mps or voyage.cruise_speed_mps)
        voyage.notes.append(
            f"item {item.number} goes round its point: the way counts to its centre, the turns as a stay"
        )
    elif item.command == Command.NAV_RETURN_TO_LAUNCH:
        target = voyage.home
        if target is None:
            voyage.notes.append(f"item {item.number} returns home, whose place the file does not give: not counted")
    elif item.command == Command.NAV_LAND:
        target = (item.lat_deg, item.lon_deg)
    elif item.command == Command.USER_5:
        voyage.notes.append(f"item {item.number} is a sea trial: not counted")
    elif item.command == Command.NAV_DELAY:
        hold_s = _delay_s(voyage, item)
    return target, hold_s


def _delay_s(voyage: _Voyage, item: PlanItem) -> float:
    """Duration of a wait; a note for one until a time of day."""
    if item.param1 < 0.0:
        voyage.notes.append(f"item {item.number} waits for a time of day: not counted")
    return _duration_s(item.param1)


def _orbit_s(item: PlanItem, speed_mps: float) -> float:
    """Duration of the turns; 0 if the radius is the vessel's."""
    return _duration_s(2.0 * math.pi * item.param1 * abs(item.param3) / speed_mps)


def _landing(item: PlanItem, docks: bool) -> str:
    if docks and heading_rad(item) is not None:
        return f"item {item.number} comes alongside: not counted"
    return f"item {item.number} holds there, and does not dock"


def _without_effect(items: Sequence[PlanItem]) -> list[str]:
    """A note for each command without effect, with the numbers of its items."""
    found: dict[int, list[int]] = {}
    for item in items:
        if item.command in RULES and RULES[item.command].role is Role.IGNORED:
            found.setdefault(item.command, []).append(item.number)
    notes = []
    for command, seqs in found.items():
        places = ", ".join(map(str, seqs[:_MOST_PLACES])) + (
            f" … {seqs[-1]}, {len(seqs)} in all" if len(seqs) > _MOST_PLACES else ""
        )
        notes.append(f"{name_of(command)} does nothing on this boat: item{'s' if len(seqs) > 1 else ''} {places}")
    return notes


def _move_home(voyage: _Voyage, actions: Sequence[object]) -> None:
    for action in actions:
        if isinstance(action, SetHome):
            lat_deg, lon_deg = action.lat_deg, action.lon_deg
            voyage.home = voyage.place if lat_deg is None or lon_deg is None else (lat_deg, lon_deg)


def _duration_s(value: float) -> float:
    """A valid duration, else 0: the plan may not be checked yet."""
    return value if 0.0 < value < math.inf else 0.0


def _clock(seconds: float) -> str:
    whole = round(seconds)
    hours, minutes = whole // 3600, whole // 60 % 60
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"
