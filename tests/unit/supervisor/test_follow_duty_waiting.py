"""Following as a duty: when it is refused, and how long it waits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from companion.core.decision import ModeId, Result
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint
from tests.unit.following.lead_boat import LeadBoat
from tests.unit.supervisor.follower import following


def test_follow_is_refused_with_the_reason(boat: Any, lead: LeadBoat) -> None:
    def refusal() -> str:
        outcome = boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s)
        assert outcome.result is Result.TEMPORARILY_REJECTED
        boat.step()
        assert outcome.reason in boat.texts()
        return str(outcome.reason)

    boat.parameters.set("FOLL_WAIT_T", 0.0)
    boat.supervisor.arm(boat.now_s)
    assert refusal() == "Follow refused: no leader heard"
    lead.fix = False
    lead.run(1.0)
    assert refusal() == "Follow refused: leader has no position"
    lead.fix = True
    lead.run(2.0)
    lead.on = False
    lead.run(2.0)
    assert refusal().startswith("Follow refused: leader silent for 2.")
    lead.on = True
    lead.run(2.0)
    boat.nav = replace(boat.nav, position_age_s=1.2)
    lead.run(0.1)
    assert refusal().startswith("Follow refused: own position 1.2 s old")
    boat.nav = replace(boat.nav, position_age_s=0.0)
    boat.parameters.set("FOLL_SYSID", 9)
    lead.run(0.1)
    assert refusal() == "Follow refused: leader 9 not heard"


def test_disarmed_it_may_be_chosen_early_and_arming_asks_again(boat: Any, lead: LeadBoat) -> None:
    """Ground stations send their place only once the boat is in Follow."""
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    boat.step()
    assert boat.status.mode is ModeId.FOLLOW and isinstance(boat.setpoint, NeutralSetpoint)
    for force in (False, True):
        outcome = boat.supervisor.arm(boat.now_s, force)
        assert outcome.reason == "Follow: no leader heard"
    lead.run(1.0)
    assert boat.supervisor.arm(boat.now_s).accepted
    lead.run(0.1)
    assert isinstance(boat.setpoint, PathSetpoint)


def test_an_armed_boat_may_wait_for_a_leader_that_sends_only_in_follow(make_boat: Any) -> None:
    boat = make_boat(FOLL_WAIT_T=5.0)
    phone = LeadBoat(boat, 4.0, None)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.step(1.0)
    for _ in range(2):
        phone.on = False
        assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
        phone.run(2.0)
        assert (
            boat.status.mode is ModeId.FOLLOW
            and isinstance(boat.setpoint, PoseSetpoint)
            and boat.status.failsafes == ()
        )
        phone.on = True
        phone.run(1.0)
        assert isinstance(boat.setpoint, PathSetpoint)
        phone.on = False
        phone.run(12.0)
        assert boat.status.mode is ModeId.HOLD and boat.status.failsafes == (
            "leader_lost",
        )  # and the next round begins with it
    assert "Follow waits for the leader: no leader heard" in boat.texts()


def test_it_waits_no_longer_than_told_then_falls_back(make_boat: Any) -> None:
    boat = make_boat(FOLL_WAIT_T=5.0)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    boat.step(4.9)
    assert boat.status.mode is ModeId.FOLLOW and isinstance(boat.setpoint, PoseSetpoint)
    boat.step(0.5)
    assert boat.status.mode is ModeId.HOLD and "No leader heard: Hold" in boat.texts()
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    boat.step(1.0)
    assert boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s).accepted
    boat.step(10.0)
    assert boat.status.mode is ModeId.MANUAL


def test_a_follow_that_cannot_begin_although_the_leader_is_there_is_given_up(make_boat: Any) -> None:
    boat = make_boat(FOLL_WAIT_T=5.0)
    phone = LeadBoat(boat, 4.0, None)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.helm.modes[ModeId.FOLLOW].enter = lambda inputs: "not now"
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    phone.run(4.8)
    assert boat.status.mode is ModeId.FOLLOW and isinstance(boat.setpoint, PoseSetpoint)
    phone.run(0.6)
    assert boat.status.mode is ModeId.HOLD and "Follow cannot begin: Hold" in boat.texts()


def test_it_waits_neither_for_a_module_nor_for_itself(make_boat: Any) -> None:
    boat = make_boat(FOLL_WAIT_T=5.0)
    lead = LeadBoat(boat)
    following(boat, lead)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    lead.on = False
    lead.run(2.0)
    assert not boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    boat = make_boat(FOLL_WAIT_T=5.0)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.nav = replace(boat.nav, position_valid=False)
    boat.step()
    assert not boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted


def test_a_leader_that_is_near_is_followed_and_that_is_said(boat: Any, lead: LeadBoat) -> None:
    lead.ahead_m, lead.speed_mps = 8.0, 0.0
    lead.run(2.0)
    boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s)
    assert boat.supervisor.arm(boat.now_s).accepted
    lead.run(0.2)
    assert "Leader 8 m away, below FOLL_MIN_DIST (12 m)" in boat.texts()
