"""What paths a vessel lays under way."""

from __future__ import annotations

import pytest

from companion.core.estimate import NavState
from companion.guidance.path_laying import LaidTrack
from companion.guidance.path_tracking import PathTracker
from companion.guidance.waypoint import Waypoint


def followers_started(monkeypatch: pytest.MonkeyPatch) -> list[tuple[PathTracker, list[Waypoint]]]:
    """A list that grows with each path that is sailed from now on: who follows it, and its waypoints."""
    found: list[tuple[PathTracker, list[Waypoint]]] = []
    take = PathTracker.take

    def noted(self: PathTracker, laid: LaidTrack, nav: NavState) -> None:
        found.append((self, list(laid.waypoints)))
        take(self, laid, nav)

    monkeypatch.setattr(PathTracker, "take", noted)
    return found
