"""Sticks of ground station and transmitter, and the modes they steer."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.control.manual import beyond_deadband
from companion.core.decision import ModeId, Result
from companion.core.readings import ManualInput, RcInput
from companion.core.setpoint import (
    HeadingSetpoint,
    NeutralSetpoint,
    PathSetpoint,
    PoseSetpoint,
    ThrusterSetpoint,
    WrenchSetpoint,
)
from companion.params.store import Parameters
from companion.supervisor.sticks import Sticks
from tests.unit.conftest import Boat


def armed(boat: Boat, mode: ModeId) -> Any:
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    return boat


def test_deadband() -> None:
    assert [beyond_deadband(v, 0.2) for v in (None, 0.2, -0.2, 1.0, -1.0, 0.6)] == pytest.approx(
        [0.0, 0.0, 0.0, 1.0, -1.0, 0.5]
    )


def test_forces(boat: Boat) -> None:
    armed(boat, ModeId.FORCES)
    boat.sticks = (1.0, -1.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, WrenchSetpoint)
    limits = boat.config.limits
    assert (boat.setpoint.wrench.surge_n, boat.setpoint.wrench.sway_n, boat.setpoint.wrench.yaw_nm) == pytest.approx(
        (limits.surge_n, -limits.sway_n, 0.0)
    )


def test_heading_is_held_and_turned(boat: Boat) -> None:
    boat.nav = replace(boat.nav, yaw_rad=1.0)
    armed(boat, ModeId.HEADING)
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(2.0)
    assert isinstance(boat.setpoint, HeadingSetpoint) and boat.setpoint.yaw_rad == pytest.approx(1.0)
    assert boat.setpoint.wrench.surge_n == pytest.approx(50.0)
    boat.sticks = (0.0, 0.0, 1.0)
    boat.step(2.0)
    assert boat.setpoint.yaw_rad == pytest.approx(1.0 + 2.0 * math.radians(20.0), abs=1e-6)
    assert boat.setpoint.yaw_rate_radps == pytest.approx(math.radians(20.0)) and boat.setpoint.wrench.yaw_nm == 0.0
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step(2.0)
    assert (
        boat.setpoint.yaw_rad == pytest.approx(1.0 + 2.0 * math.radians(20.0), abs=1e-6)
        and boat.setpoint.yaw_rate_radps == 0.0
    )


def test_heading_does_not_run_away_from_a_boat_that_cannot_turn(boat: Boat) -> None:
    armed(boat, ModeId.HEADING)
    boat.obey = lambda setpoint: None
    boat.sticks = (0.0, 0.0, -1.0)
    boat.step(30.0)
    assert boat.setpoint.yaw_rad == pytest.approx(math.radians(-45.0))


def test_sticks_demand_speed_with_man_speed(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_SPEED=0.8)
    boat.nav = replace(boat.nav, yaw_rad=1.0)
    armed(boat, ModeId.HEADING)
    boat.sticks = (0.5, -1.0, 0.0)
    boat.step(30.0)
    half = beyond_deadband(0.5, 0.05) * 0.8
    assert isinstance(boat.setpoint, PathSetpoint) and boat.setpoint.surge_mps == pytest.approx(half)
    assert boat.setpoint.sway_mps == pytest.approx(-boat.parameters["DP_SPEED_SWAY"])
    assert boat.setpoint.yaw_rad == pytest.approx(1.0)
    boat.sticks = (0.5, 0.0, 1.0)
    boat.step(2.0)
    rate_radps = math.radians(min(20.0, boat.parameters["PATH_YAW_RATE"]))
    assert boat.setpoint.yaw_rate_radps == pytest.approx(rate_radps)
    assert boat.setpoint.yaw_rad == pytest.approx(1.0 + 2.0 * rate_radps, abs=1e-6)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step(30.0)
    assert boat.setpoint.surge_mps == 0.0 and boat.setpoint.yaw_rad == pytest.approx(1.0 + 2.0 * rate_radps, abs=1e-6)
    boat.sticks = (-1.0, 0.0, 0.0)
    boat.step(30.0)
    assert boat.setpoint.surge_mps == pytest.approx(-boat.parameters["DP_SPEED_ASTERN"])


def test_sticks_give_force_where_there_is_no_position_to_keep_a_speed_by(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_SPEED=0.8)
    armed(boat, ModeId.HEADING)
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(5.0)
    boat.nav = replace(boat.nav, position_valid=False)
    boat.step()
    assert isinstance(boat.setpoint, HeadingSetpoint) and boat.setpoint.wrench.surge_n == pytest.approx(50.0)
    assert boat.texts().count("Heading: no position, sticks give force") == 1
    boat.nav = replace(boat.nav, position_valid=True)
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint)


def test_a_boat_steered_by_speed_stops_at_the_fence(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_SPEED=1.0)
    boat.fence((-30.0, -30.0), (30.0, -30.0), (30.0, 30.0), (-30.0, 30.0))
    armed(boat, ModeId.HEADING)
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(120.0)
    assert boat.status.mode is ModeId.HEADING and "fence_slowed" in boat.names()
    assert 27.0 < boat.nav.north_m < 29.0 and abs(boat.nav.surge_mps) < 0.05


def test_sticks_off_centre_at_arming_must_be_centred_once(boat: Boat) -> None:
    boat.sticks = (-1.0, 0.0, 0.0)
    boat.step()
    boat.supervisor.arm(boat.now_s)
    boat.step(2.0)
    assert (
        isinstance(boat.setpoint, NeutralSetpoint)
        and "sticks_off_centre" in boat.names()
        and boat.status.failsafes == ()
    )
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    boat.sticks = (-1.0, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint) and boat.setpoint.thrusters[0].force_n < 0.0


def pushed(setpoint: Any) -> float:
    """The force ahead, or the first thruster's, that sticks give."""
    if isinstance(setpoint, ThrusterSetpoint):
        return setpoint.thrusters[0].force_n
    return 0.0 if isinstance(setpoint, NeutralSetpoint) else float(setpoint.wrench.surge_n)


@pytest.mark.parametrize("mode", [ModeId.MANUAL, ModeId.FORCES, ModeId.HEADING])
def test_first_sticks_that_appear_off_centre_after_arming_must_be_centred_once(boat: Boat, mode: ModeId) -> None:
    """A transmitter whose throttle rests at the bottom, switched on after arming, drove the boat full astern."""
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted and boat.supervisor.arm(boat.now_s).accepted
    boat.step(1.0)
    assert "sticks_off_centre" not in boat.names(), "no sticks were heard"
    boat.rc = (0.0, -1.0, -1.0, 0.0, -1.0)
    boat.step(2.0)
    assert pushed(boat.setpoint) == 0.0 and boat.names().count("sticks_off_centre") == 1
    boat.rc = (0.0, 0.0, -1.0, 0.0, -1.0)
    boat.step()
    boat.rc = (0.0, -1.0, -1.0, 0.0, -1.0)
    boat.step()
    assert pushed(boat.setpoint) < 0.0


def test_first_sticks_that_appear_centred_after_arming_are_obeyed(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    boat.step(1.0)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    boat.sticks = (0.5, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint) and "sticks_off_centre" not in boat.names()


def test_what_is_not_a_number_is_dropped(boat: Boat) -> None:
    armed(boat, ModeId.FORCES)
    boat.supervisor.manual_input(ManualInput(boat.now_s, "gcs", math.nan, 0.0, 0.0))
    boat.sticks = None
    boat.step()
    assert boat.setpoint.wrench is not None and boat.setpoint.wrench.surge_n == 0.0


def test_nudging_moves_the_held_point_and_heading(boat: Boat) -> None:
    armed(boat, ModeId.HOLD)
    boat.step(3.0)
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(20.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.5, abs=0.03)
    boat.sticks = (0.0, 0.0, 0.0)
    let_go_m = boat.nav.north_m
    boat.step(20.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.0, abs=1e-6) and let_go_m < boat.nav.north_m < let_go_m + 2.5
    assert boat.nav.east_m == pytest.approx(0.0, abs=1e-6)
    boat.sticks = (0.0, 0.0, 1.0)
    boat.step(20.0)
    assert boat.setpoint.yaw_rate_radps == pytest.approx(math.radians(3.0), abs=math.radians(0.2))
    boat.sticks = (0.0, -1.0, 0.0)
    boat.step(20.0)
    assert boat.setpoint.sway_mps == pytest.approx(-0.1, abs=0.01)


def test_nudging_waits_for_centred_sticks(boat: Boat) -> None:
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.step(2.0)
    boat.sticks = (-1.0, 0.0, 0.0)
    boat.step(10.0)
    assert boat.away_m(0.0, 0.0) < 1e-6


SWITCH_ON = (0.0, 0.0, -1.0, 0.0, 1.0)
SWITCH_OFF = (0.0, 0.0, -1.0, 0.0, -1.0)


def test_safe_switch_always_wins(boat: Boat) -> None:
    boat.rc = SWITCH_OFF
    armed(boat, ModeId.HOLD)
    boat.rc = SWITCH_ON
    boat.step()
    assert boat.status.mode is ModeId.MANUAL and "safe_switch" in boat.names()
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).result is Result.TEMPORARILY_REJECTED
    assert boat.supervisor.go_to(*boat.point(5.0, 0.0), None, None, boat.now_s).result is Result.TEMPORARILY_REJECTED
    boat.sticks = (1.0, 0.0, 0.0)  # of the ground station: no longer counts
    boat.step()
    assert boat.setpoint.thrusters[0].force_n == 0.0
    boat.rc = (0.0, 0.6, -1.0, 0.0, 1.0)
    boat.step()
    assert boat.setpoint.thrusters[0].force_n > 1.0
    boat.wet = True  # not even a failsafe takes the boat away
    boat.step(1.0)
    assert boat.status.mode is ModeId.MANUAL and isinstance(boat.setpoint, ThrusterSetpoint)
    boat.rc = SWITCH_OFF
    boat.step()
    assert boat.status.mode is ModeId.MANUAL
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted


def test_transmitter_lost_with_its_switch_on_stops_the_boat_until_an_operator_takes_over(boat: Boat) -> None:
    boat.rc = SWITCH_OFF
    armed(boat, ModeId.HOLD)
    boat.rc = SWITCH_ON
    boat.step()
    boat.rc = None
    boat.step(2.0)
    assert boat.status.mode is ModeId.MANUAL and isinstance(boat.setpoint, NeutralSetpoint)
    assert "transmitter_lost" in boat.status.failsafes
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step()
    assert boat.status.mode is ModeId.HOLD and isinstance(boat.setpoint, PoseSetpoint)
    boat.rc = SWITCH_ON
    boat.step()
    assert boat.status.mode is ModeId.MANUAL


def test_a_switch_that_was_overruled_counts_no_more_until_its_transmitter_is_heard_again(boat: Boat) -> None:
    """The loop keeps the newest reading of the transmitter, however old: the switch came on again by it, and no
    failsafe took the boat home."""
    boat.rc = SWITCH_OFF
    armed(boat, ModeId.HOLD)
    boat.rc = SWITCH_ON
    boat.step()
    boat.rc_silent_s = boat.now_s
    boat.step(2.0)
    assert "transmitter_lost" in boat.status.failsafes
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step(2.0)
    boat.wet = True
    boat.step()
    assert boat.status.mode is ModeId.RTL and boat.texts()[-1] == "Water in the hull: RTL"
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint), "the ground station steers"
    boat.rc_silent_s = None
    boat.step()
    assert boat.supervisor.parts.sticks.safe_switch


def test_a_silent_switch_is_off_once_it_has_no_channel() -> None:
    parameters = Parameters()
    sticks, on = Sticks(parameters), RcInput(1.0, "rc", SWITCH_ON, lost=False)
    sticks.update(on, 1.0)
    assert sticks.safe_switch
    parameters.set("MAN_RC_SAFE_CH", 0)
    sticks.update(on, 20.0)
    assert not sticks.safe_switch


def takes_over_off_centre(boat: Boat) -> None:
    """Sticks that point ahead do nothing until they were centred, which is announced."""
    boat.step()
    assert isinstance(boat.setpoint, NeutralSetpoint) and boat.names()[-1] == "sticks_off_centre"
    boat.step(2.0)
    assert isinstance(boat.setpoint, NeutralSetpoint) and boat.status.failsafes == ()


def test_a_station_that_steers_again_after_the_safe_switch_must_centre_its_sticks(boat: Boat) -> None:
    boat.rc, boat.sticks = SWITCH_ON, (0.0, 0.0, 0.0)
    boat.step()
    assert boat.supervisor.arm(boat.now_s, force=True).accepted
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint) and boat.setpoint.thrusters[0].force_n == 0.0
    boat.rc = SWITCH_OFF
    takes_over_off_centre(boat)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint) and boat.setpoint.thrusters[0].force_n > 5.0


def test_a_transmitter_that_steers_when_the_station_falls_silent_must_be_centred(boat: Boat) -> None:
    boat.rc, boat.sticks = SWITCH_OFF, (0.0, 0.0, 0.0)
    boat.step()
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.rc = (0.0, 1.0, -1.0, 0.0, -1.0)
    boat.step()
    boat.sticks = None
    boat.step(0.5)
    takes_over_off_centre(boat)


def test_a_joystick_that_joins_must_be_centred_and_one_that_comes_back_need_not(boat: Boat) -> None:
    boat.rc = SWITCH_OFF
    boat.step()
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    boat.sticks = (1.0, 0.0, 0.0)
    takes_over_off_centre(boat)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    boat.rc = None
    boat.step(1.0)
    boat.sticks = None
    boat.step(0.3)
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, ThrusterSetpoint)


def test_another_station_must_centre_its_sticks() -> None:
    sticks = Sticks(Parameters())
    taken_over = []
    for t_s, system, surge in ((1.0, 255, 0.0), (1.1, 255, 1.0), (2.0, 254, 1.0), (2.1, 254, 0.0), (2.2, 254, 1.0)):
        sticks.ground_station_input(ManualInput(t_s, f"mavlink:{system}", surge, 0.0, 0.0))
        taken_over.append(sticks.update(None, t_s))
        assert (sticks.obeyed(t_s) is None) == (t_s == 2.0)
    assert taken_over == [False, False, True, False, False]


def test_switch_has_hysteresis_and_can_be_left_out() -> None:
    parameters = Parameters()
    sticks = Sticks(parameters)
    states = []
    for t, value in enumerate((0.3, 0.6, 0.3, 0.1, 0.3)):
        sticks.update(RcInput(t, "rc", (0.0, 0.0, 0.0, 0.0, value), lost=False), t)
        states.append(sticks.safe_switch)
    assert states == [False, True, True, False, False]
    parameters.set("MAN_RC_SAFE_CH", 0)
    sticks.update(RcInput(9.0, "rc", (0.0, 0.0, 0.0, 0.0, 1.0), lost=False), 9.0)
    assert not sticks.safe_switch


def test_transmitter_axes() -> None:
    parameters = Parameters()
    for throttle, surge in ((0, 0.2), (1, 0.3)):
        parameters.set("MAN_AXIS_SURGE", throttle)
        sticks = Sticks(parameters)
        sticks.update(RcInput(1.0, "rc", (0.1, 0.2, 0.3, 0.4, 0.0), lost=False), 1.0)
        live = sticks.live(1.0)
        assert live is not None and (live.sway, live.surge, live.yaw) == (0.1, surge, 0.4)
        assert sticks.live(1.6) is None
    lost = Sticks(parameters)
    lost.update(RcInput(1.0, "rc", (0.1, 0.2, 0.3, 0.4, 1.0), lost=True), 1.0)
    assert lost.live(1.0) is None and not lost.safe_switch and not lost.heard
