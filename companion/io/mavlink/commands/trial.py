"""MAV_CMD_USER_5 (31014): a sea trial here, and the operator's word on its result, for ground stations' action buttons.
param1: radius of its circle. param2: 0 begin, 1 accept, 2 undo."""

from __future__ import annotations

import math

from companion.core.decision import Outcome
from companion.core.storing import Ticket
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.modes.trial.mode import TrialOrder
from companion.supervisor.supervisor import Supervisor


def user_5(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Begin a sea trial in Trial, or go on with one that was interrupted: whoever sends it accepts the circle.

    Or accept the model that a trial gave, or undo that, disarmed or in Hold: it counts after a reboot.

    param1: Radius of the circle around the boat in metres; 0 or NaN: TRIAL_RADIUS.
    param2: 0 or NaN: trial. 1: accept the newest model. 2: undo; the model before counts again.
    """
    match request.whole_or(2, 0):
        case 0:
            return _begin(supervisor, request)
        case 1:
            return _stored(*supervisor.trial_duty.accept(request.now_s))
        case 2:
            return _stored(*supervisor.trial_duty.undo(request.now_s))
    return denied("trial: param 2 is 0 begin, 1 accept or 2 undo")


def _stored(outcome: Outcome, ticket: Ticket | None) -> Outcome | Answer:
    """Acknowledged once it is on the medium."""
    return outcome if ticket is None else Answer(outcome, stored=ticket, unstored="Trial: nothing changed")


def _begin(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    radius_m = request.params[0]
    if math.isinf(radius_m) or radius_m < 0.0:
        return denied("trial: radius (param 1) should be above 0 m")
    order = TrialOrder(None if math.isnan(radius_m) or radius_m == 0.0 else radius_m)
    return supervisor.give_order(order, request.now_s)
