"""A person steers, and the receiver fails: how long the fence is kept, and what happens at its line."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.core.decision import ModeId
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, ThrusterSetpoint
from tests.unit.conftest import Boat
from tests.unit.fence.test_guard import armed_in, at, fence


def lost(boat: Boat, accuracy_m: float = 0.2, age_s: float = 5.0) -> None:
    """No position is measured; the last one is carried on to that accuracy."""
    boat.nav = replace(boat.nav, position_valid=False, position_accuracy_m=accuracy_m, position_age_s=age_s)


def found(boat: Boat) -> None:
    boat.nav = replace(boat.nav, position_valid=True, position_accuracy_m=0.02, position_age_s=0.0)


@pytest.mark.parametrize("unknown", [{"accuracy_m": 12.0}, {"age_s": 70.0}])
def test_where_the_place_is_not_known_the_fence_is_not_enforced_and_that_is_announced(
    boat: Boat, unknown: dict[str, float]
) -> None:
    fence(boat)
    lost(boat, **unknown)
    boat.step(1.0)
    assert "fence_blind" not in boat.names(), "disarmed, nothing is at stake"
    found(boat)
    armed_in(boat, ModeId.MANUAL)
    at(boat, 48.0, 0.0, north_mps=1.0)
    lost(boat, **unknown)
    boat.step(20.0)
    assert (
        boat.status.mode is ModeId.MANUAL
        and boat.names().count("fence_blind") == 1
        and "fence_seen" not in boat.names()
    )
    lost(boat)
    boat.step(1.0)
    assert boat.status.mode is ModeId.MANUAL, "once lost, the place is not known again until it is measured"
    at(boat, 0.0, 0.0)
    found(boat)
    boat.step(5.0)
    assert boat.names().count("fence_seen") == 1


def test_a_person_who_steers_without_a_position_is_stopped_where_dead_reckoning_puts_the_fence(boat: Boat) -> None:
    """With the stick full ahead and its receiver silent, an Otter sailed 111 m beyond its fence."""
    fence(boat)
    armed_in(boat, ModeId.MANUAL)
    lost(boat)
    boat.step(10.0)
    assert boat.status.mode is ModeId.MANUAL and boat.names().count("fence_reckoned") == 1
    at(boat, 48.0, 0.0, north_mps=1.0)
    lost(boat)
    boat.step(1.0)
    assert isinstance(boat.setpoint, NeutralSetpoint), "there is no position to hold"
    assert "Fence 2 m ahead: neutral" in boat.texts()
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    boat.step(20.0)
    assert isinstance(boat.setpoint, ThrusterSetpoint), "a mode chosen after that stands"


@pytest.mark.parametrize(("off_m", "stops"), [(26.0, True), (5.0, False)])
def test_a_person_who_steers_near_the_line_is_stopped_when_the_place_is_no_longer_known(
    boat: Boat, off_m: float, stops: bool
) -> None:
    """A Heron in Heading was slowed down by dead reckoning, then let go at full speed, 31 m beyond its fence."""
    fence(boat)
    armed_in(boat, ModeId.HEADING)
    for accuracy_m in (9.0, 11.0):
        at(boat, off_m, 0.0, north_mps=0.2)
        lost(boat, accuracy_m)
        boat.step()
    assert ("Fence near, position unknown: neutral" in boat.texts()) is stops
    assert isinstance(boat.setpoint, NeutralSetpoint) is stops
    assert boat.supervisor.request_mode(ModeId.HEADING, boat.now_s).accepted
    boat.step(5.0)
    assert not isinstance(boat.setpoint, NeutralSetpoint), "a person who chooses it again goes on"


def test_the_less_sure_the_place_is_the_sooner_heading_slows_down(boat: Boat) -> None:
    fence(boat)
    armed_in(boat, ModeId.HEADING)
    speeds = []
    for accuracy_m in (0.2, 2.0, 8.0):
        at(boat, 30.0, 0.0, north_mps=0.9)
        lost(boat, accuracy_m)
        boat.step()
        asked = PathSetpoint(0.0, 0.9)
        got = boat.fence_guard.limited(asked, boat.helm.mode, boat.nav, 0.9, boat.now_s)
        assert isinstance(got, PathSetpoint)
        speeds.append(got.surge_mps)
    assert speeds[0] == 0.9 and speeds[0] >= speeds[1] > speeds[2]


def test_an_invalid_position_changes_nothing(boat: Boat) -> None:
    fence(boat)
    armed_in(boat, ModeId.MANUAL)
    boat.nav = replace(boat.nav, position_valid=False, north_m=math.nan, east_m=math.nan)
    boat.step(1.0)
    assert boat.status.fence is not None and not boat.status.fence.breached and boat.status.mode is ModeId.MANUAL


@pytest.mark.parametrize("broken", [{"north_m": math.nan, "surge_mps": math.nan}, {"yaw_rad": math.inf}])
@pytest.mark.parametrize("known", [True, False])
def test_an_estimate_that_is_no_number_ends_no_run_within_a_fence(
    boat: Boat, broken: dict[str, float], known: bool
) -> None:
    """In Manual the place is reckoned on, and a course was asked of a heading that was infinite: the tick raised."""
    fence(boat)
    armed_in(boat, ModeId.MANUAL)
    at(boat, 40.0, 0.0, north_mps=1.0)
    boat.pinned = True
    boat.nav = replace(boat.nav, position_valid=known, **broken)
    boat.step(1.0)
    assert boat.status.mode is ModeId.MANUAL and ("north_m" in broken) == ("fence_blind" in boat.names())
