"""How well a leader was followed, from the truth of both boats: gap by arc length, offset from the leader's track,
bends."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Column = NDArray[np.float64]

WAKE_M = 4.0
_ASTERN_M = 600.0  # length of the straight track assumed before the first point
_STEP_M = 0.25
# the nearest point is searched within this distance of the last one: other branches of the track do not count
_WINDOW_M = 15.0
# at a larger offset the whole recent track is searched; outside the wake too, for a part that is nearer by this
_LOST_M, _OTHER_SHARE = 20.0, 0.5
_RECALL_M = 400.0
_TURNING_RADPS = math.radians(2.0)
_ONE_BEND_S = 3.0
_AFTER_BEND_S = 10.0
_SETTLED_S = 20.0
_BEHIND_S = 10.0  # longest time by which a follower leaves a bend after the leader
_ONE_CROWDING_S = 3.0
_ASTERN_MPS = -0.2
_BACK_M, _BACK_S = 2.0, 2.0


@dataclass(frozen=True, slots=True)
class Bend:
    """A turn of the leader: its times, and its arc lengths on the leader's track."""

    begin_s: float
    end_s: float
    begin_m: float
    end_m: float


class LeaderTrack:
    """The leader's track as a polyline with arc length. It begins far astern of its first point, against `yaw_rad`."""

    def __init__(self, north_m: Column, east_m: Column, yaw_rad: float) -> None:
        import numpy as np

        keep = [0]
        for i in range(1, len(north_m)):
            if math.hypot(north_m[i] - north_m[keep[-1]], east_m[i] - east_m[keep[-1]]) >= _STEP_M:
                keep.append(i)
        self.north = np.concatenate([[north_m[0] - _ASTERN_M * math.cos(yaw_rad)], north_m[keep]])
        self.east = np.concatenate([[east_m[0] - _ASTERN_M * math.sin(yaw_rad)], east_m[keep]])
        self.arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(self.north), np.diff(self.east)))])

    def nearest(self, north_m: float, east_m: float, low_m: float, high_m: float) -> tuple[float, float, float]:
        """(arc length, offset to starboard, course there) of the track's point nearest to a place, between two arc
        lengths."""
        import numpy as np

        first = max(0, int(np.searchsorted(self.arc, low_m)) - 1)
        last = min(len(self.arc) - 1, max(first + 1, int(np.searchsorted(self.arc, high_m))))
        n, e = self.north[first:last], self.east[first:last]
        dn, de = self.north[first + 1 : last + 1] - n, self.east[first + 1 : last + 1] - e
        long = np.hypot(dn, de)
        along = ((north_m - n) * dn + (east_m - e) * de) / long
        along = np.clip(
            along, np.maximum(0.0, low_m - self.arc[first:last]), np.minimum(long, high_m - self.arc[first:last])
        )
        off_n, off_e = north_m - n - along * dn / long, east_m - e - along * de / long
        i = int(np.argmin(np.hypot(off_n, off_e)))
        side = math.copysign(1.0, dn[i] * off_e[i] - de[i] * off_n[i])
        return float(self.arc[first + i] + along[i]), side * math.hypot(off_n[i], off_e[i]), math.atan2(de[i], dn[i])


class Chase:
    """Both boats at the follower's ticks, from `from_s` on. Columns are numpy arrays, one value a tick.

    `gap_m` and `off_m` are the truth; `known_gap_m` and `known_off_m` are by the boat's own estimate and where it
    places the leader, which is what a law can hold; `receivers_gap_m` and `receivers_off_m` are by the leader's fixes.
    """

    def __init__(self, folder: Path, from_s: float = 0.0, leader: str = "leader") -> None:
        import numpy as np

        truth, other, ticks = (
            columns(folder / "truth.csv"),
            columns(folder / f"{leader}.csv"),
            columns(folder / "ticks.csv", "t_s", "north_m", "east_m"),
        )
        at = truth["t_s"] >= from_s
        t = self.t = truth["t_s"][at]
        self.north, self.east, self.yaw = truth["north_m"][at], truth["east_m"][at], np.unwrap(truth["yaw_rad"][at])
        self.speed = np.hypot(truth["surge_mps"], truth["sway_mps"])[at]
        self._error = ticks["north_m"][at] - self.north, ticks["east_m"][at] - self.east
        clock = other["t_s"]
        self.leader_north, self.leader_east = (
            np.interp(t, clock, other["north_m"]),
            np.interp(t, clock, other["east_m"]),
        )
        self.leader_yaw, self.leader_speed = (
            np.interp(t, clock, np.unwrap(other["yaw_rad"])),
            np.interp(t, clock, other["speed_mps"]),
        )
        self.leader_surge, self.leader_rate = (
            np.interp(t, clock, other["surge_mps"]),
            np.interp(t, clock, other["yaw_rate_radps"]),
        )
        fixes = [other[f"fix_{name}"] - other[name] for name in ("north_m", "east_m")]
        placed = [
            other.get(f"placed_{name}", np.full(len(clock), np.nan)) - other[name] for name in ("north_m", "east_m")
        ]
        self._receiver_error = tuple(np.interp(t, clock, error) for error in fixes)
        self._leader_error = tuple(
            np.interp(t, clock, np.where(np.isfinite(own), own, fix)) for own, fix in zip(placed, fixes, strict=True)
        )
        self.distance = np.hypot(self.north - self.leader_north, self.east - self.leader_east)
        self.track = LeaderTrack(self.leader_north, self.leader_east, float(self.leader_yaw[0]))
        step = np.hypot(np.diff(self.leader_north), np.diff(self.leader_east))
        self.leader_arc = _ASTERN_M + np.concatenate([[0.0], np.cumsum(step)])
        backing = np.flatnonzero(self.leader_surge < _ASTERN_MPS)
        self.ahead_until_s = float(t[backing[0]]) if len(backing) else math.inf  # arc length is meaningless after this

    @cached_property
    def along(self) -> tuple[Column, Column, Column]:
        """(arc length, offset to starboard, course of the track there) of the follower."""
        import numpy as np

        found: list[tuple[float, float, float]] = []
        arc = None
        for north, east, end in zip(self.north, self.east, self.leader_arc, strict=True):
            place = None if arc is None else self.track.nearest(north, east, arc - _WINDOW_M, min(end, arc + _WINDOW_M))
            if place is None or abs(place[1]) > WAKE_M:
                other = self.track.nearest(north, east, end - _RECALL_M, end)
                if place is None or abs(place[1]) > _LOST_M or abs(other[1]) < _OTHER_SHARE * abs(place[1]):
                    place = other
            arc = place[0]
            found.append(place)
        arcs, offsets, courses = np.array(found).T
        return arcs, offsets, np.unwrap(courses)

    @property
    def off_m(self) -> Column:
        """Offset from the leader's track, to starboard."""
        return self.along[1]

    @property
    def gap_m(self) -> Column:
        """Gap along the leader's track."""
        return self.leader_arc - self.along[0]

    @property
    def swing(self) -> Column:
        """Heading relative to the course of the track at the follower, in rad."""
        import numpy as np

        apart = self.yaw - self.along[2]
        return np.arctan2(np.sin(apart), np.cos(apart))

    @cached_property
    def passed(self) -> Column:
        """When the leader was at the follower's present place, as a fractional index of the columns."""
        import numpy as np

        return np.interp(self.along[0], self.leader_arc, np.arange(len(self.t)))

    @property
    def known_off_m(self) -> Column:
        """Offset from the leader's track as the boat knows it, to starboard."""
        return self._off_by(self._leader_error)

    @property
    def receivers_off_m(self) -> Column:
        """Offset from the leader's track by the positions of both boats, to starboard."""
        return self._off_by(self._receiver_error)

    @property
    def known_gap_m(self) -> Column:
        """Gap along the leader's track as the boat knows it."""
        return self._gap_by(self._leader_error)

    @property
    def receivers_gap_m(self) -> Column:
        """Gap along the leader's track by the positions of both boats."""
        return self._gap_by(self._receiver_error)

    def _off_by(self, leader_error: tuple[Column, ...]) -> Column:
        import numpy as np

        _, off, course = self.along
        rows = np.arange(len(self.t))
        north, east = (
            own - np.interp(self.passed, rows, theirs) for own, theirs in zip(self._error, leader_error, strict=True)
        )
        return off + east * np.cos(course) - north * np.sin(course)

    def _gap_by(self, leader_error: tuple[Column, ...]) -> Column:
        import numpy as np

        course, there = self.along[2], self.leader_yaw
        own = self._error[0] * np.cos(course) + self._error[1] * np.sin(course)
        theirs = leader_error[0] * np.cos(there) + leader_error[1] * np.sin(there)
        return self.gap_m + theirs - own

    @cached_property
    def bends(self) -> tuple[Bend, ...]:
        """Turns of the leader while it goes ahead; turns less than 3 s apart are one."""
        spans: list[list[int]] = []
        for i in range(len(self.t)):
            if abs(self.leader_rate[i]) < _TURNING_RADPS or self.leader_surge[i] < 0.5:
                continue
            if spans and self.t[i] - self.t[spans[-1][1]] < _ONE_BEND_S:
                spans[-1][1] = i
            else:
                spans.append([i, i])
        return tuple(
            Bend(float(self.t[a]), float(self.t[b]), float(self.leader_arc[a]), float(self.leader_arc[b]))
            for a, b in spans
            if b > a
        )

    @cached_property
    def through_s(self) -> tuple[float, ...]:
        """When the follower left each bend; infinite where it did not."""
        times = []
        for bend in self.bends:
            out = [t for t, arc in zip(self.t, self.along[0], strict=True) if t > bend.begin_s and arc >= bend.end_m]
            times.append(float(out[0]) if out else math.inf)
        return tuple(times)

    def crowdings(self, gap_m: float, least_m: float) -> tuple[tuple[float, float], ...]:
        """(begin, end) of each time in which the leader is within `least_m` of the place `gap_m` astern in its wake: it
        has turned back beside it, and no follower that keeps that distance can be in that place."""
        import numpy as np

        arc = self.leader_arc - gap_m
        north, east = (np.interp(arc, self.track.arc, each) for each in (self.track.north, self.track.east))
        near = np.hypot(north - self.leader_north, east - self.leader_east) < least_m
        spans: list[list[float]] = []
        for t in self.t[near]:
            if spans and t - spans[-1][1] < _ONE_CROWDING_S:
                spans[-1][1] = float(t)
            else:
                spans.append([float(t), float(t)])
        return tuple((begin_s, end_s) for begin_s, end_s in spans)

    def rejoins(self, gap_m: float, least_m: float) -> tuple[tuple[float, float, float], ...]:
        """(begin, end, how long after its end the follower is back in its place for 2 s) of each of `crowdings`;
        infinite where it is not before the next one."""
        spans = self.crowdings(gap_m, least_m)
        nexts = [*(begin_s for begin_s, _ in spans), math.inf][1:]
        good = self._in_place(gap_m)
        return tuple(
            (begin_s, end_s, self._good_after(good, end_s, next_s))
            for (begin_s, end_s), next_s in zip(spans, nexts, strict=True)
        )

    @property
    def in_bend(self) -> NDArray[np.bool_]:
        """True from the leader's turn until the follower has left it."""
        return self._any_bend(0.0)

    @property
    def on_straight(self) -> NDArray[np.bool_]:
        """True outside of bends and the 10 s after them."""
        return ~self._any_bend(_AFTER_BEND_S)

    def _any_bend(self, after_s: float) -> NDArray[np.bool_]:
        import numpy as np

        inside = np.zeros(len(self.t), dtype=bool)
        for bend, through_s in zip(self.bends, self.through_s, strict=True):
            inside |= (self.t >= bend.begin_s) & (self.t <= through_s + after_s)
        return inside

    def swing_after_bends(self) -> float:
        """The largest span of the heading, in rad, while the leader went straight: from 20 s after each of its turns to
        its next, or the end. NaN where it never went straight that long."""
        swings: list[float] = []
        ends = [*(bend.begin_s for bend in self.bends[1:]), float(self.t[-1])]
        for bend, end_s in zip(self.bends, ends, strict=False):  # no turn, no swing
            apart = (self.yaw - self.leader_yaw)[(self.t >= bend.end_s + _SETTLED_S) & (self.t < end_s)]
            if len(apart):
                swings.append(float(apart.max() - apart.min()))
        return max(swings, default=math.nan)

    def recovery_s(self, gap_m: float, least_m: float = 0.0) -> tuple[float, ...]:
        """Time after each bend until the known gap is within 2 m and the known offset within 4 m, for 2 s.

        Infinite where that does not happen before the next bend or the end. Omitted: bends too close to the end of the
        run, those that a follower in its place leaves when the leader turns again already, and those with `crowdings`.
        """
        times = []
        crowdings = self.crowdings(gap_m, least_m)
        good = self._in_place(gap_m)
        ends = [*(bend.begin_s for bend in self.bends[1:]), float(self.t[-1])]
        for bend, through_s, end_s in zip(self.bends, self.through_s, ends, strict=False):
            if min(through_s, bend.end_s + _BEHIND_S) + _AFTER_BEND_S > self.t[-1]:
                continue
            if any(bend.begin_s < end and begin < bend.end_s + _BEHIND_S for begin, end in crowdings):
                continue
            straight_to_m = self.leader_arc[self.t <= end_s].max() - gap_m
            if straight_to_m < bend.end_m + _BACK_S * self.leader_surge.max():
                continue
            times.append(self._good_after(good, through_s, end_s))
        return tuple(times)

    def _in_place(self, gap_m: float) -> NDArray[np.bool_]:
        """True where the known gap is within 2 m, and the known offset within 4 m."""
        good: NDArray[np.bool_] = (abs(self.known_gap_m - gap_m) <= _BACK_M) & (abs(self.known_off_m) <= WAKE_M)
        return good

    def _good_after(self, good: NDArray[np.bool_], from_s: float, to_s: float) -> float:
        since: float | None = None
        for t, ok in zip(self.t, good, strict=True):
            if not from_s <= t <= to_s:
                continue
            since = (float(t) if since is None else since) if ok else None
            if since is not None and t - since >= _BACK_S:
                return since - from_s
        return math.inf

    def circles(self) -> float:
        """Whole turns of the follower that the leader did not make."""
        apart = self.yaw - self.leader_yaw
        return float(math.floor((apart.max() - apart.min()) / math.tau + 1e-9))

    def position_error(self, bearing_rad: float, distance_m: float, known: bool = False) -> Column:
        """Distance from the follow position at that bearing and distance; `known`: as both boats' receivers give it."""
        import numpy as np

        angle = self.leader_yaw + bearing_rad
        north = self.north - self.leader_north - distance_m * np.cos(angle)
        east = self.east - self.leader_east - distance_m * np.sin(angle)
        if known:
            north, east = north + self._error[0] - self._leader_error[0], east + self._error[1] - self._leader_error[1]
        found: Column = np.hypot(north, east)
        return found


def rms(values: Column) -> float:
    """Root mean square; NaN of no values."""
    return math.sqrt(float((values * values).mean())) if len(values) else math.nan


def share(held: NDArray[np.bool_]) -> float:
    """Share of true values; NaN of no values."""
    return float(held.mean()) if len(held) else math.nan


def variation_1ps(folder: Path, column: str, full: float, from_s: float) -> float:
    """Total variation per second of a column of ticks.csv, as a share of `full`."""
    import numpy as np

    ticks = columns(folder / "ticks.csv", "t_s", column)
    at = ticks["t_s"] >= from_s
    t = ticks["t_s"][at]
    return float(np.abs(np.diff(ticks[column][at])).sum() / full / (t[-1] - t[0])) if len(t) > 1 else 0.0


def modes(folder: Path) -> list[tuple[float, str]]:
    """(time, mode) of each tick."""
    with (folder / "ticks.csv").open(encoding="utf-8") as file:
        return [(float(row["t_s"]), row["mode"]) for row in csv.DictReader(file)]


def columns(path: Path, *names: str) -> dict[str, Column]:
    """Columns of a log by name; without names all, which must be numbers. An empty cell is NaN."""
    import numpy as np

    with path.open(encoding="utf-8") as file:
        header = file.readline().strip().split(",")
        wanted = names or tuple(header)
        data = np.genfromtxt(file, delimiter=",", usecols=[header.index(name) for name in wanted], ndmin=2)
    return {name: data[:, i] for i, name in enumerate(wanted)}
