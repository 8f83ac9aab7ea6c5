"""Every reason for which the boat leaves its mode, in order of precedence.

Each change of mode names its `Cause` (`Helm.switch`, `Helm.choose_disarmed`, `Helm.stop`); a test walks all calls.
`MODE_CHANGES` has at least one row for each cause, and one for each failsafe of `failsafes.py`. The documentation's
page of mode changes is generated from it.

Precedence: a row beats those below it. The safe switch beats all. What a person asks for ends the failsafes that last;
they act again once they have ended and begin anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from companion.core.decision import LossFailsafe, ModeId
from companion.modes.table import DECLARATIONS
from companion.params.table import TABLE
from companion.supervisor.failsafes import FAILSAFES, Failsafe, FailsafeAction


class Cause(Enum):
    """Why the mode changes, or why the boat has no thrust until the next request."""

    SAFE_SWITCH = "safe_switch"
    TRANSMITTER = "transmitter"
    OPERATOR = "operator"
    LEAD_BOAT = "lead_boat"
    FAILSAFE = "failsafe"
    FAILSAFE_OVER = "failsafe_over"
    FENCE = "fence_stops"
    OBSTACLE = "obstacle_stops"
    MODE_FAILED = "mode_failed"
    GUARD_FAILED = "guard_failed"
    MISSION_ITEM = "mission_item"
    MISSION_ITEM_REFUSED = "mission_item_refused"
    MISSION_END = "mission_end"
    TRIAL_END = "trial_end"
    RESTART = "restart"

    @property
    def keeps_intended(self) -> bool:
        """Whether the mode last asked for stays what it was, so that the boat may go back to it."""
        return self in _BY_THE_BOAT


_BY_THE_BOAT = frozenset(
    {
        Cause.FAILSAFE,
        Cause.FAILSAFE_OVER,
        Cause.FENCE,
        Cause.OBSTACLE,
        Cause.MODE_FAILED,
        Cause.GUARD_FAILED,
        Cause.MISSION_ITEM_REFUSED,
    }
)


@dataclass(frozen=True, slots=True)
class ModeChange:
    """One reason. `leaves`, `to`: the modes, for people. `parameter`: sets the condition or the mode; "" for none."""

    name: str
    cause: Cause
    leaves: str
    to: str
    condition: str
    parameter: str = ""


_HOLD_OR_NO_THRUST = "Hold, or no thrust if that is not possible"


def _of(failsafe: Failsafe) -> ModeChange:
    """A failsafe that acts. One that only warns is no mode change."""
    condition = f"The failsafe {failsafe.name} acts, and no failsafe above it has acted and lasts"
    if isinstance(failsafe.action, FailsafeAction):
        return ModeChange(failsafe.name, Cause.FAILSAFE, "any", "the same, without thrust", condition)
    choices = next(spec.choices for spec in TABLE if spec.name == failsafe.action)
    to = [text for number, text in choices.items() if failsafe.actions[number] is not FailsafeAction.IGNORE]
    return ModeChange(failsafe.name, Cause.FAILSAFE, "any", ", ".join(to), condition, failsafe.action)


_RETURNS = {
    mode: declared.failsafe
    for mode, declared in DECLARATIONS.items()
    if declared.failsafe is not None and declared.failsafe.back_after is not None
}


def _back_from(mode: ModeId, failsafe: LossFailsafe) -> ModeChange:
    """The end of a failsafe after which the boat returns to its mode by itself."""
    return ModeChange(
        f"{failsafe.name}_over",
        Cause.FAILSAFE_OVER,
        f"the mode that the failsafe {failsafe.name} chose",
        f"{mode.value}; Hold, or the mode of the failsafe, if a rule of authority refuses or another failsafe lasts",
        f"What {mode.value} steers by has been good for so long",
        failsafe.back_after or "",
    )


MODE_CHANGES: tuple[ModeChange, ...] = (
    ModeChange(
        Cause.SAFE_SWITCH.value,
        Cause.SAFE_SWITCH,
        "any but Manual",
        "Manual",
        "The transmitter's safe switch is on and the transmitter is heard",
        "MAN_RC_SAFE_CH",
    ),
    ModeChange(
        Cause.TRANSMITTER.value,
        Cause.TRANSMITTER,
        "any",
        "RTL, Hold or Offboard; the mode at the position of the mode switch, or of a channel's function",
        "The transmitter's return, hold, offboard or mode switch is moved, or a channel with a function (RC5_OPTION)",
        "RC_MAP_FLTMODE",
    ),
    ModeChange(
        Cause.OPERATOR.value,
        Cause.OPERATOR,
        "any",
        "the mode asked for; Hold for a go-to or a pause",
        "A ground station that may command asks for a mode, a go-to, a pause, a mission or Follow",
    ),
    ModeChange(
        Cause.LEAD_BOAT.value,
        Cause.LEAD_BOAT,
        "any",
        "Follow, or Manual",
        "The lead boat's crew presses for it",
        "FOLL_AUTH",
    ),
    *(_of(failsafe) for failsafe in FAILSAFES if failsafe.action is not FailsafeAction.IGNORE),
    *(_back_from(mode, declared) for mode, declared in _RETURNS.items()),
    ModeChange(
        Cause.FENCE.value,
        Cause.FENCE,
        "any self-steered",
        _HOLD_OR_NO_THRUST,
        "A new fence cuts off the way of the mode, or the mission finds its way blocked",
    ),
    ModeChange(
        Cause.OBSTACLE.value,
        Cause.OBSTACLE,
        "Mission, RTL",
        _HOLD_OR_NO_THRUST,
        "No way leads round the obstacles for so long",
        "CP_WAIT",
    ),
    ModeChange(
        Cause.MODE_FAILED.value,
        Cause.MODE_FAILED,
        "any",
        _HOLD_OR_NO_THRUST,
        "An error of the program in the mode",
    ),
    ModeChange(
        Cause.GUARD_FAILED.value,
        Cause.GUARD_FAILED,
        "any self-steered but Hold",
        _HOLD_OR_NO_THRUST,
        "An error of the program in the guards of fence, traffic and obstacles",
    ),
    ModeChange(
        Cause.MISSION_ITEM.value,
        Cause.MISSION_ITEM,
        "Mission",
        "Follow, or Trial",
        "The mission comes to DO_FOLLOW, or to MAV_CMD_USER_5",
    ),
    ModeChange(
        Cause.MISSION_ITEM_REFUSED.value,
        Cause.MISSION_ITEM_REFUSED,
        "Mission",
        _HOLD_OR_NO_THRUST,
        "The mission comes to DO_FOLLOW or MAV_CMD_USER_5, and Follow or Trial is refused",
    ),
    ModeChange(
        Cause.MISSION_END.value,
        Cause.MISSION_END,
        "Mission",
        "Dock if the last item docks; else Hold, RTL or no thrust, as the parameter says; Hold for a cleared mission",
        "The mission is complete, or is cleared",
        "MIS_DONE_ACT",
    ),
    ModeChange(
        Cause.TRIAL_END.value,
        Cause.TRIAL_END,
        "Trial",
        f"Mission, if it began the trial and the trial is complete; else {_HOLD_OR_NO_THRUST}",
        "The trial is complete, or gives up",
    ),
    ModeChange(
        Cause.RESTART.value,
        Cause.RESTART,
        "Manual, disarmed",
        "Mission if the parameter is 1, else Hold; disarmed",
        "The program starts and a mission was interrupted",
        "MIS_ON_START",
    ),
)
"""Name, cause, modes, condition and parameter of each, for the documentation."""
