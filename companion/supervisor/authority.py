"""Who is obeyed, who steers, who leads: one table.

`ROWS` is the table, in order. `refusal(request, facts)` is the text of the first row that refuses a request, or None.
`sticks_in_charge(facts)` answers from the same table whose sticks steer. Both are pure. Who needs a decision asks here;
MAVLink services only say which action a message asks for.

A message of a ground station is asked about twice: on arrival as a message (`COMMAND`, `STICKS`, …), and when it is
carried out as what it does (`CHANGE_MODE`, `GROUND_STICKS`, …).

The documentation's page of authority is generated from `ROWS`: `name`, `about`, `by` and `doc` of each row.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass

from companion.core.decision import ModeId
from companion.core.named import Named
from companion.core.readings import Wish


class RequestedAction(Named):
    """What is asked for; the value is for people."""

    READ = "read, or set message rates"
    COMMAND = "command, or change the mode"
    DISARM = "disarm or terminate"
    STICKS = "send sticks"
    SETPOINT = "send setpoints"
    UPLOAD = "upload or clear a plan"
    PARAMETER = "set a parameter"
    OPERATOR_CONTROL = "ask for operator control"
    TAKE_CONTROL = "take operator control"
    RELEASE_CONTROL = "release operator control"
    CHANGE_MODE = "change the mode"
    ARM = "arm"
    ARM_BY_FORCE = "arm by force"
    GROUND_STICKS = "be the ground station that steers"
    STEER = "steer by sticks"
    LEADER_WISH = "choose the mode from the lead boat"
    LEADER_POSITION = "be the leader"
    RETURN_TO_FOLLOW = "go back to Follow after a lost leader"
    STAND_IN = "count as a ground station"


class Right(Named):
    """By what right somebody asks; the value is for people."""

    GROUND_STATION = "ground station"
    TRANSMITTER = "transmitter"
    LEAD_BOAT = "lead boat"
    VEHICLE = "another vehicle's telemetry"
    OFFBOARD = "offboard computer"
    BOAT = "the boat itself"


@dataclass(frozen=True, slots=True)
class AuthorityRequest:
    """Who asks for what. `link`: tells apart two senders of the same system id. `mode`: the mode asked for by
    CHANGE_MODE. `granted`: all that the sender's link may ask for; None: everything."""

    action: RequestedAction
    right: Right = Right.GROUND_STATION
    system: int = 0
    link: Hashable = None
    mode: ModeId | None = None
    granted: frozenset[RequestedAction] | None = None


@dataclass(frozen=True, slots=True)
class Facts:
    """What the answer depends on, as it stands at one moment."""

    kill_switch: bool = False  # on when the transmitter was last heard
    safe_switch: bool = False  # on when the transmitter was last heard
    transmitter_live: bool = False  # heard within COM_RC_LOSS_T
    operators: frozenset[int] = frozenset()  # listed in the vessel's file; empty: all may command
    in_control: int = 0  # system with operator control, 0: none
    takeover: bool = True  # the system in control lets others take it over
    chosen_sticks: int = 0  # MAN_GCS_SYSID
    steering: tuple[int, Hashable] | None = None  # system and link of the ground station whose sticks came last
    steering_live: bool = False  # those sticks came within COM_RC_LOSS_T
    remote_system: int | None = None  # lead boat that steers by remote
    module: int | None = None  # system of the leader module
    lead_boat_decides: bool = True  # FOLL_AUTH
    wish: Wish | None = None  # of the leader module, None: no module is heard
    chosen_leader: int = 0  # FOLL_SYSID
    leader: int | None = None  # system that leads now
    leader_silent: bool = False  # for so long that another may lead
    followed: int | None = None  # system that the boat followed last
    mode: ModeId = ModeId.MANUAL
    intended: ModeId = ModeId.MANUAL  # the mode last asked for by a person
    sticks_moved: bool = False  # the mode is steered by stick, and live sticks are off centre


@dataclass(frozen=True, slots=True)
class RefusalRule:
    """One reason to refuse. It binds requests for an action of `about` by a right of `by`.

    `text`: why, for the sender; empty where the input is ignored without a word. `doc`: the rule in one sentence.
    """

    name: str
    about: frozenset[RequestedAction]
    by: frozenset[Right]
    refuses: Callable[[AuthorityRequest, Facts], bool]
    text: Callable[[AuthorityRequest, Facts], str]
    doc: str


_PEOPLE = frozenset({Right.GROUND_STATION, Right.LEAD_BOAT})
_GROUND_STATION = frozenset({Right.GROUND_STATION})
_CONTROLLING = frozenset(
    {
        RequestedAction.COMMAND,
        RequestedAction.STICKS,
        RequestedAction.SETPOINT,
        RequestedAction.UPLOAD,
        RequestedAction.PARAMETER,
    }
)  # what operator control reserves
WISHES = {Wish.MANUAL: "Manual", Wish.REMOTE: "remote control", Wish.AUTONOMOUS: "Follow"}


def _exempt(r: AuthorityRequest, f: Facts) -> bool:
    """The lead boat's crew steers by its own right."""
    return r.action is RequestedAction.STICKS and f.remote_system == r.system


def _who_steers(r: AuthorityRequest, f: Facts) -> str:
    system = f.steering[0] if f.steering is not None else 0
    where = " on another link" if system == r.system else ""
    return f"system {system}{where} steers"


ROWS: tuple[RefusalRule, ...] = (
    RefusalRule(
        "script_grants",
        _CONTROLLING | {RequestedAction.DISARM, RequestedAction.OPERATOR_CONTROL},
        _GROUND_STATION,
        lambda r, f: r.granted is not None and r.action not in r.granted,
        lambda r, f: "this script may not do that",
        "A script asks only for what `may` of its `[[script]]` lists; `command` covers disarming. Reading stays open. "
        "Operator control is never a script's.",
    ),
    RefusalRule(
        "operator_list",
        _CONTROLLING | {RequestedAction.DISARM, RequestedAction.OPERATOR_CONTROL},
        _GROUND_STATION,
        lambda r, f: bool(f.operators) and r.system not in f.operators and not _exempt(r, f),
        lambda r, f: f"system {r.system} may not command here",
        "Where the vessel's file lists `operators`, only those systems command. Reading stays open to all.",
    ),
    RefusalRule(
        "operator_control",
        _CONTROLLING,
        _GROUND_STATION,
        lambda r, f: f.in_control not in (0, r.system) and not _exempt(r, f),
        lambda r, f: f"system {f.in_control} has control",
        "While one system has operator control, no other commands. Every operator may disarm and terminate at any "
        "time. Control ends when its system is silent for COM_DL_LOSS_T.",
    ),
    RefusalRule(
        "control_taken",
        frozenset({RequestedAction.TAKE_CONTROL}),
        _GROUND_STATION,
        lambda r, f: f.in_control not in (0, r.system) and not f.takeover,
        lambda r, f: f"system {f.in_control} has control",
        "Operator control is taken from another system only if that system allows a takeover.",
    ),
    RefusalRule(
        "control_of_another",
        frozenset({RequestedAction.RELEASE_CONTROL}),
        _GROUND_STATION,
        lambda r, f: f.in_control not in (0, r.system),
        lambda r, f: f"system {f.in_control} has control",
        "Only the system in control releases it.",
    ),
    RefusalRule(
        "kill_switch",
        frozenset({RequestedAction.ARM, RequestedAction.ARM_BY_FORCE}),
        _PEOPLE | {Right.TRANSMITTER},
        lambda r, f: f.kill_switch,
        lambda r, f: "kill switch of the transmitter is on",
        "While the kill switch is on, the boat is disarmed and nobody arms it, not even by force. While the "
        "transmitter is silent its last position counts, until RC_MAP_KILL_SW is 0.",
    ),
    RefusalRule(
        "safe_switch",
        frozenset({RequestedAction.CHANGE_MODE}),
        _PEOPLE | {Right.TRANSMITTER},
        lambda r, f: f.safe_switch and f.transmitter_live and r.mode is not ModeId.MANUAL,
        lambda r, f: "safe switch of the transmitter is on",
        "While the safe switch is on and the transmitter is heard, the boat is in Manual and no other mode can be "
        "chosen, not even by another switch of the transmitter. From a silent transmitter an operator takes over by "
        "choosing a mode.",
    ),
    RefusalRule(
        "safe_switch_arming",
        frozenset({RequestedAction.ARM}),
        _PEOPLE,
        lambda r, f: f.safe_switch,
        lambda r, f: "safe switch of the transmitter is on",
        "The boat is not armed while the safe switch is on, unless by force or without ARM_CHECKS.",
    ),
    RefusalRule(
        "safe_switch_failsafe",
        frozenset({RequestedAction.CHANGE_MODE}),
        frozenset({Right.BOAT}),
        lambda r, f: f.safe_switch,
        lambda r, f: "left to the transmitter",
        "While the safe switch is on, no failsafe changes the mode; one whose action is Neutral stops the thrusters.",
    ),
    RefusalRule(
        "lead_boat_steers",
        frozenset({RequestedAction.GROUND_STICKS}),
        _GROUND_STATION,
        lambda r, f: f.remote_system is not None and f.remote_system != r.system,
        lambda r, f: f"lead boat {f.remote_system} steers: choose a mode",
        "While the lead boat steers by remote, no ground station's sticks count.",
    ),
    RefusalRule(
        "lead_boat_has_not_asked",
        frozenset({RequestedAction.GROUND_STICKS}),
        _GROUND_STATION,
        lambda r, f: f.module == r.system and r.system not in (f.remote_system, f.chosen_sticks),
        lambda r, f: "the crew has not asked for remote control",
        "The lead boat's sticks count once its crew has asked for remote control, or if MAN_GCS_SYSID names it.",
    ),
    RefusalRule(
        "other_sticks_chosen",
        frozenset({RequestedAction.GROUND_STICKS}),
        _GROUND_STATION,
        lambda r, f: (f.remote_system or f.chosen_sticks) not in (0, r.system),
        lambda r, f: "",
        "If MAN_GCS_SYSID names a system, all other sticks are ignored.",
    ),
    RefusalRule(
        "first_sticks",
        frozenset({RequestedAction.GROUND_STICKS}),
        _GROUND_STATION,
        lambda r, f: (
            f.steering not in (None, (r.system, r.link))
            and (f.remote_system or f.chosen_sticks) == 0
            and f.steering_live
        ),
        _who_steers,
        "Of several ground stations the first steers, until its sticks have been silent for COM_RC_LOSS_T.",
    ),
    RefusalRule(
        "safe_switch_sticks",
        frozenset({RequestedAction.STEER}),
        _GROUND_STATION,
        lambda r, f: f.safe_switch,
        lambda r, f: "safe switch of the transmitter is on",
        "While the safe switch is on, only the transmitter steers.",
    ),
    RefusalRule(
        "lead_boat_alone_steers",
        frozenset({RequestedAction.STEER}),
        frozenset({Right.TRANSMITTER}),
        lambda r, f: f.remote_system is not None and not f.safe_switch,
        lambda r, f: f"lead boat {f.remote_system} steers",
        "While the lead boat steers by remote, the transmitter does not steer, unless its safe switch is on.",
    ),
    RefusalRule(
        "ground_stations_decide",
        frozenset({RequestedAction.LEADER_WISH}),
        frozenset({Right.LEAD_BOAT}),
        lambda r, f: not f.lead_boat_decides,
        lambda r, f: "FOLL_AUTH is 0",
        "With FOLL_AUTH 0 the lead boat's crew chooses no mode. With 1 the newest decision counts, whoever makes it.",
    ),
    RefusalRule(
        "vehicle_not_chosen",
        frozenset({RequestedAction.LEADER_POSITION}),
        frozenset({Right.VEHICLE}),
        lambda r, f: r.system != f.chosen_leader,
        lambda r, f: "",
        "A vehicle that sends its own position only, leads only if FOLL_SYSID names it.",
    ),
    RefusalRule(
        "other_leader_chosen",
        frozenset({RequestedAction.LEADER_POSITION}),
        frozenset({Right.LEAD_BOAT, Right.VEHICLE}),
        lambda r, f: f.chosen_leader not in (0, r.system),
        lambda r, f: "",
        "If FOLL_SYSID names a system, no other leads.",
    ),
    RefusalRule(
        "first_leader",
        frozenset({RequestedAction.LEADER_POSITION}),
        frozenset({Right.LEAD_BOAT, Right.VEHICLE}),
        lambda r, f: f.chosen_leader == 0 and f.leader not in (None, r.system) and not f.leader_silent,
        lambda r, f: "",
        "Otherwise the first lead boat heard leads, until it has been silent for 30 s.",
    ),
    RefusalRule(
        "another_leader",
        frozenset({RequestedAction.RETURN_TO_FOLLOW}),
        frozenset({Right.BOAT}),
        lambda r, f: f.followed is not None and f.leader != f.followed and not f.chosen_leader,
        lambda r, f: "it is another leader",
        "The boat does not go back to Follow by itself behind another leader, unless FOLL_SYSID names it.",
    ),
    RefusalRule(
        "lead_boat_asks_otherwise",
        frozenset({RequestedAction.RETURN_TO_FOLLOW}),
        frozenset({Right.BOAT}),
        lambda r, f: f.lead_boat_decides and f.wish in (Wish.MANUAL, Wish.REMOTE),
        lambda r, f: f"the lead boat asks for {WISHES[f.wish or Wish.NONE]}",
        "Nor while the lead boat's crew asks for another mode (with FOLL_AUTH 1).",
    ),
    RefusalRule(
        "somebody_steers",
        frozenset({RequestedAction.RETURN_TO_FOLLOW}),
        frozenset({Right.BOAT}),
        lambda r, f: f.sticks_moved,
        lambda r, f: "somebody steers",
        "Nor while somebody steers by stick.",
    ),
    RefusalRule(
        "leader_elsewhere",
        frozenset({RequestedAction.STAND_IN}),
        frozenset({Right.LEAD_BOAT}),
        lambda r, f: f.intended is not ModeId.FOLLOW and f.remote_system != r.system,
        lambda r, f: "",
        "The leader counts as a ground station (NAV_DLL_ACT) only in Follow, and while it steers by remote.",
    ),
    RefusalRule(
        "stream_elsewhere",
        frozenset({RequestedAction.STAND_IN}),
        frozenset({Right.OFFBOARD}),
        lambda r, f: f.mode is not ModeId.OFFBOARD,
        lambda r, f: "",
        "A stream of setpoints counts as a ground station (NAV_DLL_ACT) only in Offboard.",
    ),
)

_ABOUT: Mapping[RequestedAction, Mapping[Right, tuple[RefusalRule, ...]]] = {
    action: {right: tuple(row for row in ROWS if action in row.about and right in row.by) for right in Right}
    for action in RequestedAction
}
_STICKS = tuple(AuthorityRequest(RequestedAction.STEER, right) for right in (Right.GROUND_STATION, Right.TRANSMITTER))


def refusal(request: AuthorityRequest, facts: Facts) -> str | None:
    """Why `request` is refused, for people; "" where it is ignored without a word; None where it is obeyed."""
    for row in _ABOUT[request.action][request.right]:
        if row.refuses(request, facts):
            return row.text(request, facts)
    return None


def sticks_in_charge(facts: Facts) -> tuple[Right, ...]:
    """Whose sticks may steer, in order: the first of them that is live steers. The ground station here is the one that
    the rows of GROUND_STICKS let in. Depends on `safe_switch` and `remote_system` only."""
    return tuple(request.right for request in _STICKS if refusal(request, facts) is None)
