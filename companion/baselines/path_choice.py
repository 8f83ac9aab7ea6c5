"""The choice of path tracking by WP_LAW: the companion's own, or the waypoint law of the ÅBOAT thesis. It may change
under way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from companion.baselines.waypoints import ThesisWaypoints
from companion.core.estimate import NavState
from companion.core.work import Submit, at_once
from companion.guidance.agility import Agility
from companion.guidance.path_laying import FromTrack, LaidTrack, Onward, TrackShape
from companion.guidance.path_tracking import PathProgress, PathTracker
from companion.guidance.sail_track import SailTrack
from companion.guidance.stern_first import turned, turned_back
from companion.guidance.turning import UNKNOWN, Turning
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters

_THESIS = 1


class ChosenPathTracker:
    """Same interface as `PathTracker`. A law that takes over under way sails the rest of the route from the boat.

    `astern`: the boat sails stern first, and `top_mps` and `agility` are those astern. `turning` as there. `sails`: the
    boat has a sail, and a law of its own. Remembers the law in use, the route, how many waypoints were passed before
    that law took over, and the way made. `took_over`: a law took over in the last update, so its line from the boat is
    new and has not been checked yet.
    """

    def __init__(
        self,
        parameters: Parameters,
        can_sway: bool,
        top_mps: float = math.inf,
        agility: Agility | None = None,
        submit: Submit = at_once,
        astern: bool = False,
        turning: Turning = UNKNOWN,
        sails: bool = False,
    ) -> None:
        self._parameters = parameters
        self._astern = astern
        self._own = PathTracker(parameters, can_sway, top_mps, agility, submit, turning)
        self._thesis = ThesisWaypoints(parameters)
        self._sail = SailTrack(parameters) if sails else None
        self._active = self._wanted()
        self._waypoints: tuple[Waypoint, ...] = ()
        self._stop_at_end = True
        self._before = self._passed = 0
        self._way_m = self._way_before_m = 0.0
        self.took_over = False

    def start(
        self,
        waypoints: Sequence[Waypoint],
        nav: NavState,
        stop_at_end: bool = True,
        from_here: bool = True,
        beyond: Sequence[Waypoint] = (),
    ) -> None:
        """As `PathTracker.start`."""
        self._active = self._wanted()
        self._remember(waypoints, stop_at_end)
        self._active.start(waypoints, self._facing(nav), stop_at_end, from_here, beyond)

    def replace(
        self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, beyond: Sequence[Waypoint] = ()
    ) -> None:
        """As `PathTracker.replace`."""
        self._remember(waypoints, stop_at_end)
        self._active.replace(waypoints, self._facing(nav), stop_at_end, beyond)

    def go_on(
        self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, beyond: Sequence[Waypoint] = ()
    ) -> None:
        """As `PathTracker.go_on`."""
        self._remember(waypoints, stop_at_end)
        self._active.go_on(waypoints, self._facing(nav), stop_at_end, beyond)

    @property
    def is_own(self) -> bool:
        """Whether the companion's own law sails the next route: tracks can be laid for it."""
        return self._wanted() is self._own

    def turns_against(self, resistance: float) -> None:
        """As `PathTracker.turns_against`."""
        self._own.turns_against(resistance)

    def shape(self, nav: NavState | None = None) -> TrackShape:
        """As `PathTracker.shape`."""
        return self._own.shape(nav)

    def from_track(self) -> FromTrack | None:
        """As `PathTracker.from_track`; None while the other law sails too."""
        return self._own.from_track() if self._active is self._own else None

    def onward(self) -> Onward | None:
        """As `PathTracker.onward`; None while the other law sails too."""
        return self._own.onward() if self._active is self._own else None

    def take(self, laid: LaidTrack, nav: NavState) -> None:
        """As `PathTracker.take`."""
        self._active = self._own
        self._remember(laid.waypoints, laid.stop_at_end)
        self._own.take(laid, self._facing(nav))

    def update(self, nav: NavState, speed_mps: float, dt_s: float) -> PathProgress:
        """As `PathTracker.update`."""
        wanted, nav = self._wanted(), self._facing(nav)
        self.took_over = wanted is not self._active and self._passed < len(self._waypoints)
        if self.took_over:
            self._active, self._before = wanted, self._passed
            wanted.start(self._waypoints[self._passed :], nav, self._stop_at_end)
        progress = self._active.update(nav, speed_mps, dt_s)
        if self.took_over:  # each law measures the way from a different place
            self._way_before_m = self._way_m - progress.way_m
        self._passed = self._before + progress.passed
        self._way_m = self._way_before_m + progress.way_m
        setpoint = turned_back(progress.setpoint) if self._astern else progress.setpoint
        return replace(progress, setpoint=setpoint, passed=self._passed, way_m=self._way_m)

    @property
    def legs(self) -> list[list[tuple[float, float]]]:
        """As `PathTracker.legs`."""
        return self._active.legs

    def _facing(self, nav: NavState) -> NavState:
        """The boat as the laws see it."""
        return turned(nav) if self._astern else nav

    def _remember(self, waypoints: Sequence[Waypoint], stop_at_end: bool) -> None:
        self._waypoints, self._stop_at_end = tuple(waypoints), stop_at_end
        self._before = self._passed = 0
        self._way_before_m = 0.0

    def _wanted(self) -> PathTracker | ThesisWaypoints | SailTrack:
        if self._sail is not None:
            return self._sail
        return self._thesis if self._parameters["WP_LAW"] == _THESIS else self._own
