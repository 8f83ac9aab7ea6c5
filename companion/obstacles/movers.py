"""Things that move, found in the scans of ranging sensors: groups of neighbouring hits, followed from scan to scan.

A group counts as moving when the straight line through its places of the last seconds says so clearly. Its middle is
taken behind the hits, as of a round thing: else the boat's own motion around a thing would look like a motion of it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from companion.core.estimate import Contact
from companion.obstacles.occupancy import Floats

_GAP_M = 1.5  # between neighbouring hits of one group, beyond the width of their sectors
_WIDEST_M = 15.0  # of a group that is followed: a quay does not move
_GATE_M, _GATE_MPS = 1.5, 3.0  # how far a group may be from where it is expected
_WINDOW_S, _LEAST_S, _LEAST_LOOKS = 8.0, 2.5, 8
_MOVES_MPS, _RESTS_MPS = 0.35, 0.2
_SIGMAS = 4.0
_CORRELATED = 2.0  # by which the error of a slope is larger than for independent errors
_MOVED_M, _MOVED_WIDTHS = 0.8, 1.2  # least way within the window, and in widths of a sector there
_STAYED_S = 3.0  # what moves has left a place so long after the time that it takes to pass it
_GROWN, _GROWN_M = 1.3, 0.4  # of its radius: so much wider from one scan to the next, it is seen as one with another
_REST_S = 3.0
_FORGET_S, _FORGET_MOVING_S = 2.0, 4.0
_SURE_SHARE = 0.9  # of the sensor's reach: beyond, a thing may go on unseen
_REST_M = 6.0
_LINE_M, _PIECES_M, _BESIDE_M, _BESIDE_SHARE = 2.0, 30.0, 0.6, 0.06  # of a quay that is seen in pieces
_BEHIND = 0.6  # of its radius, the middle of a thing lies behind the middle of its hits
_MOST = 64


@dataclass(frozen=True, slots=True)
class _Group:
    """Neighbouring hits of one scan. `width_m`: of a sector there. `age_s`: for how long there has been something.
    `whole`: nothing nearer hides a part of it."""

    place: tuple[float, float]
    radius_m: float
    width_m: float
    age_s: float
    whole: bool


@dataclass(slots=True)
class _Track:
    """One group. `places`: (t_s, north_m, east_m)."""

    number: int
    places: deque[tuple[float, float, float]]
    radius_m: float
    north_mps: float = 0.0
    east_mps: float = 0.0
    moving: bool = False
    rested_s: float = 0.0
    t_s: float = field(default=0.0)

    def at(self, t_s: float) -> tuple[float, float]:
        """Where it is expected."""
        last_s, north_m, east_m = self.places[-1]
        age_s = t_s - last_s if self.moving else 0.0
        return north_m + age_s * self.north_mps, east_m + age_s * self.east_mps


class Movers:
    """`take(hits, ages_s, place, most_m, t_s)` each scan, `contacts(now_s)` → those that move.

    Remembers at most 64 groups, each with its places of the last 8 s.
    """

    def __init__(self) -> None:
        self._tracks: list[_Track] = []
        self._next = 1

    def take(self, hits: Floats, ages_s: Floats, place: tuple[float, float], most_m: float, t_s: float) -> None:
        """`hits`: circles of one scan in the order of its sectors, shape (n, 3). `ages_s`: for how long there has been
        something at the place of each. `place`, `most_m`: where the sensor is, and how far it reaches."""
        parts = _parts(np.column_stack((hits, ages_s)))
        free = [group for i in range(len(parts)) if (group := _group(parts, i, place, most_m)) is not None]
        for track in self._tracks:
            gate_m = _GATE_M + _GATE_MPS * (t_s - track.t_s) + 0.5 * track.radius_m
            where = track.at(t_s)
            nearest = min(free, key=lambda g: math.dist(g.place, where), default=None)
            if nearest is not None and math.dist(nearest.place, where) <= gate_m:
                free.remove(nearest)
                _follow(track, nearest, t_s)
        for group in free:
            if len(self._tracks) < _MOST and group.whole:
                places = deque([(t_s, *group.place)])
                self._tracks.append(_Track(self._next, places, group.radius_m, t_s=t_s))
                self._next += 1
        self.forget(t_s)

    def forget(self, now_s: float) -> None:
        """Forget groups not seen any more."""
        self._tracks = [
            track for track in self._tracks if now_s - track.t_s <= (_FORGET_MOVING_S if track.moving else _FORGET_S)
        ]

    def contacts(self, now_s: float) -> list[Contact]:
        """Those that move, where they are now. Their numbers are negative: they have no MMSI."""
        found = []
        for track in self._tracks:
            if track.moving:
                north_m, east_m = track.at(now_s)
                found.append(
                    Contact(
                        -track.number,
                        f"mover {track.number}",
                        north_m,
                        east_m,
                        track.north_mps,
                        track.east_mps,
                        track.radius_m,
                        None,
                    )
                )
        return found


def _parts(hits: Floats) -> list[Floats]:
    """Hits in groups of neighbours; the last and the first sector are neighbours too."""
    if not len(hits):
        return []
    gaps = np.hypot(*np.diff(hits[:, :2], axis=0).T) if len(hits) > 1 else np.zeros(0)
    room = _GAP_M + hits[:-1, 2] + hits[1:, 2]
    parts = np.split(hits, np.nonzero(gaps > room)[0] + 1)
    if len(parts) > 1 and math.dist(parts[0][0, :2], parts[-1][-1, :2]) <= _GAP_M + parts[0][0, 2] + parts[-1][-1, 2]:
        parts = [np.concatenate((parts[-1], parts[0])), *parts[1:-1]]
    return parts


def _group(parts: Sequence[Floats], index: int, place: tuple[float, float], most_m: float) -> _Group | None:
    """One part of a scan; None for one that is too wide. `most_m`: reach of the sensor."""
    hits = parts[index]
    north, east = float(hits[:, 0].mean()), float(hits[:, 1].mean())
    radius_m = float((np.hypot(hits[:, 0] - north, hits[:, 1] - east) + hits[:, 2]).max())
    away_m = math.dist((north, east), place)
    if 2.0 * radius_m > _WIDEST_M or away_m < 1e-6:
        return None
    share = 1.0 + _BEHIND * radius_m / away_m
    middle = place[0] + share * (north - place[0]), place[1] + share * (east - place[1])
    width_m = 2.0 * float(hits[:, 2].mean())
    hidden = any(
        _adjoins(end, there, place, width_m, math.dist(other[0, :2], other[-1, :2]))
        for end, other in ((hits[0], parts[index - 1]), (hits[-1], parts[(index + 1) % len(parts)]))
        if other is not hits
        for there in (other[0], other[-1])
    ) or any(
        _continues(hits, other) or _continues(_face(ends), other)
        for ends, other in ((hits, parts[index - 1]), (hits[::-1], parts[(index + 1) % len(parts)]))
        if other is not hits
    )
    cut = float(np.hypot(hits[:, 0] - place[0], hits[:, 1] - place[1]).max()) > _SURE_SHARE * most_m
    return _Group(middle, radius_m, width_m, float(np.median(hits[:, 3])), not hidden and not cut)


def _face(hits: Floats) -> Floats:
    """The first hits of a group as far as they make a face: a quay seen round its corner has two."""
    off = np.hypot(hits[:, 0] - hits[0, 0], hits[:, 1] - hits[0, 1])
    far = np.nonzero(off >= _LINE_M)[0]
    return hits[: far[0] + 1] if len(far) else hits[:1]


def _continues(hits: Floats, other: Floats) -> bool:
    """Whether another part of the scan lies on the straight line through long neighbouring hits: a quay is seen in
    pieces where it is seen along its face."""
    along = hits[-1, :2] - hits[0, :2]
    length_m = float(np.hypot(*along))
    if length_m < _LINE_M:
        return False
    off = other[:, :2] - hits[:, :2].mean(axis=0)
    beside = np.abs(off[:, 0] * along[1] - off[:, 1] * along[0]) / length_m
    away = np.hypot(off[:, 0], off[:, 1])
    return bool(np.any((away < _PIECES_M) & (beside < _BESIDE_M + _BESIDE_SHARE * away)))


def _adjoins(end: Floats, other: Floats, place: tuple[float, float], width_m: float, extent_m: float) -> bool:
    """Whether `other`, in the direction next to the end of a group, is nearer to the sensor and may hide a part of it,
    or is little further and may be the rest of it, as of a quay seen along its face. `extent_m`: of the other."""
    off, beyond_m = math.dist(end[:2], place), _REST_M if extent_m > _REST_M else 0.0
    if math.dist(other[:2], place) > off + beyond_m:
        return False
    turn = math.atan2(end[1] - place[1], end[0] - place[0]) - math.atan2(other[1] - place[1], other[0] - place[0])
    return abs(math.remainder(turn, math.tau)) * off < 2.0 * width_m


def _follow(track: _Track, group: _Group, t_s: float) -> None:
    """Add the newest place, and judge whether it moves."""
    track.t_s = t_s
    if not group.whole or _goes_on_unseen(track, group, t_s):
        return
    track.radius_m += 0.2 * (group.radius_m - track.radius_m)
    track.places.append((t_s, *group.place))
    while t_s - track.places[0][0] > _WINDOW_S:
        track.places.popleft()
    if len(track.places) >= _LEAST_LOOKS and t_s - track.places[0][0] >= _LEAST_S:
        _judge(track, group, t_s)


def _judge(track: _Track, group: _Group, t_s: float) -> None:
    """Whether it moves, by its places."""
    north_mps, east_mps, error_mps = _slope(track.places)
    speed = math.hypot(north_mps, east_mps)
    way_m = speed * (t_s - track.places[0][0])
    passes = _passes(group, track, speed)
    clearly = way_m > _MOVED_M + _MOVED_WIDTHS * group.width_m
    if speed > max(_MOVES_MPS, _SIGMAS * error_mps) and clearly and passes:
        track.moving, track.rested_s = True, t_s
    elif speed > _RESTS_MPS and passes:
        track.rested_s = t_s if track.moving else track.rested_s
    elif t_s - track.rested_s > _REST_S or not passes:
        track.moving = False
    track.north_mps, track.east_mps = north_mps, east_mps


def _passes(group: _Group, track: _Track, speed_mps: float) -> bool:
    """Whether nothing has been at the place of a group for longer than what moves takes to pass it."""
    return group.age_s < 2.0 * track.radius_m / max(speed_mps, 1e-3) + _STAYED_S


def _goes_on_unseen(track: _Track, group: _Group, t_s: float) -> bool:
    """Whether what moves is seen as one with something else that it passes. For a while it is then taken to go on; else
    it would count as lying from the moment when it comes near to that. After that it has stopped there."""
    if not track.moving:
        return False
    grown = group.radius_m > _GROWN * track.radius_m + _GROWN_M
    if not grown and _passes(group, track, math.hypot(track.north_mps, track.east_mps)):
        return False
    if t_s - track.places[-1][0] <= _FORGET_MOVING_S:
        return True
    track.moving, track.radius_m = False, group.radius_m
    track.places.clear()
    return False


def _slope(places: Sequence[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Velocity north and east by least squares, and the error of it."""
    values = np.asarray(places)
    t = values[:, 0] - values[:, 0].mean()
    square = float(t @ t)
    slopes = t @ values[:, 1:] / square
    residual = values[:, 1:] - values[:, 1:].mean(axis=0) - t[:, None] * slopes
    error = math.sqrt(float((residual**2).sum()) / (2.0 * len(t) * square))
    return float(slopes[0]), float(slopes[1]), _CORRELATED * error
