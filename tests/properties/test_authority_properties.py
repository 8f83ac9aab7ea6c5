"""Who is obeyed, as data: for each action the conditions of a refusal, in order, and its text.

A condition is a set of literals (`name` true, `-name` false); the atoms below say what each name means. The table was
written down from the code that decided before there was `authority.py`, and knows nothing of its rows.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.decision import ModeId
from companion.core.readings import Wish
from companion.supervisor.authority import (
    ROWS,
    AuthorityRequest,
    Facts,
    RequestedAction,
    Right,
    refusal,
    sticks_in_charge,
)

Atom = Callable[[AuthorityRequest, Facts], bool]

ATOMS: dict[str, Atom] = {
    "granted": lambda r, f: r.granted is None or r.action in r.granted,
    "list": lambda r, f: len(f.operators) > 0,
    "listed": lambda r, f: r.system in f.operators,
    "free": lambda r, f: f.in_control == 0,
    "in_control": lambda r, f: f.in_control == r.system,
    "takeover": lambda r, f: f.takeover,
    "kill": lambda r, f: f.kill_switch,
    "switch": lambda r, f: f.safe_switch,
    "transmitter": lambda r, f: f.transmitter_live,
    "to_manual": lambda r, f: r.mode is ModeId.MANUAL,
    "remote": lambda r, f: f.remote_system is not None,
    "by_remote": lambda r, f: f.remote_system == r.system,
    "module": lambda r, f: f.module == r.system,
    "sticks_chosen": lambda r, f: f.chosen_sticks != 0,
    "by_chosen_sticks": lambda r, f: f.chosen_sticks == r.system,
    "steered": lambda r, f: f.steering is not None,
    "steering": lambda r, f: f.steering == (r.system, r.link),
    "by_number": lambda r, f: f.steering is not None and f.steering[0] == r.system,
    "steered_lately": lambda r, f: f.steering_live,
    "crew_decides": lambda r, f: f.lead_boat_decides,
    "wish_manual": lambda r, f: f.wish is Wish.MANUAL,
    "wish_remote": lambda r, f: f.wish is Wish.REMOTE,
    "leader_chosen": lambda r, f: f.chosen_leader != 0,
    "chosen_leader": lambda r, f: f.chosen_leader == r.system,
    "led": lambda r, f: f.leader is not None,
    "leads": lambda r, f: f.leader == r.system,
    "leader_silent": lambda r, f: f.leader_silent,
    "followed": lambda r, f: f.followed is not None,
    "followed_leads": lambda r, f: f.followed == f.leader,
    "sticks_moved": lambda r, f: f.sticks_moved,
    "follow_intended": lambda r, f: f.intended is ModeId.FOLLOW,
    "offboard": lambda r, f: f.mode is ModeId.OFFBOARD,
}

NOT_LISTED = ("list -listed", "system {r.system} may not command here")
NO_LEAVE = ("-granted", "this script may not do that")
CONTROLLED = ("-free -in_control", "system {f.in_control} has control")
SWITCH = "safe switch of the transmitter is on"
KILLED = ("kill", "kill switch of the transmitter is on")
SAILS_BY_ITSELF = [
    ("followed -followed_leads -leader_chosen", "it is another leader"),
    ("crew_decides wish_manual", "the lead boat asks for Manual"),
    ("crew_decides wish_remote", "the lead boat asks for remote control"),
    ("sticks_moved", "somebody steers"),
]
GCS, RC, LEAD, SHIP, STREAM, SELF = (
    Right.GROUND_STATION,
    Right.TRANSMITTER,
    Right.LEAD_BOAT,
    Right.VEHICLE,
    Right.OFFBOARD,
    Right.BOAT,
)

EXPECTED: dict[tuple[RequestedAction, Right], list[tuple[str, str]]] = {
    (RequestedAction.COMMAND, GCS): [NO_LEAVE, NOT_LISTED, CONTROLLED],
    (RequestedAction.SETPOINT, GCS): [NO_LEAVE, NOT_LISTED, CONTROLLED],
    (RequestedAction.UPLOAD, GCS): [NO_LEAVE, NOT_LISTED, CONTROLLED],
    (RequestedAction.PARAMETER, GCS): [NO_LEAVE, NOT_LISTED, CONTROLLED],
    (RequestedAction.STICKS, GCS): [
        NO_LEAVE,
        ("list -listed -by_remote", NOT_LISTED[1]),
        ("-free -in_control -by_remote", CONTROLLED[1]),
    ],
    (RequestedAction.DISARM, GCS): [NO_LEAVE, NOT_LISTED],
    (RequestedAction.OPERATOR_CONTROL, GCS): [NO_LEAVE, NOT_LISTED],
    (RequestedAction.TAKE_CONTROL, GCS): [("-free -in_control -takeover", CONTROLLED[1])],
    (RequestedAction.RELEASE_CONTROL, GCS): [CONTROLLED],
    (RequestedAction.CHANGE_MODE, GCS): [("switch transmitter -to_manual", SWITCH)],
    (RequestedAction.CHANGE_MODE, LEAD): [("switch transmitter -to_manual", SWITCH)],
    (RequestedAction.CHANGE_MODE, RC): [("switch transmitter -to_manual", SWITCH)],
    (RequestedAction.CHANGE_MODE, SELF): [("switch", "left to the transmitter")],
    (RequestedAction.ARM, GCS): [KILLED, ("switch", SWITCH)],
    (RequestedAction.ARM, LEAD): [KILLED, ("switch", SWITCH)],
    (RequestedAction.ARM, RC): [KILLED],
    (RequestedAction.ARM_BY_FORCE, GCS): [KILLED],
    (RequestedAction.ARM_BY_FORCE, LEAD): [KILLED],
    (RequestedAction.ARM_BY_FORCE, RC): [KILLED],
    (RequestedAction.GROUND_STICKS, GCS): [
        ("remote -by_remote", "lead boat {f.remote_system} steers: choose a mode"),
        ("module -by_remote -by_chosen_sticks", "the crew has not asked for remote control"),
        ("-remote sticks_chosen -by_chosen_sticks", ""),
        (
            "-remote -sticks_chosen steered -steering steered_lately -by_number",
            "system {f.steering[0]} steers",
        ),
        (
            "-remote -sticks_chosen steered -steering steered_lately by_number",
            "system {r.system} on another link steers",
        ),
    ],
    (RequestedAction.STEER, GCS): [("switch", SWITCH)],
    (RequestedAction.STEER, RC): [("remote -switch", "lead boat {f.remote_system} steers")],
    (RequestedAction.LEADER_WISH, LEAD): [("-crew_decides", "FOLL_AUTH is 0")],
    (RequestedAction.LEADER_POSITION, LEAD): [
        ("leader_chosen -chosen_leader", ""),
        ("-leader_chosen led -leads -leader_silent", ""),
    ],
    (RequestedAction.LEADER_POSITION, SHIP): [("-chosen_leader", "")],
    (RequestedAction.RETURN_TO_FOLLOW, SELF): SAILS_BY_ITSELF,
    (RequestedAction.STAND_IN, LEAD): [("-follow_intended -by_remote", "")],
    (RequestedAction.STAND_IN, STREAM): [("-offboard", "")],
}  # all else is obeyed

SYSTEMS = (1, 42, 254, 255)
GRANTED = (None, None, frozenset[RequestedAction](), frozenset({RequestedAction.COMMAND, RequestedAction.DISARM}))
LINKS = ("radio", "wifi")
YES_NO = (False, True)
MAYBE = (None, *SYSTEMS)
VALUES: dict[str, tuple[Any, ...]] = {
    "kill_switch": YES_NO,
    "safe_switch": YES_NO,
    "transmitter_live": YES_NO,
    "operators": (frozenset(), frozenset({255}), frozenset({42, 254})),
    "in_control": (0, *SYSTEMS),
    "takeover": YES_NO,
    "chosen_sticks": (0, *SYSTEMS),
    "steering": (None, *((system, link) for system in SYSTEMS for link in LINKS)),
    "steering_live": YES_NO,
    "remote_system": MAYBE,
    "module": MAYBE,
    "lead_boat_decides": YES_NO,
    "wish": (None, *Wish),
    "chosen_leader": (0, *SYSTEMS),
    "leader": MAYBE,
    "leader_silent": YES_NO,
    "followed": MAYBE,
    "mode": tuple(ModeId),
    "intended": tuple(ModeId),
    "sticks_moved": YES_NO,
}
facts = st.builds(Facts, **{name: st.sampled_from(values) for name, values in VALUES.items()})
requests = st.builds(
    AuthorityRequest,
    st.sampled_from(RequestedAction),
    st.sampled_from(Right),
    *map(st.sampled_from, (SYSTEMS, LINKS, tuple(ModeId), GRANTED)),
)


def holds(condition: str, request: AuthorityRequest, given_facts: Facts) -> bool:
    return all(ATOMS[name.lstrip("-")](request, given_facts) is not name.startswith("-") for name in condition.split())


def expected(request: AuthorityRequest, given_facts: Facts) -> str | None:
    for condition, text in EXPECTED.get((request.action, request.right), []):
        if holds(condition, request, given_facts):
            return text.format(r=request, f=given_facts)
    return None


@settings(deadline=None, derandomize=True, max_examples=500)
@given(requests, facts)
def test_refusals_are_those_of_the_truth_table(request: AuthorityRequest, given_facts: Facts) -> None:
    assert refusal(request, given_facts) == expected(request, given_facts)


@pytest.mark.parametrize(("action", "right"), sorted(EXPECTED, key=str), ids=str)
def test_each_entry_of_the_truth_table_refuses_for_some_facts(action: RequestedAction, right: Right) -> None:
    draws, entries = random.Random(1), set(EXPECTED[action, right])
    seen: set[tuple[str, str]] = set()
    for _ in range(4000):
        request = AuthorityRequest(
            action,
            right,
            draws.choice(SYSTEMS),
            draws.choice(LINKS),
            draws.choice(list(ModeId)),
            draws.choice(GRANTED),
        )
        given_facts = Facts(**{name: draws.choice(values) for name, values in VALUES.items()})
        assert refusal(request, given_facts) == expected(request, given_facts)
        seen |= {entry for entry in entries if holds(entry[0], request, given_facts)}
    assert seen == entries


SWITCHES: list[
    tuple[bool, int | None, tuple[Right, ...]]
] = [  # safe switch, lead boat by remote → whose sticks, in order
    (False, None, (GCS, RC)),
    (False, 42, (GCS,)),
    (True, None, (RC,)),
    (True, 42, (RC,)),
]


@settings(deadline=None, derandomize=True, max_examples=50)
@given(facts)
@pytest.mark.parametrize(("switch", "remote", "order"), SWITCHES)
def test_whose_sticks_steer(switch: bool, remote: int | None, order: tuple[Right, ...], given_facts: Facts) -> None:
    """Whatever the other facts are."""
    assert sticks_in_charge(replace(given_facts, safe_switch=switch, remote_system=remote)) == order


def test_the_table_is_whole() -> None:
    """Names differ, each row says its rule, and the generator knows each fact."""
    assert len({row.name for row in ROWS}) == len(ROWS)
    assert all(row.about and row.by and row.doc.endswith(".") for row in ROWS)
    assert set(VALUES) == {field.name for field in fields(Facts)}
    assert {(action, right) for row in ROWS for action in row.about for right in row.by} == set(EXPECTED)
