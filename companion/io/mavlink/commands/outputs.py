"""Commands for servo and relay outputs: DO_SET_SERVO, DO_REPEAT_SERVO, DO_SET_RELAY, DO_REPEAT_RELAY, DO_SET_ACTUATOR.

Servos are numbered from 1 and relays from 0, as ground stations do. The same numbers and ranges hold in missions.
"""

from __future__ import annotations

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.mission.auxiliary import action_of
from companion.mission.commands import RULES, Command, name_of
from companion.supervisor.supervisor import Supervisor

NUMBERS: tuple[Command, ...] = (
    Command.DO_SET_RELAY,
    Command.DO_REPEAT_RELAY,
    Command.DO_SET_SERVO,
    Command.DO_REPEAT_SERVO,
    Command.DO_SET_ACTUATOR,
)
ONCE: tuple[Command, ...] = (Command.DO_REPEAT_RELAY, Command.DO_REPEAT_SERVO)  # done again, they would begin again


def auxiliary(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """What the command asks for, or why not."""
    for allowed in RULES[request.command].ranges:
        value = request.params[allowed.number - 1]
        if not allowed.allows(value):
            return denied(f"{allowed.label} of {name_of(request.command)} is {value:g}; {allowed.remedy}")
    actuators = request.command == Command.DO_SET_ACTUATOR
    if actuators and not all(value != value or -1.0 <= value <= 1.0 for value in request.params[4:6]):
        return denied("actuators 5 and 6: give -1 to 1, or NaN for none")
    if actuators and request.params[6] == request.params[6] and request.params[6] != 0.0:
        return denied("there is set 0 of actuators only")
    action = action_of(request.command, request.params[:6] if actuators else request.params)
    return denied("no such output") if action is None else supervisor.auxiliary.request(action, request.now_s)
