"""Following as a duty: what is lost and comes back, and for whom the leader stands."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from companion.core.decision import ModeId, Severity
from companion.core.readings import Wish
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint, ThrusterSetpoint
from tests.unit.following.lead_boat import LeadBoat
from tests.unit.supervisor.follower import following, modes_said

# --- loss and recovery ---------------------------------------------------------------------------------------------


def cut(boat: Any, lead: LeadBoat, well: bool) -> None:
    lead.on = well


def leader_fix(boat: Any, lead: LeadBoat, well: bool) -> None:
    lead.fix = well


def own_fix(boat: Any, lead: LeadBoat, well: bool) -> None:
    """The estimate coasts on, as it does for FS_POS_T."""
    if well:
        boat.nav = replace(boat.nav, position_age_s=0.0)
        return
    tick = boat.tick

    def older() -> None:
        boat.nav = replace(boat.nav, position_age_s=boat.nav.position_age_s + 0.1)
        tick()

    lead.boat = type(
        "Coasting",
        (),
        {
            "tick": staticmethod(older),
            "now_s": property(lambda _: boat.now_s),
            "point": boat.point,
            "supervisor": boat.supervisor,
        },
    )()


WAYS = {"Leader silent": cut, "Leader without a position": leader_fix, "Own position": own_fix}


@pytest.mark.parametrize("what", WAYS)
@pytest.mark.parametrize(
    ("rate_hz", "wish", "at_most_s"),
    [(20.0, Wish.AUTONOMOUS, 1.0), (20.0, None, 1.0), (4.0, None, 1.0), (1.0, None, 3.1)],
)
def test_each_way_of_loss_leaves_follow_in_time_and_says_what_was_lost(
    boat: Any, what: str, rate_hz: float, wish: Wish | None, at_most_s: float
) -> None:
    lead = LeadBoat(boat, rate_hz, wish)
    following(boat, lead)
    since_s = boat.now_s
    WAYS[what](boat, lead, False)
    while boat.status.mode is ModeId.FOLLOW:
        lead.tick()
        assert boat.now_s - since_s <= (1.0 if what == "Own position" else at_most_s), boat.status
    assert (
        boat.status.mode is ModeId.HOLD
        and boat.status.intended_mode is ModeId.FOLLOW
        and boat.status.failsafes == ("leader_lost",)
    )
    (text,) = [text for name, text in boat.said if name == "leader_lost"]
    assert text.startswith(what) and text.endswith(": Hold") and boat.severities["leader_lost"] is Severity.CRITICAL
    lead.boat = boat
    WAYS[what](boat, lead, True)
    back_s = boat.now_s
    while boat.status.mode is not ModeId.FOLLOW:
        lead.tick()
        assert boat.now_s - back_s < 3.0 + 2.0 / rate_hz + 0.3
    assert boat.now_s - back_s > 3.0
    assert (
        "leader_lost_over",
        "Leader can be followed again: Follow",
    ) in boat.said and boat.status.failsafes == ()


@pytest.mark.parametrize("latency_s", [0.0, 0.08])
@pytest.mark.parametrize(("loss", "cuts"), [(0.0, 20), (0.25, 20), (0.5, 8)])
def test_outages_of_0_4_s_toggle_nothing(boat: Any, loss: float, cuts: int, latency_s: float) -> None:
    """With half of all messages lost beside them, chance alone makes of one cut in 50 an outage of 0.8 s, with 80 ms of
    latency of one in 20 (counted over 40 seeds of 8 cuts)."""
    lead = LeadBoat(boat, wish=Wish.AUTONOMOUS, loss=loss)
    lead.latency_s = latency_s
    following(boat, lead)
    for _ in range(cuts):
        lead.on = False
        lead.run(0.4)
        lead.on = True
        lead.run(1.7)
    assert modes_said(boat) == [] and boat.status.mode is ModeId.FOLLOW and "leader_lost" not in boat.names()


def test_half_of_all_messages_lost_for_ten_minutes_toggle_nothing(boat: Any) -> None:
    lead = LeadBoat(boat, wish=Wish.AUTONOMOUS, loss=0.5, seed=1)
    following(boat, lead)
    lead.run(600.0)
    assert modes_said(boat) == [] and "leader_lost" not in boat.names()


@pytest.mark.parametrize(
    ("action", "mode", "said"),
    [(1, ModeId.HOLD, "Hold"), (2, ModeId.RTL, "RTL"), (3, ModeId.FOLLOW, "neutral"), (4, ModeId.MANUAL, "Manual")],
)
def test_the_fallback_is_by_parameter_and_each_comes_back(make_boat: Any, action: int, mode: ModeId, said: str) -> None:
    boat = make_boat(FOLL_LOSS_ACT=action)
    lead = LeadBoat(boat)
    following(boat, lead)
    lead.on = False
    lead.run(2.0)
    assert boat.status.mode is mode and any(
        text.endswith(f": {said}") for name, text in boat.said if name == "leader_lost"
    )
    assert (isinstance(boat.setpoint, NeutralSetpoint)) == (action in (3, 4))
    lead.on = True
    lead.run(2.8)
    assert boat.status.mode is mode and (isinstance(boat.setpoint, NeutralSetpoint)) == (action in (3, 4))
    lead.run(0.6)
    assert boat.status.mode is ModeId.FOLLOW and isinstance(boat.setpoint, PathSetpoint)


def test_a_fallback_that_is_not_possible_becomes_neutral(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    lead.on = False
    boat.nav = replace(boat.nav, position_valid=False)
    lead.run(2.0)
    assert isinstance(boat.setpoint, NeutralSetpoint) and set(boat.status.failsafes) == {"position_lost", "leader_lost"}
    boat.nav = replace(boat.nav, position_valid=True)
    lead.run(0.2)
    assert boat.status.mode is ModeId.HOLD


def test_somebody_who_steers_in_the_fallback_keeps_the_helm(make_boat: Any) -> None:
    boat = make_boat(FOLL_LOSS_ACT=4)
    lead = LeadBoat(boat)
    following(boat, lead)
    boat.sticks = (0.0, 0.0, 0.0)
    lead.on = False
    lead.run(2.0)
    boat.sticks = (0.6, 0.0, 0.0)
    lead.on = True
    lead.run(6.0)
    assert boat.status.mode is ModeId.MANUAL and isinstance(boat.setpoint, ThrusterSetpoint)
    assert "Leader can be followed again: stays in Manual: somebody steers" in boat.texts()


@pytest.mark.parametrize("chosen", [ModeId.HOLD, ModeId.MANUAL])
def test_who_chooses_another_mode_meanwhile_keeps_it(boat: Any, lead: LeadBoat, chosen: ModeId) -> None:
    following(boat, lead)
    lead.on = False
    lead.run(1.5)
    assert boat.supervisor.request_mode(chosen, boat.now_s).accepted
    lead.on = True
    lead.run(10.0)
    assert boat.status.mode is chosen and boat.status.failsafes == ()


def test_follow_chosen_again_before_the_time_is_watched_anew(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    lead.on = False
    lead.run(1.5)
    lead.on = True
    lead.run(1.0)
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    lead.run(0.5)
    lead.on = False
    lead.run(1.0)
    assert modes_said(boat) == ["Mode Hold", "Mode Follow", "Mode Hold"]


def test_a_link_that_flaps_does_not_toggle_faster_than_foll_back_t(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    for _ in range(20):
        lead.on = False
        lead.run(1.2)
        lead.on = True
        lead.run(2.0)
    assert modes_said(boat) == ["Mode Hold"]
    lead.run(3.5)
    assert modes_said(boat) == ["Mode Hold", "Mode Follow"]


def test_a_wish_that_is_not_autonomous_keeps_the_boat_in_its_fallback(boat: Any) -> None:
    """A ground station had it follow against the wish that the module had from its start."""
    lead = LeadBoat(boat, wish=Wish.MANUAL)
    following(boat, lead)
    lead.on = False
    lead.run(1.5)
    lead.on = True
    lead.run(6.0)
    assert boat.status.mode is ModeId.HOLD and boat.status.failsafes == ()
    assert "Leader can be followed again: stays in Hold: the lead boat asks for Manual" in boat.texts()


def test_neutral_by_loss_does_not_end_in_follow_against_the_wish(make_boat: Any) -> None:
    boat = make_boat(FOLL_LOSS_ACT=3)
    lead = LeadBoat(boat, wish=Wish.MANUAL)
    following(boat, lead)
    lead.on = False
    lead.run(1.5)
    assert isinstance(boat.setpoint, NeutralSetpoint)
    lead.on = True
    lead.run(6.0)
    assert boat.status.mode is ModeId.HOLD and isinstance(boat.setpoint, PoseSetpoint)


def test_another_leader_is_not_followed_by_itself(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    lead.on = False
    lead.run(31.0)
    phone = LeadBoat(boat, 4.0, None, system=255)
    phone.run(8.0)
    assert boat.status.leader.system_id == 255 and boat.status.mode is ModeId.HOLD
    assert "Leader can be followed again: stays in Hold: it is another leader" in boat.texts()


def test_a_worse_failsafe_keeps_the_boat_from_going_back(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    lead.on = False
    lead.run(1.5)
    boat.wet = True
    lead.run(0.5)
    assert boat.status.mode is ModeId.RTL
    lead.on = True
    lead.run(6.0)
    assert boat.status.mode is ModeId.RTL and any(text.endswith("another failsafe lasts") for text in boat.texts())


def test_the_safe_switch_ends_it_for_good(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    lead.on = False
    lead.run(1.5)
    boat.rc = (0.0, 0.0, 0.0, 0.0, 1.0)
    lead.run(0.2)
    assert boat.status.mode is ModeId.MANUAL
    boat.rc = (0.0, 0.0, 0.0, 0.0, -1.0)
    lead.on = True
    lead.run(8.0)
    assert boat.status.mode is ModeId.MANUAL


# --- the lead boat for a ground station ----------------------------------------------------------------------------


def test_the_leader_stands_for_a_ground_station_in_follow(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    boat.station = False
    lead.run(30.0)
    assert boat.status.failsafes == () and boat.status.mode is ModeId.FOLLOW
    lead.on = False
    lead.run(11.0)
    assert boat.status.failsafes == ("station_lost", "leader_lost")
    lead.on = True
    lead.run(4.0)
    assert boat.status.failsafes == () and boat.status.mode is ModeId.FOLLOW


def test_but_in_no_other_mode(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    assert boat.supervisor.go_to(*boat.point(80.0, 0.0), None, None, boat.now_s).accepted
    boat.station = False
    lead.run(11.0)
    assert boat.status.failsafes == ("station_lost",)


def test_remote_control_stands_for_a_ground_station_too(boat: Any, lead: LeadBoat) -> None:
    lead.run(1.0)
    boat.station = False
    lead.press(Wish.REMOTE)
    boat.sticks = (0.0, 0.0, 0.0)
    lead.run(0.2)
    assert boat.supervisor.arm(boat.now_s).accepted
    lead.run(1.0)
    boat.sticks = None
    lead.run(15.0)
    assert boat.status.mode is ModeId.HOLD and boat.status.failsafes == ("sticks_lost",)
