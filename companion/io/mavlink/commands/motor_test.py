"""MAV_CMD_ACTUATOR_TEST (310), a stream of short tests from QGroundControl's Actuators page, and MAV_CMD_DO_MOTOR_TEST
(209), one test with a time, from its Motors page, Mission Planner and MAVProxy. Motors are the thrusters in the order
of the vessel's file."""

from __future__ import annotations

import math

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied
from companion.params.compatibility import FIRST_MOTOR, MOTORS
from companion.supervisor.motor_test import is_stop
from companion.supervisor.supervisor import Supervisor

_MOTORS = range(1, 17)  # ACTUATOR_OUTPUT_FUNCTION_MOTOR1…16
_OWN = 1000  # QGroundControl adds it to the numbers of the vehicle's own metadata
_OWN_MOTORS = range(FIRST_MOTOR, FIRST_MOTOR + MOTORS)
_LONGEST_S = 3.0  # MAVLink, common.xml
_PERCENT = 0  # MOTOR_TEST_THROTTLE_PERCENT


def actuator_test(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Run a thruster for a moment, while disarmed. A stream of these runs it on.

    param1: Throttle −1…1, at most 0.3 either way; NaN: stop it.
    param2: Seconds after which it stops, at most 3; 0: at once.
    param5: Motor: 1 is the first thruster of the vessel's file. QGroundControl sends 1100 more.
    """
    throttle, duration_s, function = request.params[0], request.params[1], request.whole(5)
    if function is not None and function - _OWN in _OWN_MOTORS:
        function -= _OWN + _OWN_MOTORS[0] - 1
    if function is None or function not in _MOTORS:
        return denied("motors alone are tested: param 5 from 1")
    index = function - 1
    if is_stop(throttle, duration_s):
        return supervisor.motor_test.stop(index, request.now_s)
    if not 0.0 < duration_s <= _LONGEST_S:
        return denied("param 2 of an actuator test should be 0 to 3 s")
    return supervisor.motor_test.begin(index, throttle, duration_s, request.now_s)


def do_motor_test(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Run a thruster for some seconds, while disarmed.

    param1: Motor: 1 is the first thruster of the vessel's file.
    param2: 0: param 3 is in percent.
    param3: Throttle in percent, at most 30; negative astern; 0: stop it.
    param4: Seconds, at most 10; 0: stop it.
    param5: How many motors, one after the other; 0 or 1: one.
    param6: Order of the motors; the same for all.
    """
    motor, kind, count = request.whole(1), request.whole_or(2, 0), request.whole_or(5, 0)
    percent, duration_s = request.params[2], request.params[3]
    if motor is None or count is None or not 0 <= count <= len(_MOTORS):
        return denied("params 1 and 5 of a motor test should be whole")
    if kind != _PERCENT:
        return denied("a motor test takes percent: param 2 = 0")
    if is_stop(percent, duration_s):
        return supervisor.motor_test.stop(motor - 1, request.now_s)
    throttle = percent / 100.0 if math.isfinite(percent) else math.inf
    return supervisor.motor_test.begin(motor - 1, throttle, duration_s, request.now_s, max(1, count))
