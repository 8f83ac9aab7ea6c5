"""MAV_CMD_PREFLIGHT_CALIBRATION and ArduPilot's MAG_CAL commands; and how the progress is told to each persona."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega

from companion.core.decision import Outcome, Result
from companion.core.storing import Ticket
from companion.io.mavlink.wire.framer import frame, pack
from companion.nav.field_fit import FieldFit
from companion.supervisor.calibration import CalibrationKind, CalibrationPhase, CalibrationState, CompassState
from tests.unit.io.mavlink.hub.conftest import Rig
from tests.unit.io.mavlink.slow_storage import SlowStorage

PREFLIGHT, START, ACCEPT, CANCEL = 241, 42424, 42425, 42426
ACCEPTED, REJECTED, DENIED = 0, 1, 2


def result(messages: list[Any]) -> int:
    (answer,) = [m for m in messages if m.get_type() == "COMMAND_ACK"]
    return int(answer.result)


def texts(messages: list[Any]) -> list[str]:
    return [m.text for m in messages if m.get_type() == "STATUSTEXT"]


@pytest.mark.parametrize(
    ("params", "asked"),
    [
        ((1,), ("calibrate", CalibrationKind.GYRO, True)),
        ((0, 1), ("calibrate", CalibrationKind.COMPASS, True)),
        ((1, 1), ("calibrate", CalibrationKind.GYRO, True)),  # pymavlink's calibrate_imu
        ((0, 0, 0, 0, 1), ("calibrate", CalibrationKind.LEVEL, True)),
        ((0, 0, 0, 0, 2), ("calibrate", CalibrationKind.LEVEL, True)),
        ((0, 0, 0, 0, 4), ("calibrate", CalibrationKind.LEVEL, True)),
        ((), ("cancel",)),
        ((math.nan,) * 7, ("cancel",)),
    ],
)
def test_preflight_calibration(rig: Rig, params: tuple[float, ...], asked: tuple[Any, ...]) -> None:
    assert result(rig.command(PREFLIGHT, *params)) == ACCEPTED
    assert rig.supervisor.asked == [asked]


@pytest.mark.parametrize(
    "params", [(0, 0, 1), (0, 0, 0, 0, 3), (0, 0, 0, 0, 0, 1), (0, 0, 0, 0, 0, 0, 1), (3,), (0, 76)]
)
def test_what_a_boat_does_not_calibrate(rig: Rig, params: tuple[float, ...]) -> None:
    assert result(rig.command(PREFLIGHT, *params)) == DENIED and rig.supervisor.asked == []


def test_the_accelerometer_is_its_level(rig: Rig) -> None:
    assert texts(rig.command(PREFLIGHT, 0, 0, 0, 0, 1)) == ["Accelerometer: a boat takes its level only"]
    rig.supervisor.outcome = Outcome(Result.TEMPORARILY_REJECTED, "disarm first")
    answers = rig.command(PREFLIGHT, 0, 0, 0, 0, 4)
    assert result(answers) == REJECTED and texts(answers) == []


def test_ardupilots_commands() -> None:
    rig = Rig(["memory:?dialect=ardupilot"])
    for command, params, asked in (
        (START, (0, 1, 0), ("calibrate", CalibrationKind.COMPASS, False)),
        (START, (1, 0, 1), ("calibrate", CalibrationKind.COMPASS, True, 1)),
        (ACCEPT, (1,), ("accept",)),
        (CANCEL, (), ("cancel",)),
    ):
        rig.supervisor.asked.clear()
        assert result(rig.command(command, *params)) == ACCEPTED and rig.supervisor.asked == [asked]


@pytest.mark.parametrize("bits", [-1.0, 0.5])
def test_what_are_no_bits_of_compasses(rig: Rig, bits: float) -> None:
    assert result(rig.command(START, bits)) == DENIED and rig.supervisor.asked == []


FIT = FieldFit(np.array([1.0, 2.0, 3.0]), np.eye(3), True, 0.01, 0.1, np.full(24, 0.02), np.zeros(24), 0.001)


def state(
    phase: CalibrationPhase,
    progress: float = 0.0,
    kind: CalibrationKind = CalibrationKind.COMPASS,
    run: int = 1,
    text: str = "",
) -> CalibrationState:
    compass = CompassState(0, "imu", progress, (0.0, 1.0, 0.0), text or None, FIT if progress >= 1.0 else None)
    return CalibrationState(run, kind, phase, progress, text, (compass,) if kind is CalibrationKind.COMPASS else ())


def show(rig: Rig, *states: CalibrationState) -> list[list[Any]]:
    """What each desk hears while the calibration goes through these states, a second each."""
    for desk in rig.desks:
        desk.hear()
    for one in states:
        rig.supervisor.calibration.state = one
        rig.run(1.0)
    return [desk.hear() for desk in rig.desks]


def cal_lines(messages: list[Any]) -> list[str]:
    return [text for text in texts(messages) if text.startswith("[cal]")]


def test_texts_for_px4_and_messages_for_ardupilot() -> None:
    rig = Rig(["memory:", "memory:?dialect=ardupilot"])
    px4, ardupilot = show(
        rig,
        state(CalibrationPhase.RUNNING),
        state(CalibrationPhase.RUNNING, 0.5),
        state(CalibrationPhase.FITTED, 1.0),
        state(CalibrationPhase.DONE, 1.0),
    )
    assert cal_lines(px4) == [
        "[cal] calibration started: 2 mag",
        "[cal] down orientation detected",
        "[cal] progress <0>",
        "[cal] progress <50>",
        "[cal] progress <100>",
        "[cal] down side done, rotate to a different side",
        "[cal] calibration done: mag",
    ]
    assert all(len(text) <= 50 for text in texts(px4)) and cal_lines(ardupilot) == []
    progress = [m for m in ardupilot if m.get_type() == "MAG_CAL_PROGRESS"]
    reports = [m for m in ardupilot if m.get_type() == "MAG_CAL_REPORT"]
    assert [m.completion_pct for m in progress] == [0, 50] and {m.cal_status for m in progress} == {2}
    assert [(m.cal_status, m.autosaved, m.ofs_z, m.diag_x) for m in reports] == [(4, 0, 3.0, 1.0), (4, 1, 3.0, 1.0)]
    assert not [m for m in px4 if m.get_type().startswith("MAG_CAL")]


def test_the_second_compass_alone_has_its_own_number() -> None:
    rig = Rig(["memory:?dialect=ardupilot"])
    fitted = state(CalibrationPhase.DONE, 1.0)
    second = replace(fitted, compasses=(replace(fitted.compasses[0], number=1),))
    (told,) = show(rig, replace(second, phase=CalibrationPhase.RUNNING), second)
    numbers = [(m.get_type(), m.compass_id, m.cal_mask) for m in told if m.get_type().startswith("MAG_CAL")]
    assert numbers == [("MAG_CAL_PROGRESS", 1, 2), ("MAG_CAL_REPORT", 1, 2)]


def test_a_failure_and_a_cancelled_one() -> None:
    rig = Rig(["memory:", "memory:?dialect=ardupilot"])
    px4, ardupilot = show(
        rig,
        state(CalibrationPhase.RUNNING),
        state(CalibrationPhase.FAILED, text="no turn for 60 s"),
        state(CalibrationPhase.CANCELLED, run=2),
        state(CalibrationPhase.DONE, 1.0, CalibrationKind.GYRO, run=3),
    )
    assert [line for line in cal_lines(px4) if "progress" not in line] == [
        "[cal] calibration started: 2 mag",
        "[cal] down orientation detected",
        "[cal] calibration failed: no turn for 60 s",
        "[cal] calibration started: 2 mag",
        "[cal] down orientation detected",
        "[cal] calibration cancelled",
        "[cal] calibration started: 2 gyro",
        "[cal] calibration done: gyro",
    ]
    assert [m.cal_status for m in ardupilot if m.get_type() == "MAG_CAL_REPORT"] == [5]


def test_progress_is_told_twice_a_second_at_most(rig: Rig) -> None:
    states = [replace(state(CalibrationPhase.RUNNING), progress=0.01 * k) for k in range(20)]
    rig.desk.hear()
    for one in states:
        rig.supervisor.calibration.state = one
        rig.tick()
    assert 3 <= len([line for line in cal_lines(rig.desk.hear()) if "progress" in line]) <= 5


def test_ardupilots_own_library_reads_the_progress() -> None:
    rig = Rig(["memory:?dialect=ardupilot"])
    (messages,) = show(rig, state(CalibrationPhase.RUNNING, 0.25))
    (sent,) = [m for m in messages if m.get_type() == "MAG_CAL_PROGRESS"]
    (read,) = ardupilotmega.MAVLink(None).parse_buffer(frame(pack(sent), 0, 1, 1))
    assert (read.get_type(), read.completion_pct, read.direction_y) == ("MAG_CAL_PROGRESS", 25, 1.0)
    assert sum(byte.bit_count() for byte in read.completion_mask) == 20


class OneChange(SlowStorage):
    """The parameters have changed once."""

    def __init__(self) -> None:
        super().__init__()
        self._change = super().parameters()

    def parameters(self) -> Ticket:
        return self._change


def test_it_is_done_when_its_result_is_stored() -> None:
    rig = Rig(["memory:", "memory:?dialect=ardupilot"])
    storage = rig.vessel.storage = OneChange()
    rig.command(ACCEPT, desk=1)
    px4, ardupilot = show(rig, state(CalibrationPhase.RUNNING), state(CalibrationPhase.DONE, 1.0))
    assert cal_lines(px4)[-1] == "[cal] progress <0>" and not reported(ardupilot)
    storage.settle()
    assert result(rig.ask(desk=1)) == ACCEPTED
    px4, ardupilot = show(rig, state(CalibrationPhase.DONE, 1.0))
    assert cal_lines(px4)[-1] == "[cal] calibration done: mag" and reported(ardupilot) == [(4, 1)]


def test_a_result_that_is_not_stored_has_failed() -> None:
    rig = Rig(["memory:", "memory:?dialect=ardupilot"])
    storage = rig.vessel.storage = OneChange()
    show(rig, state(CalibrationPhase.RUNNING), state(CalibrationPhase.DONE, 1.0))
    storage.fail()
    px4, ardupilot = show(rig, state(CalibrationPhase.DONE, 1.0))
    assert cal_lines(px4) == ["[cal] calibration failed: not stored"]
    assert reported(ardupilot) == [(5, 0)]


def reported(messages: list[Any]) -> list[tuple[int, int]]:
    return [(m.cal_status, m.autosaved) for m in messages if m.get_type() == "MAG_CAL_REPORT"]
