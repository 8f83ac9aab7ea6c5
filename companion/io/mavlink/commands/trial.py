"""MAV_CMD_USER_5 (31014): a sea trial here, for ground stations' action buttons. param1: radius of its circle."""

from __future__ import annotations

import math

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.modes.trial.mode import TrialOrder
from companion.supervisor.supervisor import Supervisor


def user_5(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Begin a sea trial in Trial, or go on with one that was interrupted. Whoever sends it accepts the circle.

    param1: Radius of the circle around the boat in metres; 0 or NaN: TRIAL_RADIUS.
    """
    radius_m = request.params[0]
    if math.isinf(radius_m) or radius_m < 0.0:
        return denied("trial: radius (param 1) should be above 0 m")
    order = TrialOrder(None if math.isnan(radius_m) or radius_m == 0.0 else radius_m)
    return supervisor.give_order(order, request.now_s)
