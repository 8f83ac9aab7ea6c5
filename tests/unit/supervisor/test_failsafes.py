"""Each failsafe: onset, action, end, override, precedence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.decision import ModeId, Severity
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint, ThrusterSetpoint
from companion.params.spec import FAILSAFE_ACTIONS
from companion.params.table import TABLE
from companion.supervisor.failsafes import FAILSAFES, FailsafeAction
from tests.unit.conftest import Boat

SQUARE = ((60.0, 0.0), (60.0, 60.0))


def sail(boat: Boat) -> Any:
    """Armed and on a mission, 10 s under way."""
    boat.upload(*SQUARE)
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step(10.0)
    assert isinstance(boat.setpoint, PathSetpoint)
    return boat


def position(boat: Boat, valid: bool) -> None:
    boat.nav = replace(boat.nav, position_valid=valid)


def heading(boat: Boat, valid: bool) -> None:
    boat.nav = replace(boat.nav, heading_valid=valid)


def bridge(boat: Boat, well: bool) -> None:
    boat.silent = set() if well else {"microcontroller"}


def leak(boat: Boat, dry: bool) -> None:
    boat.wet = not dry


def battery(boat: Boat, full: bool) -> None:
    boat.battery = 0.9 if full else 0.1


def station(boat: Boat, there: bool) -> None:
    boat.station = there


CAUSES: list[tuple[str, str, Callable[[Any, bool], None], float]] = [
    ("bridge_silent", "FS_ACT_ACT", bridge, 0.1),
    ("position_lost", "FS_POS_ACT", position, 0.1),
    ("heading_lost", "FS_POS_ACT", heading, 0.1),
    ("leak", "FS_LEAK_ACT", leak, 0.1),
    ("battery_critical", "COM_LOW_BAT_ACT", battery, 0.1),
    ("station_lost", "NAV_DLL_ACT", station, 10.2),
]
NEEDED = {"position_lost", "heading_lost"}  # without these Hold and RTL cannot be


@pytest.mark.parametrize(("name", "parameter", "cause", "delay_s"), CAUSES)
@pytest.mark.parametrize("action", [FailsafeAction(number) for number in FAILSAFE_ACTIONS])
def test_onset_action_and_end(
    make_boat: Callable[..., Boat], name: str, parameter: str, cause: Any, delay_s: float, action: FailsafeAction
) -> None:
    boat = sail(make_boat(**{parameter: action}))
    cause(boat, False)
    boat.step(delay_s)
    expected = FailsafeAction.NEUTRAL if name in NEEDED and action is not FailsafeAction.IGNORE else action
    modes = {
        FailsafeAction.IGNORE: ModeId.MISSION,
        FailsafeAction.HOLD: ModeId.HOLD,
        FailsafeAction.RTL: ModeId.RTL,
        FailsafeAction.NEUTRAL: ModeId.MISSION,
    }
    assert boat.status.mode is modes[expected] and boat.status.armed
    assert boat.status.intended_mode is ModeId.MISSION
    assert name in boat.status.failsafes
    assert (isinstance(boat.setpoint, NeutralSetpoint)) == (expected is FailsafeAction.NEUTRAL)
    assert boat.names().count(name) == 1 and boat.severities[name] <= Severity.WARNING
    boat.step(3.0)
    assert boat.names().count(name) == 1
    cause(boat, True)
    boat.step(0.2)
    assert name not in boat.status.failsafes and f"{name}_over" in boat.names()
    assert boat.status.mode is modes[expected]
    if expected is FailsafeAction.NEUTRAL:
        assert isinstance(boat.setpoint, PathSetpoint)  # goes on where it was


@pytest.mark.parametrize(("name", "parameter", "cause", "delay_s"), [row for row in CAUSES if row[0] not in NEEDED])
@pytest.mark.parametrize("action", [FailsafeAction.HOLD, FailsafeAction.NEUTRAL])
def test_operator_overrides_until_it_begins_again(
    make_boat: Callable[..., Boat], name: str, parameter: str, cause: Any, delay_s: float, action: FailsafeAction
) -> None:
    boat = sail(make_boat(**{parameter: action}))
    cause(boat, False)
    boat.step(delay_s)
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    boat.step(15.0)
    assert (
        boat.status.mode is ModeId.MISSION and isinstance(boat.setpoint, PathSetpoint) and name in boat.status.failsafes
    )
    cause(boat, True)
    boat.step(0.2)
    cause(boat, False)
    boat.step(delay_s)
    assert boat.status.mode is (ModeId.HOLD if action is FailsafeAction.HOLD else ModeId.MISSION)
    assert (isinstance(boat.setpoint, NeutralSetpoint)) == (action is FailsafeAction.NEUTRAL)


def test_station_counts_only_once_heard_and_only_when_self_steered(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(ready=False)
    boat.station = False
    boat.step()
    sail(boat)
    boat.step(30.0)
    assert boat.status.failsafes == () and boat.status.mode is ModeId.MISSION
    boat = make_boat()
    boat.sticks = (0.0, 0.0, 0.0)
    boat.supervisor.arm(boat.now_s)
    boat.station = False
    boat.step(30.0)
    assert boat.status.failsafes == () and boat.status.mode is ModeId.MANUAL


def test_go_to_is_given_up_when_the_station_falls_silent(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    boat.supervisor.go_to(*boat.point(200.0, 0.0), None, None, boat.now_s)
    boat.station = False
    boat.step(40.0)
    assert boat.status.mode is ModeId.HOLD and boat.away_m(0.0, 0.0) < 12.0 and isinstance(boat.setpoint, PoseSetpoint)


def test_a_boat_that_rests_after_its_mission_starts_no_thrusters_when_the_station_leaves(
    make_boat: Callable[..., Boat],
) -> None:
    """MIS_DONE_ACT 3: ten seconds after the tablet was switched off its thrusters started, to hold."""
    boat = make_boat(MIS_DONE_ACT=FailsafeAction.NEUTRAL)
    boat.upload((10.0, 0.0))
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step(60.0)
    assert "Mission complete" in boat.texts() and isinstance(boat.setpoint, NeutralSetpoint)
    boat.station = False
    boat.step(15.0)
    assert isinstance(boat.setpoint, NeutralSetpoint) and boat.status.failsafes == ()
    boat.station = True
    boat.step()
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.station = False
    boat.step(11.0)
    assert boat.status.failsafes == ("station_lost",), "it steers by itself again"


def test_a_boat_on_its_way_home_is_not_stopped_by_hold(boat: Boat) -> None:
    sail(boat)
    boat.supervisor.request_mode(ModeId.RTL, boat.now_s)
    boat.station = False
    boat.step(11.0)
    assert boat.status.mode is ModeId.RTL and "station_lost" in boat.status.failsafes


def test_shallow_water_stops_a_boat_on_its_way_home(boat: Boat) -> None:
    """It sailed on over 0.3 m of water, and said "Shallow: 0.3 m of water: RTL"."""
    boat.parameters.set("FS_DEPTH_MIN", 1.0)
    sail(boat)
    boat.supervisor.request_mode(ModeId.RTL, boat.now_s)
    boat.step(1.0)
    boat.depth_m = 0.3
    boat.step(1.5)
    assert boat.status.mode is ModeId.HOLD and boat.texts()[-1] == "Shallow: 0.3 m of water: Hold"


def test_sticks_lost_stops_at_once_then_holds(boat: Boat) -> None:
    boat.sticks = (0.0, 0.0, 0.0)
    boat.supervisor.arm(boat.now_s)
    boat.step()
    boat.sticks = (0.8, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint) and boat.setpoint.thrusters[0].force_n > 5.0
    boat.sticks = None
    boat.step(0.6)
    assert (
        boat.status.mode is ModeId.HOLD
        and boat.status.intended_mode is ModeId.MANUAL
        and "sticks_lost" in boat.status.failsafes
    )
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step(0.2)
    assert boat.status.mode is ModeId.HOLD and boat.status.failsafes == () and "sticks_lost_over" in boat.names()
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted


def left_in_manual(make_boat: Callable[..., Boat]) -> Boat:
    """Sticks and ground station have just fallen silent."""
    boat = make_boat(NAV_DLL_ACT=FailsafeAction.RTL)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.supervisor.arm(boat.now_s)
    boat.step()
    boat.sticks, boat.station = None, False
    return boat


def test_a_boat_that_holds_for_want_of_sticks_still_minds_the_station(make_boat: Callable[..., Boat]) -> None:
    """Everything silent in Manual: it held for good, whatever NAV_DLL_ACT said."""
    boat = left_in_manual(make_boat)
    boat.step(5.0)
    assert boat.status.mode is ModeId.HOLD and boat.status.failsafes == ("sticks_lost",)
    boat.step(6.0)
    assert boat.status.mode is ModeId.RTL and boat.status.failsafes == ("station_lost", "sticks_lost")
    boat.sticks, boat.station = (0.0, 0.0, 0.0), True
    boat.step()
    assert boat.status.mode is ModeId.RTL and boat.status.failsafes == ()


def test_a_boat_that_an_operator_took_over_stays_where_it_was_put(make_boat: Callable[..., Boat]) -> None:
    boat = left_in_manual(make_boat)
    boat.step(11.0)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step(11.0)
    assert boat.status.mode is ModeId.HOLD


@pytest.mark.parametrize("mode", [ModeId.MANUAL, ModeId.FORCES, ModeId.RATE, ModeId.HEADING])
def test_sticks_lost_gives_no_thrust_whatever_the_action(make_boat: Callable[..., Boat], mode: ModeId) -> None:
    for action in (FailsafeAction.IGNORE, FailsafeAction.NEUTRAL):
        boat = make_boat(NAV_RCL_ACT=action)
        boat.sticks = (0.0, 0.0, 0.0)
        boat.step()
        boat.supervisor.request_mode(mode, boat.now_s)
        boat.supervisor.arm(boat.now_s)
        boat.sticks = (1.0, 0.5, 0.5)
        boat.step()
        assert not isinstance(boat.setpoint, NeutralSetpoint)
        boat.sticks = None
        boat.step(0.6)
        assert isinstance(boat.setpoint, NeutralSetpoint) and boat.status.mode is mode


def test_sticks_that_come_back_deflected_after_neutral_must_be_centred(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(NAV_RCL_ACT=FailsafeAction.NEUTRAL)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.supervisor.arm(boat.now_s)
    boat.step()
    boat.sticks = None
    boat.step(1.0)
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(1.0)
    assert isinstance(boat.setpoint, NeutralSetpoint)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint)


def test_manual_without_any_sticks_drifts_and_does_not_sail_off(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    boat.step(5.0)
    assert (
        boat.status.mode is ModeId.MANUAL and isinstance(boat.setpoint, NeutralSetpoint) and boat.status.failsafes == ()
    )


def test_low_battery_is_only_said(boat: Boat) -> None:
    boat.battery = 0.2
    sail(boat)
    assert "battery_low" in boat.status.failsafes and boat.status.mode is ModeId.MISSION
    assert "Battery low, 20 % left" in boat.texts()


def test_battery_near_the_threshold_does_not_chatter(boat: Boat) -> None:
    sail(boat)
    for i in range(40):
        boat.battery = 0.115 if i % 2 else 0.125
        boat.step()
    assert boat.names().count("battery_critical") == 1 and "battery_critical_over" not in boat.names()


def test_a_battery_that_passed_the_check_is_critical_once_it_falls_again(boat: Boat) -> None:
    """It was critical while the boat lay disarmed, and lasted by its hysteresis: nothing was said or done to the end."""
    boat.battery = 0.11
    boat.step()
    boat.battery = 0.13
    boat.step()
    assert "battery_critical" in boat.status.failsafes
    sail(boat)
    assert "battery_critical" not in boat.status.failsafes
    boat.battery = 0.11
    boat.step()
    assert boat.status.mode is ModeId.RTL and boat.texts()[-1] == "Battery critical, 11 % left: RTL"


def test_what_begins_again_soon_is_said_again(boat: Boat) -> None:
    sail(boat)
    for valid in (False, True, False):
        position(boat, valid)
        boat.step(1.0)
    assert isinstance(boat.setpoint, NeutralSetpoint) and boat.texts()[-1] == "Position lost: neutral"
    position(boat, True)
    boat.step(1.0)
    assert boat.texts()[-1] == "Position is back"


def test_a_mode_without_thrust_is_said_to_have_none(make_boat: Callable[..., Boat]) -> None:
    boat = sail(make_boat(NAV_DLL_ACT=FailsafeAction.NEUTRAL))
    boat.station = False
    boat.step(12.0)
    boat.wet = True
    boat.step()
    assert boat.status.mode is ModeId.RTL and isinstance(boat.setpoint, NeutralSetpoint)
    assert boat.texts()[-1] == "Water in the hull: RTL, no thrust yet"
    boat.station = True
    boat.step()
    assert boat.status.mode is ModeId.RTL and not isinstance(boat.setpoint, NeutralSetpoint)


def test_a_battery_whose_voltage_rises_at_rest_starts_no_propellers(make_boat: Callable[..., Boat]) -> None:
    """Judged by voltage it rose over the threshold whenever the thrusters stood: they started every six seconds."""
    boat = sail(make_boat(COM_LOW_BAT_ACT=FailsafeAction.NEUTRAL))
    for _ in range(50):
        boat.battery = 0.3 if isinstance(boat.setpoint, NeutralSetpoint) else 0.1
        boat.step(0.5)
    assert isinstance(boat.setpoint, NeutralSetpoint) and boat.names().count("battery_critical") == 1
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    for left in (0.3, 0.1):
        boat.battery = left
        boat.step()
    assert boat.status.mode is ModeId.HOLD and not isinstance(boat.setpoint, NeutralSetpoint), "the operator's word"
    boat.battery = 0.5
    boat.step()
    assert "battery_critical" not in boat.status.failsafes, "charged, or another battery"


def test_the_more_severe_one_wins(boat: Boat) -> None:
    sail(boat)
    boat.wet = True  # RTL
    boat.step()
    assert boat.status.mode is ModeId.RTL
    boat.station = False  # Hold, less severe
    boat.step(11.0)
    assert boat.status.mode is ModeId.RTL and boat.status.failsafes == ("leak", "station_lost")
    bridge(boat, False)  # neutral, most severe
    boat.step()
    assert isinstance(boat.setpoint, NeutralSetpoint)
    bridge(boat, True)
    boat.step(0.2)
    assert not isinstance(boat.setpoint, NeutralSetpoint) and boat.status.mode is ModeId.RTL


def test_the_lesser_one_acts_when_the_greater_one_ends(boat: Boat) -> None:
    sail(boat)
    bridge(boat, False)
    boat.step()
    boat.station = False
    boat.step(12.0)
    assert boat.status.mode is ModeId.MISSION and isinstance(boat.setpoint, NeutralSetpoint)
    bridge(boat, True)
    boat.step(0.2)
    assert boat.status.mode is ModeId.HOLD and isinstance(boat.setpoint, PoseSetpoint)


def test_what_was_overridden_does_not_block_the_others(boat: Boat) -> None:
    sail(boat)
    boat.wet = True
    boat.step()
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    boat.station = False
    boat.step(11.0)
    assert boat.status.mode is ModeId.HOLD


def test_return_that_is_impossible_becomes_hold_then_neutral(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(ARM_NEED_POS=0, ready=False)
    position(boat, False)
    boat.step()
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    boat.supervisor.arm(boat.now_s)
    boat.wet = True
    boat.step()
    assert (
        boat.status.mode is ModeId.MANUAL
        and isinstance(boat.setpoint, NeutralSetpoint)
        and "Water in the hull: neutral" in boat.texts()
    )
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(0.2)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step(0.2)
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(0.2)
    assert isinstance(boat.setpoint, ThrusterSetpoint)


def test_return_without_home_becomes_hold(boat: Boat) -> None:
    sail(boat)
    boat.forget_home()
    boat.wet = True
    boat.step()
    assert boat.status.mode is ModeId.HOLD and "Water in the hull: Hold" in boat.texts()


def test_hold_goes_back_to_its_point_after_the_position_returns(boat: Boat) -> None:
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.step(5.0)
    position(boat, False)
    boat.step(5.0)
    assert isinstance(boat.setpoint, NeutralSetpoint)
    boat.nav = replace(boat.nav, position_valid=True, north_m=3.0)
    boat.step(0.2)
    assert isinstance(boat.setpoint, PoseSetpoint) and boat.setpoint.progress.target.north_m == pytest.approx(
        0.0, abs=1e-9
    )


def test_an_estimate_that_is_not_finite_counts_as_lost(boat: Boat) -> None:
    sail(boat)
    good = boat.nav
    follow, boat.obey = boat.obey, lambda setpoint: None
    boat.nav = replace(good, north_m=float("nan"), yaw_rad=float("inf"))
    boat.step(0.5)
    boat.obey = follow
    assert isinstance(boat.setpoint, NeutralSetpoint) and boat.status.failsafes == ("position_lost", "heading_lost")
    boat.nav = good
    boat.step(0.2)
    assert isinstance(boat.setpoint, PathSetpoint) and "mode_failed" not in boat.names()


def test_faults_while_disarmed_are_said_and_do_not_act_on_a_forced_arming(boat: Boat) -> None:
    boat.wet = True
    boat.step()
    assert "leak" in boat.names() and boat.status.mode is ModeId.MANUAL
    boat.supervisor.arm(boat.now_s, force=True)
    boat.step(2.0)
    assert boat.status.mode is ModeId.MANUAL and boat.status.armed


def test_every_row_reads_a_parameter_of_the_table() -> None:
    known = {spec.name for spec in TABLE}
    assert all(isinstance(row.action, FailsafeAction) or row.action in known for row in FAILSAFES)
    assert len({row.name for row in FAILSAFES}) == len(FAILSAFES)


def test_a_mode_that_raises_becomes_hold_then_stops(boat: Boat) -> None:
    sail(boat)

    def broken(*_: object) -> None:
        raise ZeroDivisionError("division by zero")

    boat.helm.modes[ModeId.MISSION].update = broken
    boat.step()
    assert isinstance(boat.setpoint, NeutralSetpoint) and boat.severities["mode_failed"] is Severity.CRITICAL
    boat.step()
    assert boat.status.mode is ModeId.HOLD and isinstance(boat.setpoint, PoseSetpoint)
    boat.helm.modes[ModeId.HOLD].update = broken
    boat.step(2.0)
    assert isinstance(boat.setpoint, NeutralSetpoint) and boat.status.armed
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    boat.sticks = (0.5, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint)


@pytest.mark.parametrize("mode", [ModeId.HOLD, ModeId.MISSION])
def test_one_fixed_thruster_of_two_is_left_alone(make_boat: Callable[..., Boat], mode: ModeId) -> None:
    boat = make_boat(load(find("otter")))
    boat.upload(*SQUARE)
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted and boat.supervisor.arm(boat.now_s).accepted
    boat.step(5.0)
    boat.supervisor.thruster_failed(0, True)
    boat.step()
    assert boat.status.mode is mode and isinstance(boat.setpoint, NeutralSetpoint)
    assert boat.texts()[-1] == "Thrusters failed: no straight course left: neutral"
    boat.supervisor.thruster_failed(0, False)
    boat.step()
    assert boat.status.mode is mode and not isinstance(boat.setpoint, NeutralSetpoint)


def test_a_person_at_the_sticks_may_use_one_thruster_of_two(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(load(find("otter")))
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted and boat.supervisor.arm(boat.now_s).accepted
    boat.supervisor.thruster_failed(0, True)
    boat.step()
    assert boat.status.mode is ModeId.MANUAL and "one_sided_thrust" not in boat.status.failsafes


def test_a_mode_whose_check_raises_is_refused_and_said_once(boat: Boat) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("division by zero")

    boat.helm.modes[ModeId.MISSION].check = broken
    for _ in range(3):
        refused = boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
        assert "division by zero" in str(refused)
        boat.step()
    assert boat.names().count("mode_failed") == 1 and boat.status.mode is ModeId.MANUAL


def test_the_guard_against_obstacles_is_told_of_a_hold_that_nobody_asked_for(
    make_boat: Callable[..., Boat], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Until a person chooses Hold, also where the boat is in it already."""
    boat = sail(make_boat(COM_LOW_BAT_ACT=FailsafeAction.HOLD))
    guard = boat.supervisor.parts.obstacles
    told: list[tuple[ModeId, bool]] = []

    def steer(setpoint: Any, mode: Any, inputs: Any, detour: Any, unasked: bool) -> Any:
        told.append((mode.id, unasked))
        return setpoint

    monkeypatch.setattr(guard, "steer", steer)
    boat.step()
    battery(boat, full=False)
    boat.step(0.2)
    before = told[-1]
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step()
    assert [told[0], before, told[-1]] == [(ModeId.MISSION, False), (ModeId.HOLD, True), (ModeId.HOLD, False)]
