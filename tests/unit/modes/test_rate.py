"""Rate: sticks demand speed and turn rate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.core.decision import ModeId
from companion.core.estimate import Distrust
from companion.core.setpoint import (
    HeadingSetpoint,
    NeutralSetpoint,
    PathSetpoint,
    Setpoint,
    WrenchSetpoint,
)
from tests.unit.conftest import DT_S, Boat

RATE_RADPS = math.radians(20.0)  # MAN_YAW_RATE


def turning(boat: Boat, share: float) -> Callable[[Setpoint], None]:
    """What the boat does: `share` of the turn that is asked for, and the speed."""

    def obey(setpoint: Setpoint) -> None:
        nav, rate_radps, surge_mps = boat.nav, 0.0, 0.0
        if isinstance(setpoint, PathSetpoint | HeadingSetpoint):
            rate_radps = share * setpoint.yaw_rate_radps
        if isinstance(setpoint, PathSetpoint):
            surge_mps = setpoint.surge_mps
        boat.nav = replace(nav, yaw_rad=nav.yaw_rad + rate_radps * DT_S, yaw_rate_radps=rate_radps, surge_mps=surge_mps)

    return obey


def armed(boat: Boat, share: float = 1.0) -> Boat:
    boat.obey = turning(boat, share)  # type: ignore[method-assign]
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step()
    assert boat.supervisor.request_mode(ModeId.RATE, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    return boat


def lead_rad(boat: Boat) -> float:
    assert isinstance(boat.setpoint, PathSetpoint | HeadingSetpoint)
    before = boat.nav.yaw_rad - boat.nav.yaw_rate_radps * DT_S
    return math.remainder(boat.setpoint.yaw_rad - before, 2.0 * math.pi)


def test_sticks_demand_speed_and_turn_rate(make_boat: Callable[..., Boat]) -> None:
    boat = armed(make_boat(MAN_SPEED=0.8))
    boat.sticks = (1.0, -1.0, 1.0)
    boat.step()
    first = boat.setpoint
    assert isinstance(first, PathSetpoint) and 0.0 < first.surge_mps < 0.1
    assert first.surge_mps2 == pytest.approx(boat.parameters["PATH_ACC"])
    boat.step(30.0)
    assert isinstance(boat.setpoint, PathSetpoint)
    assert boat.setpoint.surge_mps == pytest.approx(0.8) and boat.setpoint.surge_mps2 == pytest.approx(0.0)
    assert boat.setpoint.sway_mps == pytest.approx(-boat.parameters["DP_SPEED_SWAY"])
    assert boat.setpoint.yaw_rate_radps == pytest.approx(RATE_RADPS)
    assert lead_rad(boat) == pytest.approx(0.0, abs=0.01), "the boat turns as fast as it should"
    boat.sticks = (-1.0, 0.0, 0.0)
    boat.step(60.0)
    assert boat.setpoint.surge_mps == pytest.approx(-boat.parameters["DP_SPEED_ASTERN"])


def test_full_stick_is_the_speed_of_missions_without_man_speed(make_boat: Callable[..., Boat]) -> None:
    boat = armed(make_boat(WP_SPEED=0.6))
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(30.0)
    assert isinstance(boat.setpoint, PathSetpoint) and boat.setpoint.surge_mps == pytest.approx(0.6)


def test_a_turn_that_is_held_up_is_pressed_for_and_not_made_up_later(make_boat: Callable[..., Boat]) -> None:
    boat = armed(make_boat(), share=0.5)
    boat.sticks = (0.0, 0.0, 1.0)
    boat.step(1.0)
    pressed = lead_rad(boat)
    assert 0.1 < pressed < 0.2
    boat.step(60.0)
    assert pressed < lead_rad(boat) <= math.radians(30.0) + 1e-6
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step(15.0)
    assert lead_rad(boat) == pytest.approx(0.0, abs=0.01) and boat.setpoint.yaw_rate_radps == 0.0  # type: ignore[union-attr]


def test_without_position_sticks_give_force_and_without_a_turn_rate_all_of_them(
    make_boat: Callable[..., Boat],
) -> None:
    boat = armed(make_boat())
    boat.sticks = (1.0, 0.0, 1.0)
    boat.step(2.0)
    good = boat.nav
    lie = Distrust("gyro", "imu", "turns the other way", 0.0, excluded=True, asks=False)
    blind = replace(good, position_valid=False, heading_valid=False, imu_age_s=0.0)
    for lost in (replace(good, position_valid=False), replace(good, heading_valid=False, imu_age_s=0.1), blind):
        boat.nav = lost
        boat.step()
        assert isinstance(boat.setpoint, HeadingSetpoint), "the gyro tells the turn"
        assert boat.setpoint.wrench.surge_n == pytest.approx(50.0) and boat.setpoint.wrench.yaw_nm == 0.0
        assert boat.setpoint.yaw_rate_radps == pytest.approx(RATE_RADPS)
    for lost in (replace(blind, imu_age_s=1.0), replace(blind, distrusted=(lie,)), replace(blind, yaw_rad=math.nan)):
        boat.nav = lost
        boat.step()
        assert isinstance(boat.setpoint, WrenchSetpoint) and boat.status.mode is ModeId.RATE
        assert boat.setpoint.wrench.yaw_nm == pytest.approx(boat.config.limits.yaw_nm)
    boat.nav = good
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint) and boat.setpoint.surge_mps < 0.7, "from the boat's own speed"
    assert [text for name, text in boat.said if name.startswith("sticks_give")] == [
        "Rate: no position, sticks give force",
        "Rate: no turn rate, sticks give force and moment",
        "Rate: sticks give speed and turn rate again",
    ]


def test_no_sticks_no_thrust(make_boat: Callable[..., Boat]) -> None:
    boat = armed(make_boat(NAV_RCL_ACT=0, COM_RC_LOSS_T=1.0))
    boat.sticks = (1.0, 0.0, 1.0)
    boat.step(3.0)
    boat.sticks = None
    boat.step(3.0)
    assert isinstance(boat.setpoint, NeutralSetpoint)


def test_disarmed_is_neutral(make_boat: Callable[..., Boat]) -> None:
    boat = armed(make_boat())
    boat.sticks = (1.0, 0.0, 1.0)
    boat.step(3.0)
    boat.supervisor.disarm(boat.now_s)
    boat.step()
    assert isinstance(boat.setpoint, NeutralSetpoint)


def test_a_jet_stands_without_thrust_and_still_turns(make_boat: Callable[..., Boat]) -> None:
    boat = armed(make_boat(load(find("rescuerunner"))))
    boat.sticks = (-1.0, 0.0, 0.0)
    boat.step()
    assert isinstance(boat.setpoint, WrenchSetpoint) and boat.setpoint.wrench.surge_n == 0.0
    boat.sticks = (0.0, 0.0, 1.0)
    boat.step()
    assert isinstance(boat.setpoint, HeadingSetpoint) and boat.setpoint.yaw_rate_radps > 0.0
    boat.sticks = (1.0, 1.0, 0.0)
    boat.step(1.0)
    assert isinstance(boat.setpoint, PathSetpoint) and boat.setpoint.sway_mps == 0.0


def test_the_boat_stops_at_the_fence_by_itself(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_SPEED=1.0)
    obey = boat.obey
    boat.fence((-30.0, -30.0), (30.0, -30.0), (30.0, 30.0), (-30.0, 30.0))
    armed(boat)
    boat.obey = obey  # type: ignore[method-assign]
    boat.sticks = (1.0, 0.0, 0.0)
    boat.step(120.0)
    assert boat.status.mode is ModeId.RATE and "fence_slowed" in boat.names()
    assert 27.0 < boat.nav.north_m < 29.0 and abs(boat.nav.surge_mps) < 0.05


def test_under_sail_centred_sticks_turn_nothing(make_boat: Callable[..., Boat]) -> None:
    """Its course leads its bow by the leeway, and it steers by the bow."""
    config = load(find("sailbot"))
    boat = make_boat(config, **config.parameters)
    course_rad = math.radians(98.0)
    under_way = replace(
        boat.nav,
        yaw_rad=math.radians(90.0),
        surge_mps=1.2,
        north_mps=1.2 * math.cos(course_rad),
        east_mps=1.2 * math.sin(course_rad),
        wind_speed_mps=5.0,
        wind_from_rad=0.0,
    )
    boat.nav = under_way
    armed(boat)
    boat.obey = lambda setpoint: None  # type: ignore[method-assign]
    boat.nav, boat.sticks = under_way, (1.0, 0.0, 0.0)
    boat.step(20.0)
    assert isinstance(boat.setpoint, HeadingSetpoint) and boat.setpoint.wrench.surge_n > 0.0
    assert math.degrees(boat.setpoint.yaw_rad) == pytest.approx(90.0, abs=0.5)
    boat.sticks = (1.0, 0.0, 0.5)
    boat.step()
    assert boat.setpoint.yaw_rate_radps > 0.0
