"""The transmitter's switches: what they do when moved, and that they do nothing else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from companion.core.decision import ModeId, Result
from companion.core.readings import RcInput
from companion.core.setpoint import NeutralSetpoint, ThrusterSetpoint
from companion.core.tick import Inputs
from companion.params.table import TABLE
from companion.params.transmitter import SWITCH_MODES
from companion.supervisor.authority import Right
from companion.supervisor.mode_changes import Cause
from companion.supervisor.switches import mode_position
from tests.unit.conftest import Boat

MAPPED = {
    "MAN_RC_SAFE_CH": 0.0,
    "RC_MAP_KILL_SW": 5.0,
    "RC_MAP_ARM_SW": 6.0,
    "RC_MAP_RETURN_SW": 7.0,
    "RC_MAP_LOITER_SW": 8.0,
}
MODES = {
    "MAN_RC_SAFE_CH": 0.0,
    "RC_MAP_FLTMODE": 5.0,
    "RC_MAP_RETURN_SW": 7.0,
    "COM_FLTMODE1": 0.0,
    "COM_FLTMODE4": 4.0,
}
OFF = (0.0, 0.0, -1.0, 0.0, -1.0, -1.0, -1.0, -1.0)


def rc(boat: Boat, **on: float) -> None:
    """`c7=1.0`: channel 7 there, and the rest as they are."""
    channels = list(boat.rc or OFF)
    for name, position in on.items():
        channels[int(name[1:]) - 1] = position
    boat.rc = tuple(channels)
    boat.step(0.5)


@pytest.fixture
def boat(make_boat: Callable[..., Boat]) -> Boat:
    boat = make_boat(**MAPPED)
    rc(boat)
    return boat


@pytest.fixture
def modes(make_boat: Callable[..., Boat]) -> Boat:
    boat = make_boat(**MODES)
    rc(boat)
    return boat


def armed(boat: Boat, mode: ModeId = ModeId.HOLD) -> None:
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()


# --- kill ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", [ModeId.MANUAL, ModeId.HOLD])
def test_kill_stops_at_once_and_until_somebody_arms_again(boat: Boat, mode: ModeId) -> None:
    armed(boat, mode)
    boat.rc = (*OFF[:4], 1.0, *OFF[5:])
    boat.step()
    assert not boat.status.armed and isinstance(boat.setpoint, NeutralSetpoint), "in the very tick"
    assert "Kill switch is on: thrusters stopped" in boat.texts() and "Disarmed" in boat.texts()
    why = "kill switch of the transmitter is on"
    assert boat.status.arming_refusals == (why,)
    for force in (False, True):
        outcome = boat.supervisor.arm(boat.now_s, force)
        assert outcome.result is Result.TEMPORARILY_REJECTED and outcome.reason == why
    assert boat.supervisor.arm(boat.now_s, right=Right.TRANSMITTER).reason == why
    boat.parameters.set("ARM_CHECKS", 0)
    assert boat.supervisor.arm(boat.now_s).reason == why
    rc(boat, c5=-1.0)
    assert not boat.status.armed and "Kill switch is off: the boat can be armed" in boat.texts()
    assert boat.supervisor.arm(boat.now_s).accepted and boat.status.mode is mode


def test_kill_counts_by_its_position_also_at_the_start_and_while_the_transmitter_is_silent(
    make_boat: Callable[..., Boat],
) -> None:
    boat = make_boat(**MAPPED)
    rc(boat, c5=1.0)
    assert "Kill switch is on: thrusters stopped" in boat.texts()
    assert not boat.supervisor.arm(boat.now_s).accepted
    boat.rc = None
    boat.step(20.0)
    assert not boat.supervisor.arm(boat.now_s, force=True).accepted
    boat.parameters.set("RC_MAP_KILL_SW", 0)
    boat.step()
    assert boat.supervisor.arm(boat.now_s).accepted


def test_kill_outranks_the_safe_switch_and_the_arm_switch(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(**(MAPPED | {"MAN_RC_SAFE_CH": 8.0, "RC_MAP_LOITER_SW": 0.0}))
    rc(boat)
    armed(boat, ModeId.MANUAL)
    rc(boat, c8=1.0)
    assert boat.status.armed and boat.status.mode is ModeId.MANUAL
    rc(boat, c5=1.0)
    assert not boat.status.armed
    rc(boat, c6=1.0)
    assert not boat.status.armed and "PreArm: kill switch of the transmitter is on" in boat.texts()


def test_a_kill_switch_on_a_channel_that_is_not_there_forbids_arming(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(**(MAPPED | {"RC_MAP_KILL_SW": 7.0}))
    boat.rc = OFF[:6]
    boat.step()
    assert "Transmitter has no channel 7: RC_MAP_KILL_SW" in boat.texts()
    assert boat.status.arming_refusals == ("transmitter has no channel 7 for its kill switch",)
    boat.rc = None
    boat.step(2.0)
    assert boat.status.arming_refusals == (), "without a transmitter there is no switch to rely on"


# --- arm -----------------------------------------------------------------------------------------------------------


def test_arm_switch_arms_and_disarms_when_moved(boat: Boat) -> None:
    rc(boat, c6=1.0)
    assert boat.status.armed
    rc(boat, c6=-1.0)
    assert not boat.status.armed
    boat.wet = True
    rc(boat, c6=1.0)
    assert not boat.status.armed and "PreArm: water in the hull" in boat.texts()
    boat.wet = False
    boat.step(5.0)
    assert not boat.status.armed, "a switch that is on does not arm by itself"


def test_arm_switch_arms_with_the_safe_switch_on(make_boat: Callable[..., Boat]) -> None:
    """Its holder steers, and nobody else."""
    boat = make_boat(RC_MAP_ARM_SW=6)
    rc(boat, c5=1.0)
    assert not boat.supervisor.arm(boat.now_s).accepted
    rc(boat, c6=1.0)
    assert boat.status.armed and isinstance(boat.setpoint, ThrusterSetpoint)


# --- modes ---------------------------------------------------------------------------------------------------------


def test_return_and_hold_switch(boat: Boat) -> None:
    armed(boat, ModeId.MANUAL)
    rc(boat, c7=1.0)
    assert boat.status.mode is ModeId.RTL and boat.supervisor.mode_cause is Cause.TRANSMITTER
    rc(boat, c8=1.0)
    assert boat.status.mode is ModeId.HOLD
    rc(boat, c8=-1.0)
    assert boat.status.mode is ModeId.RTL, "the return switch is still on"
    rc(boat, c7=-1.0)
    assert boat.status.mode is ModeId.RTL and "Return switch is off: the mode stays" in boat.texts()


def test_a_switch_acts_once_and_a_ground_station_goes_on_from_there(boat: Boat) -> None:
    armed(boat, ModeId.MANUAL)
    rc(boat, c7=1.0)
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    boat.step(5.0)
    assert boat.status.mode is ModeId.MANUAL


def test_offboard_switch_says_why_it_is_refused(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_RC_SAFE_CH=0, RC_MAP_OFFB_SW=6)
    rc(boat)
    armed(boat)
    rc(boat, c6=1.0)
    assert boat.status.mode is ModeId.HOLD and any(text.startswith("Offboard refused: ") for text in boat.texts())


def test_mode_switch(modes: Boat) -> None:
    assert "Mode switch at 1, Manual: it acts when moved" in modes.texts()
    armed(modes, ModeId.HEADING)
    modes.step(5.0)
    assert modes.status.mode is ModeId.HEADING
    rc(modes, c5=0.0)
    assert modes.status.mode is ModeId.HOLD and modes.supervisor.mode_cause is Cause.TRANSMITTER
    rc(modes, c5=1.0)
    assert modes.status.mode is ModeId.HOLD and "Mode switch at 6: COM_FLTMODE6 names no mode" in modes.texts()
    rc(modes, c5=-1.0)
    assert modes.status.mode is ModeId.MANUAL
    rc(modes, c7=1.0)
    assert modes.status.mode is ModeId.RTL
    rc(modes, c7=-1.0)
    assert modes.status.mode is ModeId.MANUAL, "back to the mode switch"


def test_positions_passed_on_the_way_do_not_act(modes: Boat) -> None:
    armed(modes, ModeId.HEADING)
    modes.parameters.set("COM_FLTMODE6", 8)
    modes.rc = (*OFF[:4], 0.0, *OFF[5:])
    modes.step()
    rc(modes, c5=1.0)
    assert modes.status.mode is ModeId.HEADING and ("mode_changed", "Mode Hold") not in modes.said


def test_the_safe_switch_beats_the_mode_switch(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(**(MODES | {"MAN_RC_SAFE_CH": 6.0}))
    rc(boat)
    armed(boat)
    rc(boat, c6=1.0)
    assert boat.status.mode is ModeId.MANUAL
    rc(boat, c5=0.0)
    assert boat.status.mode is ModeId.MANUAL
    assert "Hold refused: safe switch of the transmitter is on" in boat.texts()


def test_numbers_name_every_mode_and_the_metadata_says_so() -> None:
    assert sorted(SWITCH_MODES.values(), key=str) == sorted(ModeId, key=str)
    spec = next(spec for spec in TABLE if spec.name == "COM_FLTMODE3")
    assert spec.choices == {-1: "None"} | {number: mode.value for number, mode in SWITCH_MODES.items()}


def test_positions_are_those_that_qgroundcontrol_lights() -> None:
    """PX4's formula, which QGroundControl shows the active position by."""

    def lit(value: float) -> int:
        return min(5, int(((value + 1.05) * 6.0 + 1.0 / 6.0) / 2.1 + 1.0 / 6.0))

    for step in range(-1000, 1001):
        value = step / 1000.0
        assert mode_position(value) in {lit(value - 0.001), lit(value), lit(value + 0.001)}, value
    assert [mode_position(v) for v in (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0)] == [0, 1, 2, 3, 4, 5]


# --- start and silence ---------------------------------------------------------------------------------------------


def test_a_switch_that_is_on_at_the_start_does_nothing_until_it_is_moved(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(**MAPPED)
    rc(boat, c6=1.0, c7=1.0)
    boat.step(5.0)
    assert not boat.status.armed and boat.status.mode is ModeId.MANUAL
    assert {"Arm switch is on: it acts when moved", "Return switch is on: it acts when moved"} <= set(boat.texts())
    rc(boat, c7=-1.0)
    rc(boat, c7=1.0)
    assert boat.status.mode is ModeId.RTL


@pytest.mark.parametrize("lost", [True, False])
def test_while_the_transmitter_is_lost_no_switch_acts(boat: Boat, lost: bool) -> None:
    """Neither by what a receiver that has lost its signal puts out, nor by what has moved meanwhile."""
    armed(boat, ModeId.HOLD)
    moved = (*OFF[:4], *([1.0] * 4))

    def tick(channels: tuple[float, ...] | None, is_lost: bool) -> None:
        boat.rc = None
        boat.now_s = round(boat.now_s + 0.1, 6)
        boat.supervisor.ground_station_heard(boat.now_s)
        reading = None if channels is None else RcInput(boat.now_s, "rc", channels, is_lost)
        boat.status = boat.supervisor.update(boat.nav, Inputs(rc=reading), (), boat.now_s)

    for _ in range(20):
        tick(moved if lost else None, True)
    assert boat.status.armed and boat.status.mode is ModeId.HOLD
    for _ in range(20):
        tick((*OFF[:4], -1.0, 1.0, 1.0, 1.0), False)
    assert boat.status.armed and boat.status.mode is ModeId.HOLD, "read anew"


def test_a_short_gap_is_no_silence(boat: Boat) -> None:
    armed(boat, ModeId.MANUAL)
    boat.rc = None
    boat.step(0.3)
    rc(boat, c7=1.0)
    assert boat.status.mode is ModeId.RTL


def test_a_switch_that_is_mapped_anew_is_read_anew(boat: Boat) -> None:
    armed(boat, ModeId.MANUAL)
    rc(boat, c8=1.0)
    assert boat.status.mode is ModeId.HOLD
    boat.parameters.set("RC_MAP_RETURN_SW", 8)
    boat.step(1.0)
    assert boat.status.mode is ModeId.HOLD and "Return switch is on: it acts when moved" in boat.texts()


# --- thresholds and faults -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("threshold", "off", "on"), [(0.75, 0.4, 0.6), (0.25, -0.6, -0.4), (-0.25, -0.4, -0.6)])
def test_threshold_is_a_share_of_the_travel_and_its_sign_the_side(
    make_boat: Callable[..., Boat], threshold: float, off: float, on: float
) -> None:
    boat = make_boat(MAN_RC_SAFE_CH=0, RC_MAP_RETURN_SW=6, RC_RETURN_TH=threshold)
    rc(boat, c6=off)
    armed(boat, ModeId.MANUAL)
    assert "switch_on" not in boat.names()
    rc(boat, c6=on)
    assert boat.status.mode is ModeId.RTL


def test_a_reversed_and_calibrated_channel(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_RC_SAFE_CH=0, RC_MAP_RETURN_SW=6, RC6_REV=-1, RC6_MIN=1200, RC6_MAX=1800)
    rc(boat, c6=0.6)
    armed(boat, ModeId.MANUAL)
    rc(boat, c6=-0.6)
    assert boat.status.mode is ModeId.RTL


def test_a_channel_with_two_tasks_is_announced(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(RC_MAP_FLTMODE=5, RC_MAP_ARM_SW=2)
    rc(boat)
    assert "Channel 5 twice: MAN_RC_SAFE_CH, RC_MAP_FLTMODE" in boat.texts()
    assert "Channel 2 twice: RC_MAP_ARM_SW, RC_MAP_PITCH" in boat.texts()


@pytest.mark.parametrize("by_throttle", [False, True])
def test_a_stick_on_a_channel_that_is_not_there_is_announced(make_boat: Callable[..., Boat], by_throttle: bool) -> None:
    """Neither the other sticks nor the safe switch count then."""
    boat = make_boat(RC_MAP_YAW=9, RC_MAP_THROTTLE=10, MAN_AXIS_SURGE=int(by_throttle))
    boat.rc = (0.0,) * 8
    boat.step()
    throttle = ["Transmitter has no channel 10: RC_MAP_THROTTLE"] if by_throttle else []
    said = [text for text in boat.texts() if text.startswith("Transmitter")]
    assert sorted(said) == [*throttle, "Transmitter has no channel 9: RC_MAP_YAW"]


def test_sticks_by_the_map(make_boat: Callable[..., Boat]) -> None:
    boat: Any = make_boat(MAN_RC_SAFE_CH=0, RC_MAP_ROLL=0, RC_MAP_PITCH=6, RC_MAP_YAW=1)
    boat.rc = (0.4, 0.9, 0.9, 0.9, 0.9, 0.2)
    boat.step()
    live = boat.supervisor.parts.sticks.live(boat.now_s)
    assert (live.surge, live.sway, live.yaw) == (pytest.approx(0.2), None, pytest.approx(0.4))
    boat.rc = (0.4, 0.9, 0.9, 0.9, 0.9)
    boat.step(1.0)
    assert boat.supervisor.parts.sticks.live(boat.now_s) is None, "its channel is missing"
