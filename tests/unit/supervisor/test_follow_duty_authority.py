"""Following as a duty: whose word counts, and whose sticks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from companion.core.decision import ModeId
from companion.core.readings import Wish
from companion.core.setpoint import NeutralSetpoint, ThrusterSetpoint
from tests.unit.following.lead_boat import LeadBoat
from tests.unit.supervisor.follower import following, remote_system, stick_refusal

# --- whose word counts ---------------------------------------------------------------------------------------------

ROWS: list[tuple[str, Callable[[Any, LeadBoat], object], ModeId]] = [
    ("wish autonomous", lambda boat, lead: lead.press(Wish.AUTONOMOUS), ModeId.FOLLOW),
    ("wish manual", lambda boat, lead: lead.press(Wish.MANUAL), ModeId.MANUAL),
    ("wish remote", lambda boat, lead: lead.press(Wish.REMOTE), ModeId.MANUAL),
    ("station", lambda boat, lead: boat.supervisor.request_mode(ModeId.RTL, boat.now_s), ModeId.RTL),
    ("switch", lambda boat, lead: setattr(boat, "rc", (0.0, 0.0, 0.0, 0.0, 1.0)), ModeId.MANUAL),
]


@pytest.mark.parametrize("armed", [True, False])
@pytest.mark.parametrize("first", ROWS, ids=[row[0] for row in ROWS])
@pytest.mark.parametrize("second", ROWS, ids=[row[0] for row in ROWS])
def test_the_newest_decision_counts_but_the_switch_beats_all(
    boat: Any, lead: LeadBoat, first: Any, second: Any, armed: bool
) -> None:
    boat.sticks = (0.0, 0.0, 0.0)
    lead.run(2.0)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    if armed:
        assert boat.supervisor.arm(boat.now_s).accepted
    for _, decide, mode in (first, second):
        decide(boat, lead)
        lead.run(0.5)
        assert boat.status.mode is (ModeId.MANUAL if boat.rc is not None else mode) and boat.status.armed is armed
    lead.run(5.0)  # repeated at 20 Hz, it decides nothing more
    assert boat.status.mode is (ModeId.MANUAL if boat.rc is not None else second[2])
    if boat.rc is not None and second[2] in (ModeId.FOLLOW, ModeId.RTL):
        assert any("safe switch of the transmitter is on" in text for text in boat.texts())


def test_ground_stations_alone_decide_with_foll_auth_0(make_boat: Any) -> None:
    boat = make_boat(FOLL_AUTH=0)
    lead = LeadBoat(boat)
    following(boat, lead)
    for wish in (Wish.MANUAL, Wish.REMOTE, Wish.AUTONOMOUS):
        lead.press(wish)
        lead.run(0.3)
    assert boat.status.mode is ModeId.FOLLOW and remote_system(boat) is None
    assert "Lead boat: Manual refused: FOLL_AUTH is 0" in boat.texts()


@pytest.mark.parametrize("wish", [Wish.MANUAL, Wish.REMOTE, Wish.AUTONOMOUS])
def test_a_wish_heard_for_the_first_time_is_no_decision(boat: Any, wish: Wish) -> None:
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    lead = LeadBoat(boat, wish=wish)
    lead.presses = 7
    lead.run(3.0)
    assert boat.status.mode is ModeId.HOLD and "leader_wish" not in boat.names()


def test_a_module_that_restarts_decides_nothing_until_somebody_presses(boat: Any, lead: LeadBoat) -> None:
    lead.run(1.0)
    lead.press(Wish.AUTONOMOUS)
    lead.run(1.0)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    lead.on = False
    lead.run(3.0)
    lead.on, lead.wish, lead.presses = True, Wish.MANUAL, 0
    lead.run(3.0)
    assert boat.status.mode is ModeId.HOLD
    lead.press(Wish.MANUAL)
    lead.run(0.2)
    assert boat.status.mode is ModeId.MANUAL


def test_the_same_wish_pressed_again_is_a_decision(boat: Any, lead: LeadBoat) -> None:
    lead.run(1.0)
    lead.press(Wish.AUTONOMOUS)
    lead.run(1.0)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    lead.run(2.0)
    assert boat.status.mode is ModeId.HOLD
    lead.press(Wish.AUTONOMOUS)
    lead.run(0.2)
    assert boat.status.mode is ModeId.FOLLOW


def test_a_press_that_only_one_message_of_many_told_of_counts_also_after_a_cut(boat: Any, lead: LeadBoat) -> None:
    lead.run(1.0)
    lead.on = False
    lead.run(2.0)
    lead.press(Wish.AUTONOMOUS)
    lead.press(Wish.MANUAL)
    lead.press(Wish.AUTONOMOUS)
    lead.run(2.0)
    lead.on = True
    lead.run(0.5)
    assert boat.names().count("leader_wish") == 1


def test_messages_that_were_overtaken_are_not_decisions(boat: Any, lead: LeadBoat) -> None:
    """Reordered on their way, also where the vessel cannot see by their time that they are older, and over the
    counter's end."""
    lead.presses, lead.wish = 254, Wish.MANUAL
    lead.run(1.0)
    for wish, presses in (
        (Wish.AUTONOMOUS, 255),
        (Wish.MANUAL, 254),
        (Wish.AUTONOMOUS, 255),
        (Wish.REMOTE, 1),
        (Wish.AUTONOMOUS, 255),
        (Wish.REMOTE, 1),
    ):
        lead.wish, lead.presses = wish, presses
        lead.run(0.1)
    assert [text for name, text in boat.said if name == "leader_wish"] == [
        "Lead boat asks for Follow",
        "Lead boat asks for remote control",
    ]


def test_a_module_without_a_counter_decides_by_changes(boat: Any, lead: LeadBoat) -> None:
    lead.wish = Wish.MANUAL
    lead.run(1.0)
    lead.wish = Wish.AUTONOMOUS
    lead.run(1.0)
    assert boat.status.mode is ModeId.FOLLOW
    lead.wish = Wish.NONE
    lead.run(1.0)
    assert boat.status.mode is ModeId.FOLLOW and boat.names().count("leader_wish") == 1


def test_another_leaders_wish_is_no_decision(make_boat: Any) -> None:
    boat = make_boat(FOLL_SYSID=42)
    one, other = LeadBoat(boat), LeadBoat(boat, wish=Wish.AUTONOMOUS, system=43)
    one.run(1.0)
    boat.parameters.set("FOLL_SYSID", 43)
    other.run(2.0)
    assert "leader_wish" not in boat.names() and boat.status.mode is ModeId.MANUAL


# --- remote control ------------------------------------------------------------------------------------------------


def test_the_sticks_of_a_lead_boat_alone_steer_by_remote(boat: Any, lead: LeadBoat) -> None:
    lead.run(1.0)
    assert stick_refusal(boat, 255) is None
    assert "not asked for remote" in stick_refusal(boat, 42)
    boat.parameters.set("MAN_GCS_SYSID", 42)
    assert stick_refusal(boat, 42) is None
    boat.parameters.set("MAN_GCS_SYSID", 255)
    lead.press(Wish.REMOTE)
    lead.run(0.2)
    assert remote_system(boat) == 42 and stick_refusal(boat, 42) is None
    assert stick_refusal(boat, 255) == "lead boat 42 steers: choose a mode"
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    assert remote_system(boat) is None and stick_refusal(boat, 255) is None
    assert "not asked for remote" in stick_refusal(boat, 42)
    lead.press(Wish.REMOTE)
    lead.run(0.2)
    assert remote_system(boat) == 42
    boat.parameters.set("FOLL_AUTH", 0)
    lead.run(0.2)
    assert remote_system(boat) is None and stick_refusal(boat, 255) is None


def test_who_takes_the_sticks_over_must_centre_them(boat: Any, lead: LeadBoat) -> None:
    boat.sticks = (0.0, 0.0, 0.0)
    lead.run(1.0)
    boat.supervisor.arm(boat.now_s)
    boat.sticks = (0.5, 0.0, 0.0)
    lead.run(0.3)
    assert isinstance(boat.setpoint, ThrusterSetpoint)
    lead.press(Wish.REMOTE)
    lead.run(0.3)
    assert boat.status.mode is ModeId.MANUAL and isinstance(boat.setpoint, NeutralSetpoint)
    boat.sticks = (0.0, 0.0, 0.0)
    lead.run(0.2)
    boat.sticks = (0.5, 0.0, 0.0)
    lead.run(0.2)
    assert isinstance(boat.setpoint, ThrusterSetpoint)
    lead.press(Wish.MANUAL)
    lead.run(0.3)
    assert isinstance(boat.setpoint, NeutralSetpoint)


def test_sticks_that_one_had_centred_are_not_centred_for_the_other(boat: Any, lead: LeadBoat) -> None:
    boat.sticks = (0.0, 0.0, 0.0)
    lead.run(1.0)
    boat.supervisor.arm(boat.now_s)
    lead.run(0.3)
    lead.press(Wish.REMOTE)
    lead.send(boat.now_s + 0.01)  # the press, before the sticks
    boat.sticks = (0.5, 0.0, 0.0)
    lead.run(0.4)
    assert boat.status.mode is ModeId.MANUAL and isinstance(boat.setpoint, NeutralSetpoint)


def test_remote_sticks_that_are_silent_are_not_replaced_by_the_transmitter(boat: Any, lead: LeadBoat) -> None:
    boat.rc = (0.0, 0.0, 0.0, 0.0, -1.0)
    lead.run(1.0)
    boat.supervisor.arm(boat.now_s)
    lead.press(Wish.REMOTE)
    lead.run(0.4)
    assert boat.status.mode is ModeId.MANUAL
    boat.rc = (0.0, 0.8, 0.0, 0.0, -1.0)
    lead.run(0.1)
    assert boat.status.mode is ModeId.MANUAL and isinstance(boat.setpoint, NeutralSetpoint)
    lead.run(0.3)
    assert boat.status.mode is ModeId.HOLD and "sticks_lost" in boat.names()


def test_the_transmitter_steers_with_its_switch_whoever_has_remote(boat: Any, lead: LeadBoat) -> None:
    boat.rc = (0.0, 0.0, 0.0, 0.0, 1.0)
    lead.run(1.0)
    boat.supervisor.arm(boat.now_s, force=True)
    lead.press(Wish.REMOTE)
    boat.sticks = (0.0, 0.0, 0.0)
    lead.run(0.4)
    boat.rc = (0.0, 0.7, 0.0, 0.0, 1.0)
    lead.run(0.4)
    assert isinstance(boat.setpoint, ThrusterSetpoint) and boat.setpoint.thrusters[0].force_n > 1.0
