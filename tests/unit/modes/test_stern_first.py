"""Missions stern first, by item and by command."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.config.vessel import find, load
from companion.core.decision import MissionState, ModeId, Result
from companion.core.setpoint import PathSetpoint
from companion.mission.plan import PlanItem
from tests.unit.conftest import Boat

ASTERN, AHEAD = (PlanItem(0, 194, 2, way, 0.0, 0.0, 0.0, 0, 0, 0.0) for way in (1.0, 0.0))


def start(boat: Boat) -> None:
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()


def path(boat: Boat) -> PathSetpoint:
    assert isinstance(boat.setpoint, PathSetpoint)
    return boat.setpoint


def off_deg(boat: Boat, bow_deg: float) -> float:
    return abs(math.remainder(math.degrees(boat.nav.yaw_rad) - bow_deg, 360.0))


@pytest.mark.parametrize(("vessel", "effort"), [("revolt", 0.0), ("revolt", 0.2), ("otter", 0.0)])
def test_the_legs_after_the_item_are_sailed_stern_first(
    make_boat: Callable[..., Boat], vessel: str, effort: float
) -> None:
    boat = make_boat(load(find(vessel)), PATH_EFFORT=effort)
    boat.upload((20.0, 0.0), (0.0, 0.0), (0.0, 20.0), (20.0, 20.0), commands={1: ASTERN, 4: AHEAD})
    start(boat)
    boat.until(lambda: boat.status.mission.seq == 2)
    assert boat.away_m(20.0, 0.0) < 1.5 and abs(boat.nav.surge_mps) < 0.3, "at rest where it turns round"
    boat.until(lambda: boat.nav.north_m < 10.0)
    assert path(boat).surge_mps < -0.3 and off_deg(boat, 0.0) < 5.0
    assert boat.setpoint.progress.course_rad == pytest.approx(math.pi, abs=0.2)
    boat.until(lambda: boat.status.mission.seq == 3)
    boat.until(lambda: boat.nav.east_m > 12.0)
    assert path(boat).surge_mps < -0.3 and off_deg(boat, 270.0) < 10.0, "round a corner"
    boat.until(lambda: boat.nav.north_m > 10.0)
    assert path(boat).surge_mps > 0.3
    boat.until(lambda: boat.status.mission.state is MissionState.COMPLETE)
    assert boat.away_m(20.0, 20.0) < 1.5
    assert [text for name, text in boat.said if name == "stern_first"] == [
        "Mission: stern first",
        "Mission: bow first",
    ]


def test_no_faster_than_thrust_astern_allows(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(load(find("otter")), WP_SPEED=3.0, MPC_XY_VEL_MAX=3.0)
    boat.upload((70.0, 0.0), (0.0, 0.0), commands={1: ASTERN})
    start(boat)
    fastest = slowest = 0.0
    while boat.status.mission.state is MissionState.ACTIVE:
        boat.step()
        fastest, slowest = max(fastest, boat.nav.surge_mps), min(slowest, boat.nav.surge_mps)
    assert fastest > 2.2 and -1.9 < slowest < -1.2


def test_by_command_under_way_and_reset_by_another_mode(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat()
    reverse = boat.supervisor.sail_astern
    assert reverse(True, boat.now_s).result is Result.TEMPORARILY_REJECTED, "no mission under way"
    assert reverse(False, boat.now_s).accepted, "as always"
    boat.upload((60.0, 0.0), (60.0, 40.0))
    start(boat)
    boat.until(lambda: boat.nav.north_m > 8.0)
    assert reverse(True, boat.now_s).accepted and reverse(True, boat.now_s).accepted
    boat.until(lambda: boat.nav.north_m > 30.0)
    assert path(boat).surge_mps < -0.3 and off_deg(boat, 180.0) < 10.0
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step(5.0)
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    boat.until(lambda: boat.nav.north_m > 50.0)
    assert path(boat).surge_mps > 0.3
    assert boat.texts().count("Stern first refused: no mission under way") == 1


@pytest.mark.parametrize("vessel", ["rescuerunner"])
def test_a_boat_without_way_astern_refuses(make_boat: Callable[..., Boat], vessel: str) -> None:
    boat = make_boat(load(find(vessel)))
    boat.upload((200.0, 0.0))
    start(boat)
    outcome = boat.supervisor.sail_astern(True, boat.now_s)
    assert outcome.result is Result.DENIED and outcome.reason == "Stern first refused: this boat has no way astern"
    boat.step(5.0)
    assert path(boat).surge_mps > 0.0
