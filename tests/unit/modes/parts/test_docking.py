"""Dock, phase by phase: a boat that follows its setpoint until something solid is in the way."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.core.decision import MissionState, ModeId
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint
from companion.mission.plan import PlanItem, Plans
from companion.modes.parts.berth import Berth, BerthChoice
from tests.unit.conftest import Boat
from tests.unit.modes.parts.test_berth import landing

STIFFNESS_NPM = 40.0
STANDOFF_M = 2.0
WAVE_S = 1.5


class Quay:
    """Keeps the ideal boat out of the berth, and says what force the thrusters would give."""

    def __init__(self, boat: Boat, solid_at_m: float = 0.0) -> None:
        self.boat = boat
        self.solid_at_m = solid_at_m
        self.along_m = 0.0
        dock = boat.config.dock
        self.berth: Berth = BerthChoice(boat.config, Plans(), lambda: boat.frame).at(
            dock.lat_deg, dock.lon_deg, dock.yaw_rad
        )
        self.force_n = 0.0
        self.free_n = 0.0
        self._follow: Callable[[Any], None] = boat.obey
        boat.obey = self.follow

    @property
    def off_m(self) -> float:
        return self.berth.place(self.boat.nav.north_m, self.boat.nav.east_m)[0]

    def follow(self, setpoint: Any) -> None:
        boat, berth = self.boat, self.berth
        self._follow(setpoint)
        self.force_n = self.free_n
        if isinstance(setpoint, PoseSetpoint):
            off_m, along_m = berth.place(boat.nav.north_m, boat.nav.east_m)
            lag_m = self.solid_at_m - off_m
            if lag_m > 0.0:
                north_m, east_m, _ = berth.pose(self.solid_at_m, along_m)
                boat.nav = replace(
                    boat.nav, north_m=north_m, east_m=east_m, surge_mps=0.0, sway_mps=0.0, north_mps=0.0, east_mps=0.0
                )
            self.force_n += STIFFNESS_NPM * max(lag_m, 0.0)
        x, y = berth.towards
        boat.supervisor.thrust_achieved(Wrench(self.force_n * x, self.force_n * y, 0.0))


@pytest.fixture
def far_quay(boat: Boat) -> Quay:
    """Its boat lies 25 m off: two thirds of the time go by before it lines up."""
    return Quay(boat)


@pytest.fixture
def quay(boat: Boat, far_quay: Quay) -> Quay:
    """Its boat lies near it."""
    north_m, east_m, yaw_rad = far_quay.berth.pose(STANDOFF_M + 3.0, 1.0)
    boat.nav = replace(boat.nav, north_m=north_m, east_m=east_m, yaw_rad=yaw_rad + 1.0)
    boat.step()
    return far_quay


def dock(boat: Boat) -> None:
    assert boat.supervisor.request_mode(ModeId.DOCK, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted


def said(boat: Boat, name: str) -> Callable[[], bool]:
    return lambda: name in boat.names()


def test_the_phases_in_their_order(boat: Boat, far_quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_docked"))
    boat.step(30.0)
    phases = [name for name in boat.names() if name.startswith("dock_")]
    assert phases == ["dock_go", "dock_align", "dock_approach", "dock_push", "dock_docked"]
    assert boat.status.mode is ModeId.DOCK and boat.status.armed
    assert far_quay.force_n == pytest.approx(5.0, abs=0.1)
    assert far_quay.off_m == pytest.approx(0.0, abs=1e-6)


def test_far_it_sails_bow_first_and_keeps_clear_until_it_lies_parallel(boat: Boat, far_quay: Quay) -> None:
    dock(boat)
    boat.step(5.0)
    assert isinstance(boat.setpoint, PathSetpoint)
    while not said(boat, "dock_align")():
        boat.tick()
        bow_m = far_quay.off_m + far_quay.berth.reach_m - 0.5 * boat.config.length_m  # whatever the heading
        assert bow_m > 0.3
        if isinstance(boat.setpoint, PathSetpoint):
            assert far_quay.off_m > STANDOFF_M + 0.5
    assert far_quay.off_m == pytest.approx(STANDOFF_M, abs=0.01)


def test_near_it_goes_in_any_direction(boat: Boat, quay: Quay) -> None:
    dock(boat)
    while not said(boat, "dock_align")():
        boat.tick()
        assert isinstance(boat.setpoint, PoseSetpoint)


def test_bow_the_wrong_way_at_the_quay_it_goes_out_before_it_turns(boat: Boat, quay: Quay) -> None:
    north_m, east_m, yaw_rad = quay.berth.pose(0.1, 1.0)
    boat.nav = replace(boat.nav, north_m=north_m, east_m=east_m, yaw_rad=yaw_rad + math.pi)
    boat.step()
    dock(boat)
    while abs(math.remainder(boat.nav.yaw_rad - yaw_rad - math.pi, math.tau)) < 0.1:
        boat.tick()
    assert quay.off_m > STANDOFF_M + 0.9 * boat.config.length_m


def test_it_lines_up_for_as_long_as_it_must(boat: Boat, quay: Quay) -> None:
    boat.parameters.set("DOCK_ALIGN_T", 12.0)
    dock(boat)
    boat.until(said(boat, "dock_align"))
    from_s = boat.now_s
    boat.until(said(boat, "dock_approach"))
    assert boat.now_s - from_s == pytest.approx(12.1, abs=0.21)


@pytest.mark.parametrize("speed_mps", [0.03, 0.05, 0.1])
def test_it_comes_alongside_at_the_speed_asked_for(boat: Boat, quay: Quay, speed_mps: float) -> None:
    boat.parameters.set("DOCK_SPEED", speed_mps)
    dock(boat)
    boat.until(said(boat, "dock_approach"))
    fastest = 0.0
    while not said(boat, "dock_push")():
        boat.tick()
        fastest = max(fastest, quay.berth.closing_mps(boat.nav))
        assert boat.nav.yaw_rad == pytest.approx(math.radians(-40.0), abs=1e-3)
    assert fastest == pytest.approx(speed_mps, rel=0.01)


@pytest.mark.parametrize("push_n", [0.0, 2.0, 12.0])
def test_it_pushes_as_hard_as_asked(boat: Boat, quay: Quay, push_n: float) -> None:
    boat.parameters.set("DOCK_PUSH_N", push_n)
    dock(boat)
    boat.until(said(boat, "dock_docked"))
    boat.step(40.0)
    assert quay.force_n == pytest.approx(push_n, abs=0.1)


@pytest.mark.parametrize("sway_n", [6.0, 15.0])
def test_by_default_it_pushes_with_a_third_of_what_it_can(
    make_boat: Callable[..., Boat], revolt: VesselConfig, sway_n: float
) -> None:
    """5 N are more than a small ship model has, and nothing for a ship."""
    boat = make_boat(replace(revolt, limits=replace(revolt.limits, sway_n=sway_n)))
    boat.step()
    quay = Quay(boat)
    dock(boat)
    boat.until(said(boat, "dock_docked"))
    boat.step(40.0)
    assert quay.force_n == pytest.approx(sway_n / 3.0, rel=0.03)
    assert f"Dock: contact, pushing with {'2.0' if sway_n < 10.0 else '5'} N" in boat.texts()


def test_a_push_that_takes_a_deep_reference(boat: Boat, quay: Quay) -> None:
    """A ship's push over the stiffness of its pose control is more than half a metre."""
    boat.parameters.set("DP_BW_SWAY", 0.1)
    boat.parameters.set("DOCK_PUSH_N", 12.0)
    dock(boat)
    boat.until(said(boat, "dock_docked"))
    boat.step(100.0)
    assert quay.force_n == pytest.approx(12.0, abs=0.2)


def test_the_heading_control_does_not_push_against_the_berth(boat: Boat, quay: Quay) -> None:
    """The berth keeps the hull 2 degrees off the heading in the file. An integrator that asks for a turn would wind up,
    until the thrusters had no force left for the push."""
    dock(boat)
    boat.until(said(boat, "dock_push"))
    stiffness_nmprad = boat.config.hull.m33_kgm2 * boat.parameters["DP_BW_YAW"] ** 2
    held_rad = quay.berth.yaw_rad + math.radians(2.0)
    moments_nm = [0.3 * stiffness_nmprad]  # as wound up on the way

    def held(setpoint: Any) -> None:
        quay.follow(setpoint)
        boat.nav = replace(boat.nav, yaw_rad=held_rad)
        error_rad = math.remainder(setpoint.yaw_rad - held_rad, math.tau)
        moments_nm[0] += 0.6 * stiffness_nmprad * error_rad * 0.1
        moment_nm = stiffness_nmprad * error_rad + moments_nm[0]
        x, y = quay.berth.towards
        boat.supervisor.thrust_achieved(Wrench(quay.force_n * x, quay.force_n * y, moment_nm))
        moments_nm.append(moment_nm)

    boat.obey = held
    boat.step(60.0)
    assert max(abs(moment_nm) for moment_nm in moments_nm[-100:]) < 0.01 * stiffness_nmprad


def test_far_out_it_has_the_time_that_the_way_takes(make_boat: Callable[..., Boat], revolt: VesselConfig) -> None:
    assert revolt.dock is not None
    boat = make_boat(replace(revolt, dock=replace(revolt.dock, standoff_m=10.0)))
    boat.step()
    Quay(boat)
    dock(boat)
    boat.until(said(boat, "dock_docked"), 600.0)
    assert boat.parameters["DOCK_TIMEOUT"] < 10.0 / boat.parameters["DOCK_SPEED"]


def test_what_wind_takes_and_half_of_it_for_gusts_is_added_to_the_push(boat: Boat, quay: Quay) -> None:
    quay.free_n = 4.0
    dock(boat)
    boat.until(said(boat, "dock_docked"))
    boat.step(40.0)
    assert quay.force_n == pytest.approx(11.0, abs=0.3)


def test_at_the_berth_already_it_just_pushes(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_docked"))
    boat.supervisor.disarm(boat.now_s)
    boat.step(12.0)
    assert isinstance(boat.setpoint, NeutralSetpoint)
    boat.supervisor.arm(boat.now_s)
    boat.step(12.0)
    assert boat.names().count("dock_go") == 1 and boat.names().count("dock_push") == 2
    assert quay.off_m == pytest.approx(0.0, abs=0.01)


def test_taken_off_the_berth_it_comes_back(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_docked"))
    quay.solid_at_m = 0.4  # something between
    boat.step(3.0)
    quay.solid_at_m = 0.0
    boat.until(lambda: boat.names().count("dock_push") == 2)
    assert boat.names().count("dock_approach") == 2
    boat.step(5.0)
    assert quay.off_m == pytest.approx(0.0, abs=0.01)


# --- giving up -----------------------------------------------------------------------------------------------------


def worse_position(boat: Boat, quay: Quay) -> None:
    boat.nav = replace(boat.nav, position_accuracy_m=0.5)


def set_aside(boat: Boat, quay: Quay) -> None:
    follow = boat.obey

    def aside(setpoint: Any) -> None:
        follow(setpoint)
        north_m, east_m, _ = quay.berth.pose(quay.off_m, 0.4)
        boat.nav = replace(boat.nav, north_m=north_m, east_m=east_m)

    boat.obey = aside


def turned(boat: Boat, quay: Quay) -> None:
    follow = boat.obey

    def turn(setpoint: Any) -> None:
        follow(setpoint)
        boat.nav = replace(boat.nav, yaw_rad=quay.berth.yaw_rad + math.radians(9.0))

    boat.obey = turn


def no_berth(boat: Boat, quay: Quay) -> None:
    quay.solid_at_m = -5.0


def obstacle(boat: Boat, quay: Quay) -> None:
    quay.solid_at_m = 1.2


def thruster(boat: Boat, quay: Quay) -> None:
    boat.supervisor.thruster_failed(2, True)


def no_headway(boat: Boat, quay: Quay) -> None:
    boat.parameters.set("DOCK_TIMEOUT", 10.0)
    boat.obey = lambda setpoint: None


@pytest.mark.parametrize(
    ("cause", "reason"),
    [
        (worse_position, "position known to 0.50 m only"),
        (set_aside, "0.40 m off the line"),
        (turned, "heading 9 deg off"),
        (no_berth, "no berth 0.4 m beyond where it should be"),
        (obstacle, "stopped 1.2 m short of the berth"),
        (thruster, "thruster bow failed"),
        (no_headway, "coming alongside took more than 62 s"),
    ],
)
def test_it_gives_up_goes_back_and_says_why(boat: Boat, quay: Quay, cause: Any, reason: str) -> None:
    dock(boat)
    boat.until(said(boat, "dock_approach"))
    boat.step(5.0)
    cause(boat, quay)
    boat.until(said(boat, "dock_aborted"), 100.0)
    assert f"Docking given up: {reason}" in boat.texts()
    boat.obey = quay.follow
    boat.until(said(boat, "dock_clear"), 200.0)
    boat.step(20.0)
    assert quay.off_m == pytest.approx(STANDOFF_M, abs=0.02)
    assert boat.status.mode is ModeId.DOCK and isinstance(boat.setpoint, PoseSetpoint)
    assert "dock_push" not in boat.names()


def test_given_up_on_the_way_it_holds_where_it_has_room_to_turn(boat: Boat, far_quay: Quay) -> None:
    """It arrives bow first: at the standoff point its bow would touch the berth."""
    dock(boat)
    boat.step(5.0)
    assert isinstance(boat.setpoint, PathSetpoint)
    thruster(boat, far_quay)
    boat.until(said(boat, "dock_clear"))
    assert far_quay.off_m == pytest.approx(STANDOFF_M + boat.config.length_m, abs=0.05)


def test_lining_up_may_not_take_for_ever(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_align"))
    turned(boat, quay)
    boat.until(said(boat, "dock_aborted"), 130.0)
    assert any("lining up took more than 120 s" in text for text in boat.texts())


def test_chosen_again_it_tries_again(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_approach"))
    thruster(boat, quay)
    boat.until(said(boat, "dock_clear"))
    outcome = boat.supervisor.request_mode(ModeId.DOCK, boat.now_s)
    assert not outcome.accepted and "thruster bow failed" in outcome.reason
    boat.supervisor.thruster_failed(2, False)
    assert boat.supervisor.request_mode(ModeId.DOCK, boat.now_s).accepted
    boat.until(said(boat, "dock_docked"))


def test_another_mode_ends_it_at_once(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_approach"))
    boat.step(10.0)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step(60.0)
    assert boat.status.mode is ModeId.HOLD and 1.0 < quay.off_m < STANDOFF_M


def test_a_thruster_that_fails_alongside_does_not_take_it_off(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_docked"))
    thruster(boat, quay)
    boat.step(10.0)
    assert "dock_aborted" not in boat.names() and quay.off_m == pytest.approx(0.0, abs=1e-6)


# --- failsafes while pushing ---------------------------------------------------------------------------------------


def pushing(boat: Boat) -> None:
    dock(boat)
    boat.until(said(boat, "dock_docked"))


def test_without_a_ground_station_it_keeps_pushing(boat: Boat, quay: Quay) -> None:
    pushing(boat)
    boat.station = False
    boat.step(30.0)
    assert "No ground station for 10 s: stays alongside, pushing" in boat.texts()
    assert boat.status.mode is ModeId.DOCK and quay.force_n == pytest.approx(5.0, abs=0.1)


def test_without_a_ground_station_on_the_way_in_it_holds(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_approach"))
    boat.station = False
    boat.step(20.0)
    assert boat.status.mode is ModeId.HOLD


def test_an_empty_battery_does_not_take_it_from_the_berth(boat: Boat, quay: Quay) -> None:
    pushing(boat)
    boat.battery = 0.1
    boat.step(10.0)
    assert boat.status.mode is ModeId.DOCK and isinstance(boat.setpoint, PoseSetpoint)


@pytest.mark.parametrize("action", [1.0, 3.0])
def test_without_a_position_it_cannot_push(boat: Boat, quay: Quay, action: float) -> None:
    boat.parameters.set("FS_POS_ACT", action)
    pushing(boat)
    boat.nav = replace(boat.nav, position_valid=False)
    boat.step(10.0)
    assert isinstance(boat.setpoint, NeutralSetpoint)


def silent_for_a_moment(boat: Boat) -> None:
    boat.silent = {device.name for device in boat.config.actuators}
    boat.step(4.0)
    boat.silent = set()
    boat.step(20.0)


@pytest.mark.parametrize("fails", [False, True])
def test_the_next_plan_does_not_take_it_from_its_berth(boat: Boat, quay: Quay, fails: bool) -> None:
    pushing(boat)
    boat.supervisor.thruster_failed(2, fails)
    boat.upload((10.0, 0.0), commands={1: landing(boat, 50.0, 20.0, -40.0)})
    boat.fence((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0))
    boat.step(20.0)
    assert boat.status.mode is ModeId.DOCK and quay.force_n == pytest.approx(5.0, abs=0.1)
    silent_for_a_moment(boat)
    assert "dock_go" not in boat.names()[boat.names().index("dock_docked") :]
    assert boat.status.mode is ModeId.DOCK and quay.force_n == pytest.approx(5.0, abs=0.1)


def test_a_fence_across_its_way_ends_it(boat: Boat, far_quay: Quay) -> None:
    dock(boat)
    boat.step(5.0)
    boat.fence((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))
    boat.step()
    assert "Dock stopped: way to the berth crosses the fence" in boat.texts() and boat.status.mode is ModeId.HOLD


def test_given_up_it_is_not_tried_again_without_being_asked(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_approach"))
    worse_position(boat, quay)
    boat.until(said(boat, "dock_clear"))
    boat.nav = replace(boat.nav, position_accuracy_m=0.02)
    silent_for_a_moment(boat)
    assert boat.names().count("dock_go") == 1
    assert isinstance(boat.setpoint, PoseSetpoint) and quay.off_m == pytest.approx(STANDOFF_M, abs=0.02)


# --- wind and waves ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("free_n", "reason"),
    [
        (13.0, "weather 13 N, thrust 15 N"),
        (-22.0, "weather 22 N, thrust 25 N off the berth"),
    ],
)
def test_wind_that_takes_most_of_the_thrust(boat: Boat, quay: Quay, free_n: float, reason: str) -> None:
    quay.free_n = free_n
    dock(boat)
    boat.until(said(boat, "dock_aborted"))
    assert any(reason in text for text in boat.texts())
    assert "dock_approach" not in boat.names()


def rocked(boat: Boat, speed_mps: float) -> Callable[[], None]:
    """Waves under the boat, of 1.5 s: across the berth and along it. Returns what ends them."""
    follow = boat.obey

    def rock(setpoint: Any) -> None:
        follow(setpoint)
        swing = speed_mps * math.sin(2.0 * math.pi * boat.now_s / WAVE_S)
        nav = boat.nav
        boat.nav = replace(nav, north_mps=nav.north_mps + swing)

    def end() -> None:
        boat.obey = follow

    boat.obey = rock
    return end


def wave_force_n(boat: Boat, speed_mps: float) -> float:
    """RMS of the force that would keep the boat from the waves of `rocked`, across a berth at -40 degrees, without
    what flat water has."""
    across_mps2 = math.sin(math.radians(40.0)) * speed_mps * 2.0 * math.pi / WAVE_S / math.sqrt(2.0)
    return boat.config.hull.m22_kg * math.sqrt(across_mps2**2 - 0.015**2)


def test_waves_do_not_keep_it_from_docking(boat: Boat, quay: Quay) -> None:
    """It pushes harder by the force that they have, and is still docked when the push has the better of them."""
    speed_mps = 0.01
    boat.parameters.set("DOCK_PUSH_N", 5.0)
    rocked(boat, speed_mps)
    dock(boat)
    boat.until(said(boat, "dock_docked"), 300.0)
    boat.step(60.0)
    assert not {"dock_waits", "dock_aborted"} & set(boat.names())
    assert quay.force_n == pytest.approx(boat.parameters["DOCK_PUSH_N"] + wave_force_n(boat, speed_mps), abs=0.5)


def test_it_waits_off_the_berth_while_the_waves_have_far_more_force_than_the_push_that_is_left(
    boat: Boat, quay: Quay
) -> None:
    calm = rocked(boat, 0.05)
    dock(boat)
    boat.until(said(boat, "dock_waits"))
    text = next(text for text in boat.texts() if text.startswith("Dock: waits off, waves "))
    assert text.endswith(" N, push left 15 N")
    assert float(text.split()[4]) == pytest.approx(wave_force_n(boat, 0.05), abs=1.0)
    boat.step(30.0)
    assert quay.off_m == pytest.approx(STANDOFF_M, abs=0.1) and "dock_approach" not in boat.names()
    calm()
    boat.until(said(boat, "dock_docked"), 300.0)


def test_waves_make_it_come_alongside_more_slowly(boat: Boat, quay: Quay) -> None:
    boat.parameters.set("DOCK_SPEED", 0.1)
    rocked(boat, 0.02)
    dock(boat)
    boat.until(said(boat, "dock_push"), 300.0)
    assert "Dock: coming alongside at 0.07 m/s" in boat.texts()


def test_waves_that_stay_too_strong_end_it(boat: Boat, quay: Quay) -> None:
    rocked(boat, 0.05)
    dock(boat)
    boat.until(said(boat, "dock_clear"), 300.0)
    assert any(text.startswith("Docking given up: waves") for text in boat.texts())
    assert "dock_approach" not in boat.names()


def test_the_operator_may_accept_such_waves(boat: Boat, quay: Quay) -> None:
    boat.parameters.set("DOCK_SEA_MAX", 100.0)
    rocked(boat, 0.05)
    dock(boat)
    boat.until(said(boat, "dock_docked"), 300.0)


def test_waves_that_grow_on_the_way_end_it(boat: Boat, quay: Quay) -> None:
    dock(boat)
    boat.until(said(boat, "dock_approach"))
    rocked(boat, 0.1)
    boat.until(said(boat, "dock_aborted"))
    assert any(text.startswith("Docking given up: waves") for text in boat.texts()) and quay.off_m > 0.5


def test_waves_beyond_the_limit_do(boat: Boat, quay: Quay) -> None:
    rocked(boat, 0.3)
    dock(boat)
    boat.until(said(boat, "dock_aborted"), 300.0)
    assert any("waves move the boat by 0.2" in text for text in boat.texts())


# --- refusals ------------------------------------------------------------------------------------------------------


def refusal(boat: Boat) -> str:
    outcome = boat.supervisor.request_mode(ModeId.DOCK, boat.now_s)
    assert not outcome.accepted and boat.status.mode is not ModeId.DOCK
    return str(outcome.reason)


def test_without_a_berth(make_boat: Callable[..., Boat], revolt: VesselConfig) -> None:
    assert "no berth" in refusal(make_boat(replace(revolt, dock=None)))


def test_a_boat_that_cannot_push_itself_sideways(make_boat: Callable[..., Boat], revolt: VesselConfig) -> None:
    jet = make_boat(replace(revolt, limits=replace(revolt.limits, sway_n=0.0)))
    assert "sideways" in refusal(jet)
    assert "sideways" in next(mode.text for mode in jet.supervisor.modes if mode.id is ModeId.DOCK)


def test_from_behind_the_berth(boat: Boat, quay: Quay) -> None:
    north_m, east_m, _ = quay.berth.pose(-3.0)
    boat.nav = replace(boat.nav, north_m=north_m, east_m=east_m)
    boat.step()
    assert "behind the berth" in refusal(boat)


# --- in a mission --------------------------------------------------------------------------------------------------


def test_a_mission_ends_at_its_berth(boat: Boat, far_quay: Quay) -> None:
    dock_config = boat.config.dock
    point = boat.frame.to_ned(dock_config.lat_deg, dock_config.lon_deg)
    boat.upload((10.0, 0.0), (10.0, -10.0), commands={2: landing(boat, *point, -40.0)})
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    boat.supervisor.arm(boat.now_s)
    boat.until(said(boat, "dock_docked"), 900.0)
    assert boat.status.mode is ModeId.MISSION
    boat.step(2.0)
    assert boat.status.mission.state is MissionState.COMPLETE and boat.status.mission.reached == 3
    assert boat.status.mode is ModeId.DOCK and boat.status.armed
    boat.step(30.0)
    assert far_quay.force_n == pytest.approx(5.0, abs=0.1) and boat.names().count("dock_go") == 1


def test_a_mission_goes_on_from_its_berth(boat: Boat, quay: Quay) -> None:
    point = boat.frame.to_ned(boat.config.dock.lat_deg, boat.config.dock.lon_deg)
    delay = PlanItem(0, 93, 2, 5.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
    boat.upload((0.0, 10.0), commands={0: landing(boat, *point, -40.0), 1: delay})
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.until(lambda: boat.status.mission.state is MissionState.COMPLETE, 900.0)
    boat.step(20.0)
    assert boat.away_m(0.0, 10.0) < 1.5 and boat.status.mode is ModeId.HOLD


def test_a_mission_whose_docking_fails_holds_off_the_berth(boat: Boat, quay: Quay) -> None:
    point = boat.frame.to_ned(boat.config.dock.lat_deg, boat.config.dock.lon_deg)
    boat.upload(commands={0: landing(boat, *point, -40.0)})
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.until(said(boat, "dock_approach"), 900.0)
    thruster(boat, quay)
    boat.until(said(boat, "dock_clear"))
    boat.step(30.0)
    assert boat.status.mission.state is MissionState.ACTIVE and quay.off_m == pytest.approx(STANDOFF_M, abs=0.02)
    silent_for_a_moment(boat)
    assert "dock_refused" not in boat.names() and quay.off_m == pytest.approx(STANDOFF_M, abs=0.02)
