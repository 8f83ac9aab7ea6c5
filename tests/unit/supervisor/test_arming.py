"""Each reason against arming, and what overrules it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.core.decision import ModeId, Result
from companion.core.readings import Ranges
from tests.unit.conftest import Boat


def no_position(boat: Boat) -> None:
    boat.nav = replace(boat.nav, position_valid=False)


def no_heading(boat: Boat) -> None:
    boat.nav = replace(boat.nav, heading_valid=False)


def no_imu(boat: Boat) -> None:
    boat.silent = {"imu"}


def no_bridge(boat: Boat) -> None:
    boat.silent = {"microcontroller"}


def flat_battery(boat: Boat) -> None:
    boat.battery = 0.1


def leak(boat: Boat) -> None:
    boat.wet = True


def switch_on(boat: Boat) -> None:
    boat.rc = (0.0, 0.0, 0.0, 0.0, 1.0)


CAUSES: list[tuple[Callable[[Any], None], str]] = [
    (no_position, "position not valid"),
    (no_heading, "heading not valid"),
    (no_imu, "imu: silent"),
    (no_bridge, "microcontroller: silent"),
    (flat_battery, "battery critical: 10 % left"),
    (leak, "water in the hull"),
    (switch_on, "safe switch of the transmitter is on"),
]


@pytest.mark.parametrize(("cause", "text"), CAUSES)
def test_refused_with_the_reason(boat: Boat, cause: Callable[[Any], None], text: str) -> None:
    cause(boat)
    boat.step()
    assert boat.status.arming_refusals == (text,)
    outcome = boat.supervisor.arm(boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED and outcome.reason == text
    boat.step()
    assert not boat.status.armed and f"PreArm: {text}" in boat.texts()


@pytest.mark.parametrize(("cause", "_text"), CAUSES)
def test_force_passes_over_the_checks(boat: Boat, cause: Callable[[Any], None], _text: str) -> None:
    cause(boat)
    boat.step()
    assert boat.supervisor.arm(boat.now_s, force=True).accepted
    assert boat.supervisor.status(boat.now_s).armed


def test_every_reason_at_once(boat: Boat) -> None:
    for cause, _ in CAUSES:
        cause(boat)
    boat.silent = {"imu", "microcontroller"}
    boat.step()
    assert set(boat.status.arming_refusals) == {text for _, text in CAUSES}


def test_checks_switched_off(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(ARM_CHECKS=0)
    boat.silent = {"imu"}
    no_position(boat)
    boat.step()
    assert boat.status.arming_refusals == () and boat.supervisor.arm(boat.now_s).accepted


def test_manual_can_do_without_position_where_that_is_allowed(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(ARM_NEED_POS=0)
    no_position(boat)
    boat.step()
    assert boat.status.arming_refusals == ()


def test_a_mode_that_cannot_be_refuses_even_by_force(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(ARM_CHECKS=0)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    no_position(boat)
    boat.step()
    assert boat.status.arming_refusals == ("Hold: position not valid",)
    assert boat.supervisor.arm(boat.now_s, force=True).result is Result.TEMPORARILY_REJECTED
    boat.upload((5.0, 0.0))
    boat.nav = replace(boat.nav, position_valid=True)
    boat.step()
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    boat.upload()
    boat.step()
    assert boat.status.arming_refusals == ("Mission: no mission loaded",)


def test_a_reason_is_given_once(boat: Boat) -> None:
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    no_position(boat)
    boat.step()
    assert boat.status.arming_refusals == ("position not valid",)


def test_before_the_first_tick(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(ready=False)
    assert boat.supervisor.arm(0.0).result is Result.TEMPORARILY_REJECTED
    assert not boat.supervisor.request_mode(ModeId.HOLD, 0.0).accepted
    assert boat.supervisor.status(0.0).home is None


def test_hold_picks_up_the_place_at_arming(boat: Boat) -> None:
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.step()
    boat.nav = replace(boat.nav, north_m=12.0, yaw_rad=1.0)
    boat.step()
    boat.supervisor.arm(boat.now_s)
    boat.step(3.0)
    assert (boat.setpoint.progress.target.north_m, boat.setpoint.yaw_rad) == pytest.approx((12.0, 1.0))


def test_armed_boat_has_no_refusals(boat: Boat) -> None:
    boat.supervisor.arm(boat.now_s)
    no_position(boat)
    boat.step()
    assert boat.status.armed and boat.status.arming_refusals == ()
    assert boat.supervisor.arm(boat.now_s).accepted


def test_a_restart_in_mid_mission(make_boat: Callable[..., Boat]) -> None:
    for on_start, mode in ((0, ModeId.HOLD), (1, ModeId.MISSION)):
        boat = make_boat(ready=False, MIS_ON_START=on_start)
        boat.upload((10.0, 0.0), (10.0, 10.0))
        boat.executor.begin(1)
        boat.step()
        assert (boat.status.mode, boat.status.armed, boat.status.mission.seq) == (mode, False, 1)
        assert "mission_interrupted" in boat.names()
        boat.supervisor.arm(boat.now_s)
        boat.step()
        assert boat.status.mission.seq == 1
        if mode is ModeId.MISSION:
            assert boat.setpoint.progress.target.east_m == pytest.approx(10.0, abs=0.01)
            boat.until(lambda boat=boat: boat.status.mission.reached == 1)
        assert math.isfinite(boat.nav.north_m)


def test_a_failed_thruster_is_a_reason_against_arming(boat: Boat) -> None:
    boat.supervisor.thruster_failed(2, True)
    boat.step()
    assert boat.status.arming_refusals == ("thruster bow has failed",)
    boat.supervisor.thruster_failed(2, False)
    boat.step()
    assert boat.status.arming_refusals == ()


def test_a_sensor_that_speaks_and_knows_no_range_is_a_reason_against_arming(boat: Boat) -> None:
    """Its driver hears it, so it counted as well."""
    for _ in range(30):
        blind = Ranges(boat.now_s, "imu", 0.0, 0.1, 0.2, 20.0, False, 0.0, 0.0, (math.nan,) * 72)
        boat.supervisor.obstacle_heard(blind, boat.now_s)
        boat.step()
    assert boat.status.arming_refusals == ("no ranges from imu",)


def test_each_arming_and_disarming_is_said(boat: Boat) -> None:
    for _ in range(2):
        assert boat.supervisor.arm(boat.now_s).accepted
        boat.step()
        assert boat.supervisor.disarm(boat.now_s).accepted
        boat.step()
    assert [name for name in boat.names() if name in ("armed", "disarmed")] == ["armed", "disarmed"] * 2


def test_home_moves_here_before_the_mode_begins(make_boat: Callable[..., Boat]) -> None:
    """A boat that was left in RTL and put into the water elsewhere sailed off to its old home."""
    boat = make_boat(HOME_ON_ARM=1)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    lat_deg, lon_deg = boat.point(100.0, 0.0)
    boat.nav = replace(boat.nav, north_m=100.0, lat_deg=lat_deg, lon_deg=lon_deg)
    boat.step()
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step(60.0)
    assert boat.status.mode is ModeId.RTL and boat.away_m(100.0, 0.0) < 1.0


def test_home_stays_where_the_mode_cannot_begin(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(HOME_ON_ARM=1)
    before = boat.status.home
    boat.helm.modes[ModeId.MANUAL].enter = lambda inputs: "not now"
    lat_deg, lon_deg = boat.point(100.0, 0.0)
    boat.nav = replace(boat.nav, north_m=100.0, lat_deg=lat_deg, lon_deg=lon_deg)
    boat.step()
    assert not boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    assert boat.status.home == before and not boat.status.armed
