"""When retractable thrusters are down, and what is said while they are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.core.decision import ModeId, Result
from tests.unit.conftest import Boat

BOW = frozenset({2})


def rc(switch: float) -> tuple[float, ...]:
    return (0.0, 0.0, 0.0, 0.0, -1.0, switch, -1.0, -1.0)


def armed(boat: Boat, mode: ModeId) -> None:
    boat.sticks = (0.0, 0.0, 0.0)
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()


def test_nothing_moves_by_itself_until_a_mode_needs_it(boat: Boat) -> None:
    boat.step(5.0)
    assert boat.supervisor.retraction.lower is None
    armed(boat, ModeId.MANUAL)
    assert boat.supervisor.retraction.lower is None


@pytest.mark.parametrize("mode", [ModeId.FORCES, ModeId.HEADING, ModeId.HOLD, ModeId.RTL])
def test_modes_that_allocate_have_it_down_and_keep_it(boat: Boat, mode: ModeId) -> None:
    boat.supervisor.lower_thrusters(False, boat.now_s)
    armed(boat, mode)
    assert boat.supervisor.retraction.lower is True
    outcome = boat.supervisor.lower_thrusters(False, boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED and mode.value in outcome.reason
    assert boat.supervisor.retraction.lower is True
    boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s)
    boat.step()
    assert boat.supervisor.retraction.lower is True, "it stays until the operator retracts it"
    assert boat.supervisor.lower_thrusters(False, boat.now_s).accepted and boat.supervisor.retraction.lower is False


def test_disarmed_the_operator_may_retract_it_in_any_mode(boat: Boat) -> None:
    armed(boat, ModeId.HOLD)
    boat.supervisor.disarm(boat.now_s)
    boat.step()
    assert boat.supervisor.retraction.lower is True
    assert boat.supervisor.lower_thrusters(False, boat.now_s).accepted
    boat.step()
    assert boat.supervisor.retraction.lower is False


def test_the_transmitters_switch_acts_when_it_is_moved(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(MAN_RC_LOWER_CH=6)
    boat.rc = rc(-1.0)
    armed(boat, ModeId.MANUAL)
    for switch, lower in ((-1.0, None), (0.0, None), (1.0, True), (0.0, True), (-1.0, False), (float("nan"), False)):
        boat.rc = rc(switch)
        boat.step(0.3)
        assert boat.supervisor.retraction.lower is lower
    boat.supervisor.lower_thrusters(True, boat.now_s)
    boat.rc = rc(-1.0)
    boat.step(1.0)
    assert boat.supervisor.retraction.lower is True, "the last word counts"
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    for switch in (1.0, -1.0):
        boat.rc = rc(switch)
        boat.step(0.3)
    assert boat.supervisor.retraction.lower is True and boat.said[-1] == (
        "refused",
        "Retract refused: Hold needs it; choose Manual",
    )


@pytest.mark.parametrize("keeps_reading", [False, True])
def test_a_switch_that_was_moved_while_the_transmitter_was_silent_does_nothing(
    make_boat: Callable[..., Boat], keeps_reading: bool
) -> None:
    boat = make_boat(MAN_RC_LOWER_CH=6)
    boat.rc = rc(-1.0)
    boat.step(1.0)
    boat.rc, boat.rc_silent_s = (boat.rc, boat.now_s) if keeps_reading else (None, None)
    boat.step(2.0)
    boat.rc, boat.rc_silent_s = rc(1.0), None
    boat.step(1.0)
    assert boat.supervisor.retraction.lower is None
    for switch in (-1.0, 1.0):
        boat.rc = rc(switch)
        boat.step()
    assert boat.supervisor.retraction.lower is True


def test_what_a_mode_lacks_is_said_once(boat: Boat) -> None:
    boat.supervisor.retraction.see(BOW, boat.now_s)
    assert "thruster_up" not in boat.names(), "not while disarmed"
    armed(boat, ModeId.HOLD)
    for _ in range(30):
        boat.supervisor.retraction.see(BOW, boat.now_s)
        boat.step()
    texts = [text for name, text in boat.said if name == "thruster_up"]
    assert texts == [
        "Hold: bow not down, sideways at most 5 of 25 N"
    ]  # 0.15 m · 50 N / 1.65 m = 4.5 N and the tolerance of the balance
    boat.supervisor.request_mode(ModeId.FORCES, boat.now_s)
    boat.supervisor.retraction.see(BOW, boat.now_s)
    boat.supervisor.retraction.see(frozenset(), boat.now_s)
    boat.supervisor.retraction.see(BOW, boat.now_s)
    boat.step()
    texts = [text for name, text in boat.said if name == "thruster_up"]
    assert texts[1].startswith("Forces: ")


def test_a_boat_without_one_refuses(make_boat: Callable[..., Boat], revolt: VesselConfig) -> None:
    boat = make_boat(
        replace(revolt, thrusters=tuple(replace(t, retractable=False, travel_s=0.0) for t in revolt.thrusters))
    )
    assert boat.supervisor.lower_thrusters(True, boat.now_s).result is Result.DENIED
    armed(boat, ModeId.HOLD)
    assert boat.supervisor.retraction.lower is None


@pytest.mark.parametrize(("lower", "word"), [(True, "lower"), (False, "retract")])
def test_a_refusal_names_what_was_asked(make_boat: Callable[..., Boat], lower: bool, word: str) -> None:
    boat = make_boat(load(find("aboat")), ready=False)
    outcome = boat.supervisor.lower_thrusters(lower, boat.now_s)
    assert outcome.reason == f"{word.capitalize()} refused: no retractable thruster"
