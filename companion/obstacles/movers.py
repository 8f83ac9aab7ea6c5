"""Things that move, found in the scans of ranging sensors: groups of neighbouring hits, followed from scan to scan.

A group counts as moving when the straight line through its places of the last seconds says so clearly. Its middle is
taken behind the hits, as of a round thing: else the boat's own motion around a thing would look like a motion of it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from companion.core.estimate import Contact
from companion.obstacles.occupancy import Floats

_GAP_M = 1.5  # between neighbouring hits of one group, beyond the width of their sectors
_WIDEST_M = 15.0  # of a group that is followed: a quay does not move
_GATE_M, _GATE_MPS, _REST_GATE_MPS = 1.5, 3.0, 1.0  # how far a group may be from where it is expected
_COAST_GATE_MPS, _COAST_GATE_M = 0.3, 3.0  # the same beyond `_GATE_M`, of what moves and is not seen by itself
_WINDOW_S, _LEAST_S, _LEAST_LOOKS = 8.0, 2.5, 8
_MOVES_MPS, _RESTS_MPS = 0.35, 0.2
_SIGMAS = 4.0
_CORRELATED = 2.0  # by which the error of a slope is larger than for independent errors
_MOVED_M, _MOVED_WIDTHS = 0.8, 1.2  # least way within the window, and in widths of a sector there
_STAYED_S = 3.0  # what moves has left a place so long after the time that it takes to pass it
_GROWN, _GROWN_M = 1.3, 0.4  # of its radius: so much wider from one scan to the next, it is seen as one with another
_REST_S = 3.0
_FORGET_S, _FORGET_MOVING_S = 2.0, 4.0
_COASTS_S = 15.0  # what moves is taken to go on for so long while other things hide it or are seen as one with it
# From where it is expected, what is new there is a part of it; of that share of its radius, it tells where it is.
_TRACE_M, _TRACE_S, _PART = 1.0, 3.0, 0.6
_SURE_SHARE = 0.9  # of the sensor's reach: beyond, a thing may go on unseen
_REST_M = 6.0
_LINE_M, _PIECES_M, _BESIDE_M, _BESIDE_SHARE = 2.0, 30.0, 0.6, 0.06  # of a quay that is seen in pieces
_BENT = 0.1  # of its length, by which a face is no straight one
_BEHIND = 0.6  # of its radius, the middle of a thing lies behind the middle of its hits
_MOST = 64


@dataclass(frozen=True, slots=True)
class _Group:
    """Neighbouring hits of one scan. `width_m`: of a sector there. `age_s`: for how long there has been something.
    `whole`: nothing nearer hides a part of it. `numbers`: of the hits."""

    place: tuple[float, float]
    radius_m: float
    width_m: float
    age_s: float
    whole: bool
    numbers: frozenset[int]


@dataclass(slots=True)
class _Track:
    """One group. `places`: (t_s, north_m, east_m). `last`: where it was seen last, whole or not."""

    number: int
    places: deque[tuple[float, float, float]]
    radius_m: float
    last: tuple[float, float]
    north_mps: float = 0.0
    east_mps: float = 0.0
    moving: bool = False
    rested_s: float = 0.0
    t_s: float = field(default=0.0)

    def at(self, t_s: float) -> tuple[float, float]:
        """Where it is expected."""
        if not self.moving:
            return self.last
        last_s, north_m, east_m = self.places[-1]
        age_s = t_s - last_s
        return north_m + age_s * self.north_mps, east_m + age_s * self.east_mps

    def gate_m(self, t_s: float) -> float:
        """How far from there a group may be that is it."""
        if self.moving:
            return self._gate_m(min(_COAST_GATE_M, _COAST_GATE_MPS * (t_s - self.places[-1][0])))
        settled = t_s - self.places[0][0] >= _LEAST_S and len(self.places) >= _LEAST_LOOKS
        return self._gate_m((_REST_GATE_MPS if settled else _GATE_MPS) * (t_s - self.t_s))

    def _gate_m(self, more_m: float) -> float:
        return _GATE_M + more_m + 0.5 * self.radius_m

    @property
    def passing_s(self) -> float:
        """How long there is something at a place that it passes, at most."""
        return 2.0 * self.radius_m / max(math.hypot(self.north_mps, self.east_mps), 1e-3) + _STAYED_S


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
        seen: Floats = np.column_stack((hits, ages_s, np.arange(float(len(hits)))))
        parts = _parts(seen)
        groups = [group for i in range(len(parts)) if (group := _group(parts, i, place, most_m)) is not None]
        pairs = _pairs(self._tracks, groups, t_s)
        movers, others = [t for t in self._tracks if t.moving], [pair for pair in pairs if not pair[0].moving]
        for track, group in pairs:
            if track.moving:
                _follow(track, group, t_s)
        traces: set[int] = set()
        for track in movers:
            if track.places[-1][0] < t_s:
                traces |= _look_for(track, seen, place, t_s)
        for track, group in others:
            if traces.isdisjoint(group.numbers):
                _follow(track, group, t_s)
            else:  # seen as one with what moves
                track.t_s = t_s
        taken = {id(group) for _, group in pairs}
        self._begin([one for one in groups if id(one) not in taken and traces.isdisjoint(one.numbers)], t_s)
        self.forget(t_s)

    def _begin(self, groups: Sequence[_Group], t_s: float) -> None:
        for group in groups:
            if len(self._tracks) < _MOST and group.whole:
                places = deque([(t_s, *group.place)])
                self._tracks.append(_Track(self._next, places, group.radius_m, group.place, t_s=t_s))
                self._next += 1

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


def _pairs(tracks: Sequence[_Track], groups: Sequence[_Group], t_s: float) -> list[tuple[_Track, _Group]]:
    """Each track with the group that is it, the nearest pairs first: else a thing lost long ago, or a single false hit,
    takes the group of what passes."""
    near = []
    for i, track in enumerate(tracks):
        where, gate_m = track.at(t_s), track.gate_m(t_s)
        for k, group in enumerate(groups):
            off_m = math.dist(group.place, where)
            if off_m <= gate_m:
                near.append((off_m, i, k))
    found: dict[int, int] = {}
    for _, i, k in sorted(near):
        if i not in found and k not in found.values():
            found[i] = k
    return [(tracks[i], groups[k]) for i, k in found.items()]


def _look_for(track: _Track, seen: Floats, place: tuple[float, float], t_s: float) -> frozenset[int]:
    """Look for what moves where it is expected, as no group is it alone: what is new there is it, or a part of it.
    Where something hides that place it may go on unseen. `seen`: hits with their ages and numbers; `place`: of the
    sensor. Returns the numbers of the hits that are it."""
    if t_s - track.places[-1][0] > _COASTS_S:
        return frozenset()
    where = track.at(t_s)
    off = np.hypot(seen[:, 0] - where[0], seen[:, 1] - where[1])
    new_s = 0.5 * (track.passing_s + _TRACE_S - _STAYED_S)
    new = (off < track.radius_m + _TRACE_M + seen[:, 2]) & (seen[:, 3] < new_s)
    if new.any():
        track.t_s = t_s
        trace = _trace(seen[new], place)
        if _PART * track.radius_m <= trace.radius_m <= _GROWN * track.radius_m + _GROWN_M:
            _add(track, trace, t_s)
        return trace.numbers
    if _hides(seen, where, track.radius_m, place):
        track.t_s = t_s
    return frozenset()


def _hides(hits: Floats, where: tuple[float, float], radius_m: float, place: tuple[float, float]) -> bool:
    """Whether something stands in the line from the sensor to a thing at `where`, or just there."""
    away_m = max(1e-6, math.dist(where, place))
    along = (where[0] - place[0]) / away_m, (where[1] - place[1]) / away_m
    north, east = hits[:, 0] - place[0], hits[:, 1] - place[1]
    ahead, beside = along[0] * north + along[1] * east, np.abs(along[0] * east - along[1] * north)
    return bool(((ahead > 0.0) & (ahead < away_m + radius_m) & (beside < hits[:, 2])).any())


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
    found = _trace(hits, place)
    if 2.0 * found.radius_m > _WIDEST_M:
        return None
    width_m = found.width_m
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
    return replace(found, whole=not hidden and not cut)


def _trace(hits: Floats, place: tuple[float, float]) -> _Group:
    """Hits as one group; whether nothing hides a part of it is not known."""
    north, east = float(hits[:, 0].mean()), float(hits[:, 1].mean())
    radius_m = float((np.hypot(hits[:, 0] - north, hits[:, 1] - east) + hits[:, 2]).max())
    share = 1.0 + _BEHIND * radius_m / max(1e-6, math.dist((north, east), place))
    middle = place[0] + share * (north - place[0]), place[1] + share * (east - place[1])
    numbers = frozenset(hits[:, 4].astype(int).tolist())
    return _Group(middle, radius_m, 2.0 * float(hits[:, 2].mean()), float(np.median(hits[:, 3])), False, numbers)


def _face(hits: Floats) -> Floats:
    """The first hits of a group as far as they make a face: a quay seen round its corner has two."""
    off = np.hypot(hits[:, 0] - hits[0, 0], hits[:, 1] - hits[0, 1])
    far = np.nonzero(off >= _LINE_M)[0]
    return hits[: far[0] + 1] if len(far) else hits[:1]


def _continues(hits: Floats, other: Floats) -> bool:
    """Whether another part of the scan lies on the line through long neighbouring hits that are straight: a quay is
    seen in pieces where it is seen along its face. The face of a round thing is bent."""
    along = hits[-1, :2] - hits[0, :2]
    length_m = float(np.hypot(*along))
    if length_m < _LINE_M:
        return False
    bow = hits[:, :2] - hits[0, :2]
    if float(np.abs(bow[:, 0] * along[1] - bow[:, 1] * along[0]).max()) > _BENT * length_m**2:
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
    if track.moving and (not group.whole or _is_more(track, group)):
        _mind_standing(track, group, t_s)
        return
    track.t_s, track.last = t_s, group.place
    if group.whole:
        track.radius_m += 0.2 * (group.radius_m - track.radius_m)
        _add(track, group, t_s)


def _add(track: _Track, group: _Group, t_s: float) -> None:
    """A new place."""
    track.last = group.place
    track.places.append((t_s, *group.place))
    while t_s - track.places[0][0] > _WINDOW_S and len(track.places) > 1:
        track.places.popleft()
    if len(track.places) >= _LEAST_LOOKS and t_s - track.places[0][0] >= _LEAST_S:
        _judge(track, group, t_s)


def _judge(track: _Track, group: _Group, t_s: float) -> None:
    """Whether it moves, by its places."""
    north_mps, east_mps, error_mps = _slope(track.places)
    speed = math.hypot(north_mps, east_mps)
    way_m = speed * (t_s - track.places[0][0])
    passes = group.age_s < 2.0 * track.radius_m / max(speed, 1e-3) + _STAYED_S
    clearly = way_m > _MOVED_M + _MOVED_WIDTHS * group.width_m
    if speed > max(_MOVES_MPS, _SIGMAS * error_mps) and clearly and passes:
        track.moving, track.rested_s = True, t_s
    elif speed > _RESTS_MPS and passes:
        track.rested_s = t_s if track.moving else track.rested_s
    elif t_s - track.rested_s > _REST_S or not passes:
        track.moving = False
    track.north_mps, track.east_mps = north_mps, east_mps


def _is_more(track: _Track, group: _Group) -> bool:
    """Whether what moves is seen as one with something else that it passes. It is then taken to go on; else it would
    count as lying from the moment when it comes near to that."""
    return group.radius_m > _GROWN * track.radius_m + _GROWN_M or group.age_s >= track.passing_s


def _mind_standing(track: _Track, group: _Group, t_s: float) -> None:
    """What has not been seen to go on for a while has stopped, there where it is seen as one with something else."""
    if t_s - track.t_s > _FORGET_MOVING_S and group.whole:
        track.moving, track.radius_m, track.t_s, track.last = False, group.radius_m, t_s, group.place
        track.places = deque([(t_s, *group.place)])


def _slope(places: Sequence[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Velocity north and east by least squares, and the error of it."""
    values = np.asarray(places)
    t = values[:, 0] - values[:, 0].mean()
    square = float(t @ t)
    slopes = t @ values[:, 1:] / square
    residual = values[:, 1:] - values[:, 1:].mean(axis=0) - t[:, None] * slopes
    error = math.sqrt(float((residual**2).sum()) / (2.0 * len(t) * square))
    return float(slopes[0]), float(slopes[1]), _CORRELATED * error
