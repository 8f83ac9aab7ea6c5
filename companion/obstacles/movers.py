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
_WINDOW_S, _LEAST_S, _LEAST_LOOKS = 4.0, 2.0, 8
_MOVES_MPS, _RESTS_MPS = 0.35, 0.2
_SIGMAS = 4.0
_CORRELATED = 2.0  # by which the error of a slope is larger than for independent errors
_MOVED_M = 0.8  # least way within the window
_REST_S = 3.0
_FORGET_S, _FORGET_MOVING_S = 2.0, 4.0
_BEHIND = 0.6  # of its radius, the middle of a thing lies behind the middle of its hits
_MOST = 64


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
    """`take(hits, place, t_s, width_rad)` each scan, `contacts(now_s)` → those that move. Remembers at most 64 groups,
    each with its places of the last 4 s."""

    def __init__(self) -> None:
        self._tracks: list[_Track] = []
        self._next = 1

    def take(self, hits: Floats, place: tuple[float, float], t_s: float) -> None:
        """`hits`: circles of one scan in the order of its sectors, shape (n, 3). `place`: of the sensor."""
        groups = [_group(part, place) for part in _parts(hits)]
        free = [group for group in groups if group is not None]
        for track in self._tracks:
            gate_m = _GATE_M + _GATE_MPS * (t_s - track.t_s) + 0.5 * track.radius_m
            where = track.at(t_s)
            nearest = min(free, key=lambda g: math.dist(g[:2], where), default=None)
            if nearest is not None and math.dist(nearest[:2], where) <= gate_m:
                free.remove(nearest)
                _follow(track, nearest, t_s)
        for north_m, east_m, radius_m in free:
            if len(self._tracks) < _MOST:
                places = deque([(t_s, north_m, east_m)])
                self._tracks.append(_Track(self._next, places, radius_m, t_s=t_s))
                self._next += 1
        self.forget(t_s)

    def forget(self, now_s: float) -> None:
        """Forget groups not seen any more."""
        self._tracks = [
            track
            for track in self._tracks
            if now_s - track.t_s <= (_FORGET_MOVING_S if track.moving else _FORGET_S)
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


def _group(hits: Floats, place: tuple[float, float]) -> tuple[float, float, float] | None:
    """Middle and radius of a group; None for one that is too wide."""
    north, east = float(hits[:, 0].mean()), float(hits[:, 1].mean())
    radius_m = float((np.hypot(hits[:, 0] - north, hits[:, 1] - east) + hits[:, 2]).max())
    if 2.0 * radius_m > _WIDEST_M:
        return None
    away_m = math.dist((north, east), place)
    if away_m < 1e-6:
        return north, east, radius_m
    share = 1.0 + _BEHIND * radius_m / away_m
    return place[0] + share * (north - place[0]), place[1] + share * (east - place[1]), radius_m


def _follow(track: _Track, group: tuple[float, float, float], t_s: float) -> None:
    """Add the newest place, and judge whether it moves."""
    track.t_s = t_s
    track.radius_m += 0.2 * (group[2] - track.radius_m)
    track.places.append((t_s, group[0], group[1]))
    while t_s - track.places[0][0] > _WINDOW_S:
        track.places.popleft()
    if len(track.places) < _LEAST_LOOKS or t_s - track.places[0][0] < _LEAST_S:
        return
    north_mps, east_mps, error_mps = _slope(track.places)
    speed = math.hypot(north_mps, east_mps)
    way_m = speed * (t_s - track.places[0][0])
    if speed > max(_MOVES_MPS, _SIGMAS * error_mps) and way_m > _MOVED_M:
        track.moving, track.rested_s = True, t_s
    elif speed > _RESTS_MPS:
        track.rested_s = t_s if track.moving else track.rested_s
    elif t_s - track.rested_s > _REST_S:
        track.moving = False
    track.north_mps, track.east_mps = north_mps, east_mps


def _slope(places: Sequence[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Velocity north and east by least squares, and the error of it."""
    values = np.asarray(places)
    t = values[:, 0] - values[:, 0].mean()
    square = float(t @ t)
    slopes = t @ values[:, 1:] / square
    residual = values[:, 1:] - values[:, 1:].mean(axis=0) - t[:, None] * slopes
    error = math.sqrt(float((residual**2).sum()) / (2.0 * len(t) * square))
    return float(slopes[0]), float(slopes[1]), _CORRELATED * error
