"""Calibrations: MAV_CMD_PREFLIGHT_CALIBRATION (241), as QGroundControl and MAVSDK send it, and ArduPilot's commands for
the compass (ardupilotmega.xml), which pymavlink's `common` lacks."""

from __future__ import annotations

from companion.core.decision import Outcome, TextKind
from companion.io.mavlink.commands.request import DONE, Answer, CommandRequest, denied
from companion.io.mavlink.telemetry.statustext import statustexts
from companion.supervisor.calibration import CalibrationKind
from companion.supervisor.supervisor import Supervisor

DO_START_MAG_CAL, DO_ACCEPT_MAG_CAL, DO_CANCEL_MAG_CAL = 42424, 42425, 42426
_ACCELEROMETER = (1, 4)  # six sides, or one: of both a boat takes its level
_LEVEL = 2


def preflight(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Calibrate a sensor. Of several the first is taken. All params 0 cancel the calibration that runs.

    param1: 1: gyro bias, while the boat lies still.
    param2: 1: compass, while the boat turns round twice, slowly.
    param3: Barometer; there is none.
    param4: 1: transmitter; the ground station does it, the boat has nothing to do.
    param5: 2: level; 1 or 4 (accelerometer): a boat takes its level only.
    """
    wanted = [request.whole_or(number, 0) for number in range(1, 8)]
    gyro, compass, _, transmitter, level = wanted[:5]
    if not any(wanted):
        return supervisor.calibration.cancel(request.now_s)
    if gyro == 1:
        return supervisor.calibration.request(CalibrationKind.GYRO, request.now_s)
    if compass == 1:
        return supervisor.calibration.request(CalibrationKind.COMPASS, request.now_s)
    if level == _LEVEL or level in _ACCELEROMETER:
        outcome = supervisor.calibration.request(CalibrationKind.LEVEL, request.now_s)
        note = statustexts(TextKind.ROUTINE, "Accelerometer: a boat takes its level only", 0)
        return Answer(outcome, note) if level in _ACCELEROMETER and outcome.accepted else outcome
    return DONE if transmitter == 1 else denied("a boat calibrates compass, gyro and level")


def start_compass(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Calibrate the compass, while the boat turns round twice, slowly.

    param1: Bits of the compasses; 0: all.
    param2: Whether to try again after a failure; ignored.
    param3: 1: store the result at once; 0: wait for it to be accepted.
    """
    bits = request.whole_or(1, 0)
    if bits is None or bits < 0:
        return denied("param 1 of a compass calibration should be bits")
    return supervisor.calibration.request(
        CalibrationKind.COMPASS, request.now_s, save=request.whole_or(3, 0) == 1, bits=bits
    )


def accept_compass(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Store the result of the compass calibration."""
    outcome = supervisor.calibration.accept(request.now_s)
    return Answer(outcome, sets_parameters=outcome.accepted)


def cancel_compass(supervisor: Supervisor, request: CommandRequest) -> Outcome:
    """Cancel the calibration that runs."""
    return supervisor.calibration.cancel(request.now_s)
