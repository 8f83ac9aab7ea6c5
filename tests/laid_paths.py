"""What paths a vessel lays under way."""

from __future__ import annotations

from typing import Any

import pytest

from companion.guidance.path_tracking import PathTracker, Waypoint


def followers_started(monkeypatch: pytest.MonkeyPatch) -> list[tuple[PathTracker, list[Waypoint]]]:
    """A list that grows with each path that is laid from now on: who follows it, and its waypoints."""
    found: list[tuple[PathTracker, list[Waypoint]]] = []
    start = PathTracker.start

    def noted(self: PathTracker, waypoints: Any, *arguments: Any, **more: Any) -> None:
        found.append((self, list(waypoints)))
        start(self, waypoints, *arguments, **more)

    monkeypatch.setattr(PathTracker, "start", noted)
    return found
