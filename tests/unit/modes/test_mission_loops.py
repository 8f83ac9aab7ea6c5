"""Missions whose jumps lead nowhere: what the boat does and says a second is bounded."""

from __future__ import annotations

import math
from collections import Counter

import pytest

from companion.core.decision import MissionState
from companion.mission.itinerary import LONGEST_ROUTE
from companion.mission.plan import PlanItem
from tests.laid_paths import followers_started
from tests.unit.conftest import Boat
from tests.unit.modes.test_mission_mode import item, start

ENDLESS = item(177, 0.0, -1.0)
HERE = (0.0, 0.0)


def stay(boat: Boat, *params: float, command: int = 19) -> PlanItem:
    lat, lon = boat.point(*HERE)
    return item(command, *params, x=round(lat * 1e7), y=round(lon * 1e7), frame=3)


@pytest.mark.parametrize("loop", ["waypoint", "two waypoints", "stay", "delay"])
def test_a_loop_that_leads_nowhere_is_sailed_and_said_once_a_second(
    boat: Boat, loop: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two waypoints within their radius were said 1600 times a second."""
    laid = followers_started(monkeypatch)
    items = {
        "waypoint": {1: ENDLESS},
        "two waypoints": {2: ENDLESS},
        "stay": {0: stay(boat, 0.0, 0.0, 0.0, math.nan), 1: ENDLESS},
        "delay": {0: item(93, 0.0), 1: ENDLESS},
    }[loop]
    boat.upload(*([HERE, (0.5, 0.5)] if loop == "two waypoints" else [HERE]), commands=items)
    start(boat)
    boat.step(30.0)
    said = Counter(text for text in boat.texts() if text.startswith("Mission item"))
    assert said and max(said.values()) <= 31
    assert len(laid) <= 31
    assert boat.status.mission.reached <= 31 * (LONGEST_ROUTE if loop == "two waypoints" else 1)
    assert boat.status.mission.state is MissionState.ACTIVE and boat.away_m(*HERE) < 1.0


def test_a_waypoint_that_jumps_to_itself_keeps_the_boat_there(boat: Boat) -> None:
    boat.upload((20.0, 0.0), commands={1: ENDLESS})
    start(boat)
    boat.until(lambda: boat.status.mission.reached >= 1)
    before = boat.status.mission.reached
    for _ in range(30):
        boat.step(2.0)
        assert boat.away_m(20.0, 0.0) < 3.5
    assert 10 <= boat.status.mission.reached - before <= 61


def test_laps_of_items_that_take_their_time_do_not_wait(boat: Boat) -> None:
    boat.upload((30.0, 0.0), commands={0: item(93, 0.5), 1: item(177, 0.0, 9.0)})
    start(boat)
    begun_s = boat.now_s
    boat.until(lambda: boat.status.mission.reached == 10)
    assert boat.now_s - begun_s < 6.0
