"""Channels with a function of their own: what each does when its switch is moved."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

from companion.core.decision import ModeId
from companion.mission.plan import PlanItem, PlanKind, PlanRefusal, PlanResult
from companion.mission.tasks import SetRelay
from companion.params.transmitter import AUX_MODES, OPTIONS, RELAYS, AuxFunction
from companion.supervisor.cruise_learning import LEAST_S
from companion.supervisor.mode_changes import Cause
from companion.supervisor.rudder_arming import HELD_S
from tests.unit.conftest import Boat

OFF = (0.0, 0.0, 0.0, 0.0, -1.0, -1.0, -1.0, -1.0)
CHANNEL = "RC9_OPTION"
FENCE = ((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0))


def rc(boat: Boat, on: bool, hold_s: float = 0.5) -> None:
    """The switch on channel 9, held for that long."""
    boat.rc = (*OFF, 1.0 if on else -1.0)
    boat.step(hold_s)


def sticks(boat: Boat, yaw: float, hold_s: float, surge: float = 0.0) -> None:
    boat.rc = (0.0, surge, 0.0, yaw, -1.0, -1.0, -1.0, -1.0)
    boat.step(hold_s)


@pytest.fixture
def with_option(make_boat: Callable[..., Boat]) -> Callable[..., Boat]:
    def make(function: AuxFunction, **parameters: float) -> Boat:
        boat = make_boat(MAN_RC_SAFE_CH=0, **{CHANNEL: float(function)}, **parameters)
        rc(boat, False)
        return boat

    return make


def store(boat: Boat, refusal: PlanRefusal | None = None) -> int:
    """Put in force what the switch asks for, as the plans' store does; returns how many changes there were."""
    edits, count = boat.supervisor.mission_edits, 0
    while (items := edits.due()) is not None:
        assert edits.under_way and edits.due() is None, "one at a time"
        if refusal is None:
            boat.plans.replace(PlanKind.MISSION, items)
        edits.settled(refusal, boat.now_s)
        count += 1
    boat.step()
    return count


def fenced(boat: Boat) -> None:
    places = [boat.point(*corner) for corner in FENCE]
    items = [
        PlanItem(i, 5001, 3, len(FENCE), 0, 0, 0, round(lat * 1e7), round(lon * 1e7), 0)
        for i, (lat, lon) in enumerate(places)
    ]
    boat.plans.replace(PlanKind.FENCE, items)
    boat.step()


# --- the table -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("function", [f for f in AUX_MODES if f is not AuxFunction.FOLLOW], ids=lambda f: f.name)
def test_a_mode_function_chooses_its_mode_when_moved(with_option: Callable[..., Boat], function: AuxFunction) -> None:
    boat = with_option(function, RC_MAP_FLTMODE=8, COM_FLTMODE1=1)
    boat.upload((50.0, 0.0))
    before = ModeId.FORCES if AUX_MODES[function] is ModeId.MANUAL else ModeId.MANUAL
    assert boat.supervisor.request_mode(before, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    rc(boat, True)
    if function is AuxFunction.GUIDED:
        assert any(text.startswith("Offboard refused") for text in boat.texts()), "no setpoints"
        return
    assert boat.status.mode is AUX_MODES[function] and boat.supervisor.mode_cause is Cause.TRANSMITTER
    rc(boat, False)
    assert boat.status.mode is ModeId.FORCES, "moved off: what the mode switch says"


def test_a_switch_that_is_on_at_the_start_waits_until_it_is_moved(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_RC_SAFE_CH=0, **{CHANNEL: float(AuxFunction.SAVE_WAYPOINT)})
    rc(boat, True)
    assert "Switch 9 is on: it acts when moved" in boat.texts() and store(boat) == 0
    rc(boat, False)
    rc(boat, True)
    assert store(boat) == 1


def test_a_channel_gets_another_function_and_is_read_anew(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.SAVE_WAYPOINT)
    rc(boat, True)
    boat.parameters.set(CHANNEL, AuxFunction.CLEAR_MISSION)
    boat.step(1.0)
    assert store(boat) == 1, "the waypoint; nothing is cleared before the switch is moved"
    assert len(boat.plans.items(PlanKind.MISSION)) == 1


def test_each_option_names_its_channel_and_faults_are_told(make_boat: Callable[..., Boat]) -> None:
    assert list(OPTIONS.values()) == list(range(5, 17))
    boat = make_boat(MAN_RC_SAFE_CH=5, RC5_OPTION=float(AuxFunction.FENCE), RC12_OPTION=float(AuxFunction.RTL))
    boat.rc = OFF
    boat.step()
    assert "Channel 5 twice: MAN_RC_SAFE_CH, RC5_OPTION" in boat.texts()
    assert "Transmitter has no channel 12: RC12_OPTION" in boat.texts()


@pytest.mark.parametrize("function", RELAYS, ids=lambda f: f.name)
def test_relays_follow_the_switch(
    with_option: Callable[..., Boat], function: AuxFunction, monkeypatch: pytest.MonkeyPatch
) -> None:
    boat = with_option(function)
    asked: list[Any] = []
    monkeypatch.setattr(boat.supervisor.auxiliary, "request", lambda action, now_s: asked.append(action))
    rc(boat, True)
    rc(boat, False)
    assert asked == [SetRelay(RELAYS[function], True), SetRelay(RELAYS[function], False)]


def test_pictures_are_taken_when_moved_on_only(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.CAMERA)
    rc(boat, True)
    rc(boat, False)
    assert boat.texts().count("No camera: add [[camera]] to the vessel file") == 1


# --- stopping and arming -------------------------------------------------------------------------------------------


def test_emergency_stop_is_a_kill_switch(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.EMERGENCY_STOP)
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.rc = (*OFF, 1.0)
    boat.step()
    assert not boat.status.armed, "in the very tick"
    boat.rc = None
    boat.step(20.0)
    assert not boat.supervisor.arm(boat.now_s, force=True).accepted, "its last position counts"
    boat.parameters.set(CHANNEL, AuxFunction.NOTHING)
    boat.step()
    assert boat.supervisor.arm(boat.now_s).accepted


def test_one_kill_switch_of_two_is_enough(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.EMERGENCY_STOP, RC_MAP_KILL_SW=8)
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.rc = (*OFF[:7], 1.0, -1.0)
    boat.step()
    assert not boat.status.armed
    boat.rc = (*OFF[:7], 1.0)
    boat.step()
    assert not boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    assert "PreArm: transmitter has no channel 9 for its kill switch" in boat.texts()


def test_arm_and_disarm_by_a_channel_of_its_own(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.ARM_DISARM)
    boat.wet = True
    rc(boat, True)
    assert not boat.status.armed and "PreArm: water in the hull" in boat.texts(), "every check applies"
    boat.wet = False
    boat.step(5.0)
    assert not boat.status.armed, "a fresh move only"
    rc(boat, False)
    rc(boat, True)
    assert boat.status.armed
    rc(boat, False)
    assert not boat.status.armed


def test_disarm_switch_disarms_and_never_arms(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.DISARM)
    assert boat.supervisor.arm(boat.now_s).accepted
    rc(boat, True)
    assert not boat.status.armed
    rc(boat, False)
    assert not boat.status.armed


@pytest.mark.parametrize("wanted", [0, 1, 2])
def test_arming_by_the_yaw_stick(make_boat: Callable[..., Boat], wanted: int) -> None:
    boat = make_boat(MAN_RC_SAFE_CH=0, ARMING_RUDDER=wanted)
    sticks(boat, 0.0, 0.5)
    sticks(boat, 1.0, HELD_S - 0.3)
    assert not boat.status.armed
    sticks(boat, 1.0, 1.0)
    assert boat.status.armed is (wanted > 0)
    if not wanted:
        return
    sticks(boat, 1.0, 5.0)
    assert boat.status.armed and boat.supervisor.parts.sticks.must_centre, "it does not turn before it is centred"
    sticks(boat, 0.0, 0.5)
    sticks(boat, -1.0, HELD_S + 0.5)
    assert boat.status.armed is (wanted == 1)


def test_the_yaw_stick_arms_only_afresh_in_a_mode_of_sticks_and_without_thrust(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_RC_SAFE_CH=0, ARMING_RUDDER=2)
    sticks(boat, 1.0, 5.0)
    assert not boat.status.armed, "over since the start"
    sticks(boat, 0.0, 0.5)
    sticks(boat, 1.0, 5.0, surge=0.5)
    assert not boat.status.armed
    sticks(boat, 0.0, 0.5)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    sticks(boat, 1.0, 5.0)
    assert not boat.status.armed
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    sticks(boat, 0.0, 0.5)
    boat.wet = True
    sticks(boat, 1.0, 5.0)
    assert not boat.status.armed and boat.texts().count("PreArm: water in the hull") == 1


# --- missions ------------------------------------------------------------------------------------------------------


def test_a_waypoint_is_appended_where_the_boat_is(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.SAVE_WAYPOINT)
    boat.upload((50.0, 0.0))
    rc(boat, True)
    assert "Waypoint saved: item 2" not in boat.texts(), "not before it is stored"
    assert store(boat) == 1 and "Waypoint saved: item 2" in boat.texts()
    item = boat.plans.items(PlanKind.MISSION)[-1]
    assert (item.seq, item.command) == (1, 16) and math.isnan(item.param4)
    assert (item.lat_deg, item.lon_deg) == pytest.approx((boat.nav.lat_deg, boat.nav.lon_deg), abs=1e-7)


def test_moves_in_a_row_are_all_stored(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.SAVE_WAYPOINT)
    for _ in range(3):
        rc(boat, True)
        rc(boat, False)
    assert store(boat) == 3
    assert [item.seq for item in boat.plans.items(PlanKind.MISSION)] == [0, 1, 2]


def test_what_is_not_stored_is_not_announced_as_saved(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.SAVE_WAYPOINT)
    rc(boat, True)
    store(boat, PlanRefusal(PlanResult.ERROR, "disk full"))
    assert "Waypoint refused: disk full" in boat.texts() and not boat.plans.items(PlanKind.MISSION)


def test_a_mission_under_way_is_left_alone(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.SAVE_WAYPOINT)
    boat.upload((50.0, 0.0))
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    rc(boat, True)
    assert store(boat) == 0 and "Waypoint refused: the boat is in Mission" in boat.texts()


def test_clear_and_reset(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.CLEAR_MISSION)
    boat.upload((50.0, 0.0), (50.0, 50.0))
    boat.parameters.set("RC10_OPTION", AuxFunction.MISSION_RESET)
    assert boat.supervisor.set_current(1, False, boat.now_s).accepted
    boat.rc = (*OFF, -1.0, -1.0)
    boat.step(0.5)
    boat.rc = (*OFF, -1.0, 1.0)
    boat.step(0.5)
    assert boat.status.mission.seq == 0 and "Mission at its first item" in boat.texts()
    boat.rc = (*OFF, 1.0, 1.0)
    boat.step(0.5)
    assert store(boat) == 1 and not boat.plans.items(PlanKind.MISSION)
    assert "Mission cleared by the transmitter" in boat.texts()


# --- cruise speed --------------------------------------------------------------------------------------------------


def test_learning_ends_with_the_mean_speed_in_force(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.LEARN_CRUISE)
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.rc = (*OFF, 1.0)
    for i in range(100):
        boat.nav = replace(boat.nav, surge_mps=0.3 if i % 2 else 0.5)
        boat.step()
    rc(boat, False)
    assert "Learning the cruise speed: sail it now" in boat.texts()
    assert any(text.startswith("WP_SPEED learnt: 0.") for text in boat.texts())
    assert boat.parameters["WP_SPEED"] == pytest.approx(0.4, abs=0.01)


def test_nothing_is_learnt_too_short_disarmed_or_at_rest(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.LEARN_CRUISE)
    before = boat.parameters["WP_SPEED"]
    rc(boat, True)
    assert "Cruise speed not learnt: arm first" in boat.texts()
    rc(boat, False)
    assert boat.supervisor.arm(boat.now_s).accepted
    rc(boat, True, LEAST_S / 2)
    rc(boat, False)
    assert "Cruise speed not learnt: sail 5 s or more" in boat.texts()
    rc(boat, True, 2 * LEAST_S)
    rc(boat, False)
    assert "Cruise speed not learnt: 0.00 m/s is no WP_SPEED" in boat.texts()
    rc(boat, True, 2 * LEAST_S)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step()
    assert "Cruise speed not learnt: Hold sails by itself" in boat.texts()
    rc(boat, False)
    assert boat.parameters["WP_SPEED"] == before


# --- fence ---------------------------------------------------------------------------------------------------------


def test_the_fence_is_off_until_it_is_switched_on_again(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.FENCE)
    fenced(boat)
    rc(boat, True)
    assert boat.status.fence is not None, "on already"
    rc(boat, False)
    assert boat.status.fence is None and "Fence off until switched on or disarmed" in boat.texts()
    rc(boat, True)
    assert boat.status.fence is not None and "Fence on" in boat.texts()


def test_disarming_and_another_fence_put_it_in_force_again(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.FENCE)
    fenced(boat)
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.supervisor.switch_fence(False, boat.now_s)
    boat.step()
    assert boat.status.fence is None
    boat.supervisor.disarm(boat.now_s)
    boat.step()
    assert boat.status.fence is not None
    boat.supervisor.switch_fence(False, boat.now_s)
    fenced(boat)
    assert boat.status.fence is not None


# --- the way home --------------------------------------------------------------------------------------------------


def test_smart_rtl_goes_back_along_the_own_track_whatever_rtl_track_says(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.SMART_RTL, HOME_ON_ARM=1)
    assert boat.supervisor.arm(boat.now_s).accepted
    for north_m, east_m in ((30.0, 0.0), (30.0, 30.0), (0.0, 30.0)):
        boat.upload((north_m, east_m))
        assert boat.supervisor.start_mission(0, boat.now_s).accepted
        boat.until(lambda n=north_m, e=east_m: boat.away_m(n, e) < 3.0)  # type: ignore[misc]
    rc(boat, True)
    assert boat.status.mode is ModeId.RTL
    way = boat.helm.mode.way_ahead()
    length_m = sum(math.dist(a, b) for a, b in pairwise(way))
    assert length_m > 60.0, "round the square, not straight home"
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    boat.step()
    way = boat.helm.mode.way_ahead()
    assert sum(math.dist(a, b) for a, b in pairwise(way)) < 45.0, "RTL means the shortest way again"


# --- tack ----------------------------------------------------------------------------------------------------------


def test_a_tack_is_refused_while_the_boat_does_not_beat(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.SAILBOAT_TACK)
    rc(boat, True)
    assert "No tack: the boat does not beat" in boat.texts()


def test_a_boat_without_a_motor_beside_a_sail_refuses_its_switch(with_option: Callable[..., Boat]) -> None:
    boat = with_option(AuxFunction.SAILBOAT_MOTOR)
    rc(boat, True)
    assert "No motor beside the sail" in boat.texts()
