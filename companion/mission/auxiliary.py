"""Items and commands for servo and relay outputs → actions."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.mission.commands import Command
from companion.mission.plan import PlanItem
from companion.mission.tasks import AuxiliaryAction, SetActuators, SetRelay, SetServo

UNSET_INT = frozenset({0, 2**31 - 1, -(2**31)})  # x or y without a value: zero, or what clients make of NaN


def auxiliary_of(item: PlanItem) -> AuxiliaryAction | None:
    """The action of a mission item on an output; None for an item of another kind."""
    return action_of(item.command, (item.param1, item.param2, item.param3, item.param4))


def action_of(command: int, params: Sequence[float]) -> AuxiliaryAction | None:
    """The action of a MAV_CMD with checked parameters on an output; None for a command of another kind."""
    match command:
        case Command.DO_SET_SERVO:
            return SetServo(int(params[0]), params[1])
        case Command.DO_REPEAT_SERVO:
            return SetServo(int(params[0]), params[1], int(params[2]), params[3])
        case Command.DO_SET_RELAY:
            return SetRelay(int(params[0]), params[1] == 1.0)
        case Command.DO_REPEAT_RELAY:
            return SetRelay(int(params[0]), None, int(params[1]), params[2])
        case Command.DO_SET_ACTUATOR:
            return SetActuators(tuple(value if math.isfinite(value) else None for value in params))
    return None
