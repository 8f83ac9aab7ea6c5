"""When one camera takes a picture: on request, by distance along the track, or by time."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class _Series:
    """Pictures at equal steps of way or time. `first`: from the start to the first one. `left`: how many; None: no end.
    `by_mission`: it runs only while a mission does. `next_at`: way or time of the next one; None before the start."""

    step: float
    first: float
    left: int | None
    by_mission: bool
    next_at: float | None = None


class CameraTrigger:
    """`update(way_m, speed_mps, now_s, dt_s, mission_runs)` once a tick → whether the camera takes a picture now.

    A picture by distance is taken in the tick that is nearest to its place, so it is off by at most half of what the
    boat sails in a tick, and the places of a series stay at whole steps from its first one. A camera that is not ready
    again leaves pictures of a series out (`left_out` counts them); one that was asked for singly comes later.

    Remembers the series, how it is switched, and when the last picture was taken.
    """

    def __init__(self, interval_s: float) -> None:
        """`interval_s`: shortest time between two pictures that the camera can do."""
        self._interval_s = interval_s
        self._distance: _Series | None = None
        self._time: _Series | None = None
        self._waiting = 0  # single pictures that are asked for
        self._last_s: float | None = None
        self._way_m = 0.0
        self._now_s = 0.0
        self.enabled, self.paused = True, False
        self.left_out = 0

    @property
    def runs(self) -> bool:
        """Whether a series is under way."""
        return self._distance is not None or self._time is not None

    def shoot(self) -> None:
        """One picture, as soon as the camera is ready."""
        self._waiting += 1

    def by_distance(self, spacing_m: float, by_mission: bool = False) -> None:
        """A picture every `spacing_m`, the first one after that way."""
        self._time = None
        self._distance = _Series(spacing_m, spacing_m, None, by_mission)

    def by_time(self, interval_s: float, count: int | None, by_mission: bool = False) -> None:
        """A picture now and every `interval_s`, at the camera's own pace where that is longer."""
        self._distance = None
        self._time = _Series(max(interval_s, self._interval_s), 0.0, count, by_mission)

    def stop(self, by_mission: bool = False) -> None:
        """No more of the series, nor of single pictures that wait. `by_mission`: only of a series that a mission
        began."""
        self._waiting = self._waiting if by_mission else 0
        if not by_mission or (self._distance is not None and self._distance.by_mission):
            self._distance = None
        if not by_mission or (self._time is not None and self._time.by_mission):
            self._time = None

    def update(self, way_m: float, speed_mps: float, now_s: float, dt_s: float, mission_runs: bool) -> bool:
        """Whether to take a picture in this tick."""
        made_m, past_s = way_m - self._way_m, now_s - self._now_s
        self._way_m, self._now_s = way_m, now_s
        on = self.enabled and not self.paused
        due = _due(self._distance, way_m, made_m, 0.5 * speed_mps * dt_s, on, mission_runs)
        due += _due(self._time, now_s, past_s, 0.5 * dt_s, on, mission_runs)
        if self._time is not None and self._time.left == 0:
            self._time = None
        if not (due or self._waiting):
            return False
        if self._last_s is not None and now_s - self._last_s < self._interval_s - 0.5 * dt_s:
            self.left_out += due
            return False
        self.left_out += max(0, due - 1)
        self._waiting -= 0 if due else 1
        self._last_s = now_s
        return True


def _due(series: _Series | None, at: float, passed: float, early: float, on: bool, mission_runs: bool) -> int:
    """How many pictures of a series are due at that way or time, `early` before it included. A series that stands still
    keeps what is left of its step."""
    if series is None:
        return 0
    if series.next_at is None:
        series.next_at = at + series.first
    elif not on or (series.by_mission and not mission_runs):
        series.next_at += passed
    if not on or (series.by_mission and not mission_runs):
        return 0
    count = 0
    while at + early >= series.next_at and series.left != 0:
        series.next_at += series.step
        series.left = None if series.left is None else series.left - 1
        count += 1
    return count
