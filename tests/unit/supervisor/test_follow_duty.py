"""Following as a duty: whose word counts, what is lost and comes back, where the station is."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.core.decision import ModeId, Result, Severity
from companion.core.readings import Wish
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint, ThrusterSetpoint
from companion.mission.plan import PlanItem
from companion.supervisor.authority import AuthorityRequest, RequestedAction
from tests.unit.following.lead_boat import LeadBoat

NAN = math.nan


@pytest.fixture
def lead(boat: Any) -> LeadBoat:
    return LeadBoat(boat)


def following(boat: Any, lead: LeadBoat) -> None:
    """Armed and in Follow, 5 s under way."""
    lead.run(2.0)
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    lead.run(5.0)
    assert boat.status.mode is ModeId.FOLLOW and isinstance(boat.setpoint, PathSetpoint)
    boat.said.clear()


def remote_system(boat: Any) -> int | None:
    return boat.supervisor.facts(boat.now_s).remote_system


def stick_refusal(boat: Any, system: int) -> str | None:
    return boat.supervisor.refusal(AuthorityRequest(RequestedAction.GROUND_STICKS, system=system), boat.now_s)


def modes_said(boat: Any) -> list[str]:
    return [text for name, text in boat.said if name == "mode_changed"]


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


# --- refusals ------------------------------------------------------------------------------------------------------


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


# --- the station ---------------------------------------------------------------------------------------------------


def station(boat: Any) -> tuple[float, float]:
    distance_m, bearing_rad = boat.supervisor.following.follow_position
    return distance_m, math.degrees(bearing_rad)


def test_the_station_is_by_parameters_until_commanded_and_again_after(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    duty = boat.supervisor.following
    assert station(boat) == pytest.approx((20.0, 180.0))
    assert duty.set_follow_position(math.radians(-90.0), 30.0, boat.now_s).accepted
    assert station(boat) == pytest.approx((30.0, -90.0))
    assert duty.set_follow_position(None, 40.0, boat.now_s).accepted and station(boat) == pytest.approx((40.0, -90.0))
    assert duty.set_follow_position(math.radians(270.0), None, boat.now_s).accepted and station(boat) == pytest.approx(
        (40.0, -90.0)
    )
    lead.run(0.1)
    assert "Follow position: 30 m at 90 deg to port" in boat.texts()
    boat.parameters.set("FLW_TGT_FA", 135.0)
    assert station(boat) == pytest.approx((20.0, 135.0))
    assert duty.set_follow_position(0.0, 50.0, boat.now_s).accepted and station(boat) == pytest.approx((50.0, 0.0))
    boat.supervisor.disarm(boat.now_s)
    lead.run(0.1)
    assert station(boat) == pytest.approx((20.0, 135.0))


def test_a_station_by_parameters_is_said_too_and_what_keeps_the_boat_further_out(boat: Any, lead: LeadBoat) -> None:
    following(boat, lead)
    boat.parameters.set("FLW_TGT_DST", 30.0)
    lead.run(0.1)
    assert "Follow position: 30 m astern" in boat.texts()
    boat.parameters.set("FOLL_MIN_DIST", 40.0)
    lead.run(0.1)
    assert "Follow position: 30 m astern, but FOLL_MIN_DIST is 40 m" in boat.texts()
    told = len(boat.texts())
    lead.run(1.0)
    assert len(boat.texts()) == told


@pytest.mark.parametrize(
    ("bearing_deg", "distance_m", "reason"),
    [
        (None, 11.0, "FOLL_MIN_DIST is 12 m"),
        (None, 501.0, "give 1 to 500 m"),
        (None, NAN, "give 1 to 500 m"),
        (None, -20.0, "give 1 to 500 m"),
        (400.0, None, "give -360 to 360 deg"),
        (math.inf, 20.0, "give -360 to 360 deg"),
    ],
)
def test_stations_that_cannot_be(boat: Any, bearing_deg: float | None, distance_m: float | None, reason: str) -> None:
    outcome = boat.supervisor.following.set_follow_position(
        None if bearing_deg is None else math.radians(bearing_deg), distance_m, boat.now_s
    )
    assert outcome.result is Result.DENIED and reason in outcome.reason
    boat.step()
    assert outcome.reason in boat.texts() and station(boat) == pytest.approx((20.0, 180.0))


def test_a_station_is_not_taken_inside_by_a_bearing_alone(make_boat: Any) -> None:
    boat = make_boat(FLW_TGT_DST=5.0)
    assert boat.supervisor.following.set_follow_position(0.0, None, boat.now_s).result is Result.DENIED


# --- missions ------------------------------------------------------------------------------------------------------


def do(command: int, *params: float) -> PlanItem:
    return PlanItem(0, command, 2, *(*params, *(NAN for _ in range(4 - len(params)))), 0, 0, 0.0)


def on_mission(boat: Any, lead: LeadBoat, commands: dict[int, PlanItem]) -> None:
    boat.upload((10.0, 0.0), (10.0, 20.0), commands=commands)
    lead.run(1.0)
    boat.supervisor.request_mode(ModeId.MISSION, boat.now_s)
    assert boat.supervisor.arm(boat.now_s).accepted


def run_until(boat: Any, lead: LeadBoat, condition: Callable[[], bool], timeout_s: float = 200.0) -> None:
    end_s = boat.now_s + timeout_s
    while not condition():
        assert boat.now_s < end_s, (boat.status, boat.said[-5:])
        lead.tick()


def test_a_mission_hands_over_to_follow_and_goes_on_after_it_when_resumed(boat: Any, lead: LeadBoat) -> None:
    on_mission(boat, lead, {1: do(31012, -135.0, 25.0), 2: do(32, -1.0)})
    run_until(boat, lead, lambda: boat.status.mode is ModeId.FOLLOW)
    assert station(boat) == pytest.approx((25.0, -135.0)) and boat.status.mission.reached == 1
    lead.run(0.1)
    assert "Item 3: following; choose Mission for item 4" in boat.texts()
    lead.run(20.0)
    assert boat.status.mode is boat.status.intended_mode is ModeId.FOLLOW
    lead.on = False
    lead.run(2.0)
    assert boat.status.mode is ModeId.HOLD
    lead.on = True
    lead.run(4.0)
    assert boat.status.mode is ModeId.FOLLOW  # the plan meant it
    assert boat.supervisor.resume(boat.now_s).accepted
    run_until(boat, lead, lambda: boat.status.mode is ModeId.HOLD)
    assert boat.status.mission.reached == 2 and "Mission complete" in boat.texts()


def test_a_mission_may_end_in_follow(boat: Any, lead: LeadBoat) -> None:
    on_mission(boat, lead, {2: do(32, NAN)})
    run_until(boat, lead, lambda: boat.status.mode is ModeId.FOLLOW)
    lead.run(20.0)
    assert boat.status.mode is ModeId.FOLLOW and "Item 3: following; Mission complete" in boat.texts()


@pytest.mark.parametrize("last", [True, False])
@pytest.mark.parametrize("system", [-1.0, 7.0])
def test_without_a_leader_the_mission_holds_where_it_is_and_says_why(
    boat: Any, lead: LeadBoat, last: bool, system: float
) -> None:
    lead.on = system > 0.0
    on_mission(boat, lead, {2 if last else 1: do(32, system)})
    run_until(boat, lead, lambda: boat.status.mode is ModeId.HOLD)
    expected = "Follow refused: leader 7 not heard yet" if system > 0.0 else "Follow refused: no leader heard"
    assert any(text.endswith(expected) for text in boat.texts())
    lead.run(5.0)
    assert boat.status.mode is ModeId.HOLD
    if not last:
        assert boat.supervisor.resume(boat.now_s).accepted
        run_until(boat, lead, lambda: "Mission complete" in boat.texts())


def test_a_station_in_a_mission_that_cannot_be_is_said(boat: Any, lead: LeadBoat) -> None:
    on_mission(boat, lead, {1: do(31012, 0.0, 3.0)})
    run_until(boat, lead, lambda: "Mission complete" in boat.texts())
    assert "Follow position refused: FOLL_MIN_DIST is 12 m" in boat.texts()
