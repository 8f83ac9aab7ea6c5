"""Calibrations as the supervisor runs them: one at a time, stored or waiting to be accepted, never under way."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from companion.config.devices import SensorConfig
from companion.config.vessel import VesselConfig
from companion.core.decision import ModeId, Result
from companion.core.readings import Imu, Reading
from companion.nav.field_fit import FieldFit
from companion.supervisor import calibration
from companion.supervisor.calibration import CalibrationDuty, CalibrationKind, CalibrationPhase, compass_values


def lie_still(boat: Any, duration_s: float, swing_radps: float = 0.0) -> None:
    """The boat's inertial sensor, mounted 2° down by the bow, while nothing moves but what is asked for."""
    duty: CalibrationDuty = boat.supervisor.calibration
    for _ in range(round(duration_s * 10)):
        boat.tick()
        readings: list[Reading] = [
            Imu(boat.now_s, "imu", -9.81 * math.sin(math.radians(2.0)), 0.0, -9.80, swing_radps * (-1) ** k, 0.0, 0.001)
            for k in range(10)
        ]
        duty.take(readings, boat.now_s)


def phase(boat: Any) -> CalibrationPhase | None:
    state = boat.supervisor.calibration.state
    return None if state is None else state.phase


def test_a_level_is_stored_as_parameters(boat: Any) -> None:
    assert boat.supervisor.calibration.request(CalibrationKind.LEVEL, boat.now_s).accepted
    lie_still(boat, 5.0)
    assert phase(boat) is CalibrationPhase.RUNNING and 0.4 < boat.supervisor.calibration.state.progress < 0.6
    lie_still(boat, 6.0)
    assert phase(boat) is CalibrationPhase.DONE and boat.supervisor.calibration.state.run == 1
    assert boat.parameters["SENS_BOARD_Y_OFF"] == pytest.approx(-2.0, abs=0.01)
    assert boat.texts()[-2:] == ["Level calibration: keep the boat still", "Level calibrated: roll 0.0, pitch -2.0 deg"]


@pytest.mark.parametrize(("bow_down_deg", "said"), [(2.5, []), (5.0, ["other lies 3.0 deg off that level"])])
def test_of_several_inertial_sensors_the_first_that_is_heard_gives_the_level_of_all(
    make_boat: Callable[..., Any], revolt: VesselConfig, bow_down_deg: float, said: list[str]
) -> None:
    """The level of the second one was never looked at, and a first one that is silent ended the calibration."""
    boat = make_boat(with_inertial(revolt, "broken", "imu", "other"))
    duty: CalibrationDuty = boat.supervisor.calibration
    assert duty.request(CalibrationKind.LEVEL, boat.now_s).accepted
    for _ in range(110):
        boat.tick()
        duty.take([pitched("imu", boat.now_s, 2.0), pitched("other", boat.now_s, bow_down_deg)], boat.now_s)
    assert phase(boat) is CalibrationPhase.DONE
    assert boat.parameters["SENS_BOARD_Y_OFF"] == pytest.approx(-2.0, abs=0.01)
    assert "Level left out: broken is silent" in boat.texts()
    assert boat.texts()[boat.texts().index("Level calibrated: roll 0.0, pitch -2.0 deg") + 1 :] == said


def pitched(name: str, t_s: float, bow_down_deg: float) -> Imu:
    pitch = math.radians(bow_down_deg)
    return Imu(t_s, name, -9.81 * math.sin(pitch), 0.0, -9.81 * math.cos(pitch), 0.0, 0.0, 0.0)


def with_inertial(config: VesselConfig, *names: str) -> VesselConfig:
    """The boat with inertial sensors of these names in place of its own."""
    imu = next(row for row in config.sensors if row.name == "imu")
    others = tuple(row for row in config.sensors if row.name != "imu")
    return replace(config, sensors=(*others, *(replace(imu, name=name) for name in names)))


def test_a_result_may_wait_to_be_accepted(boat: Any) -> None:
    duty = boat.supervisor.calibration
    assert duty.accept(boat.now_s).accepted and phase(boat) is None
    duty.request(CalibrationKind.GYRO, boat.now_s, save=False)
    lie_still(boat, 6.0)
    assert phase(boat) is CalibrationPhase.FITTED and boat.parameters["CAL_GYRO0_ZOFF"] == 0.0
    assert duty.accept(boat.now_s).accepted
    assert phase(boat) is CalibrationPhase.DONE and boat.parameters["CAL_GYRO0_ZOFF"] == pytest.approx(0.001)
    duty.request(CalibrationKind.GYRO, boat.now_s, save=False)
    lie_still(boat, 6.0)
    duty.cancel(boat.now_s)
    assert (
        phase(boat) is CalibrationPhase.CANCELLED
        and duty.accept(boat.now_s).accepted
        and phase(boat) is CalibrationPhase.CANCELLED
    )


def test_one_at_a_time(boat: Any) -> None:
    duty = boat.supervisor.calibration
    duty.request(CalibrationKind.LEVEL, boat.now_s)
    lie_still(boat, 1.0)
    outcome = duty.request(CalibrationKind.GYRO, boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED and "level calibration runs" in outcome.reason
    duty.cancel(boat.now_s)
    assert duty.request(CalibrationKind.GYRO, boat.now_s).accepted and duty.state.run == 2


def test_a_boat_that_rocks_keeps_its_bias(boat: Any) -> None:
    boat.supervisor.calibration.request(CalibrationKind.GYRO, boat.now_s)
    lie_still(boat, 6.0, swing_radps=0.05)
    assert phase(boat) is CalibrationPhase.FAILED and boat.supervisor.calibration.state.text == "the boat moves"
    assert boat.parameters["CAL_GYRO0_XOFF"] == 0.0 and "calibration_failed" in boat.names()


def test_arming_ends_it(boat: Any) -> None:
    boat.supervisor.calibration.request(CalibrationKind.LEVEL, boat.now_s)
    lie_still(boat, 1.0)
    boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s)
    assert boat.supervisor.arm(boat.now_s).accepted
    lie_still(boat, 0.2)
    assert phase(boat) is CalibrationPhase.FAILED and boat.supervisor.calibration.state.text == "disarm first"
    refused = boat.supervisor.calibration.request(CalibrationKind.GYRO, boat.now_s)
    assert refused.result is Result.TEMPORARILY_REJECTED


def test_a_boat_without_a_magnetometer_says_so(boat: Any) -> None:
    outcome = boat.supervisor.calibration.request(CalibrationKind.COMPASS, boat.now_s)
    assert outcome.result is Result.DENIED and "heading" in outcome.reason and phase(boat) is None


class Fitted:
    """A compass that is calibrated at once."""

    def __init__(self, row: SensorConfig, *_: object) -> None:
        self.row, self.failure, self.direction = row, None, (1.0, 0.0, 0.0)
        self.progress = 0.0
        self.result: FieldFit | None = None

    def update(self, *_: object) -> None:
        self.progress, self.result = 1.0, fit_with(4.0)


def test_one_compass_of_two_is_calibrated_alone(
    make_boat: Callable[..., Any], revolt: VesselConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the first one is broken it kept the second from being calibrated, and nobody could choose."""
    monkeypatch.setattr(calibration, "CompassCalibration", Fitted)
    imu = next(row for row in revolt.sensors if row.name == "imu")
    two = tuple(replace(imu, name=name, heading="ahrs") for name in ("imu", "second"))
    boat = make_boat(replace(revolt, sensors=(*(row for row in revolt.sensors if row.name != "imu"), *two)))
    duty = boat.supervisor.calibration
    refused = duty.request(CalibrationKind.COMPASS, boat.now_s, bits=4)
    assert (refused.result, refused.reason) == (Result.DENIED, "Calibration refused: no such compass")
    assert duty.request(CalibrationKind.COMPASS, boat.now_s, bits=2).accepted
    assert [(one.number, one.name) for one in duty.state.compasses] == [(1, "second")]
    duty.take([], boat.now_s)
    assert phase(boat) is CalibrationPhase.DONE
    assert (boat.parameters["CAL_MAG0_XSCALE"], boat.parameters["CAL_MAG1_XSCALE"]) == (0.0, 4.0)


def test_a_sensor_that_falls_silent_is_named(boat: Any) -> None:
    boat.supervisor.calibration.request(CalibrationKind.LEVEL, boat.now_s)
    for _ in range(40):
        boat.tick()
        boat.supervisor.calibration.take([], boat.now_s)
    assert boat.supervisor.calibration.state.text == "imu is silent"


@pytest.mark.parametrize("kind", CalibrationKind)
def test_texts_are_one_status_text_whatever_the_sensor_is_called(
    make_boat: Callable[..., Any], revolt: VesselConfig, kind: CalibrationKind
) -> None:
    """They came in two."""
    imu = replace(next(row for row in revolt.sensors if row.name == "imu"), name="a" * 32, heading="ahrs")
    boat = make_boat(replace(revolt, sensors=(*(row for row in revolt.sensors if row.name != "imu"), imu)))
    boat.supervisor.calibration.request(kind, boat.now_s)
    for _ in range(40):
        boat.tick()
        boat.supervisor.calibration.take([], boat.now_s)
    assert boat.texts()[-1] == f"{kind.value} not calibrated: {'a' * 16} is silent"
    assert max(map(len, boat.texts())) <= 50


def test_a_silent_gyro_of_two_keeps_its_value_and_the_other_is_calibrated(
    make_boat: Callable[..., Any], revolt: VesselConfig
) -> None:
    imu = next(row for row in revolt.sensors if row.name == "imu")
    boat = make_boat(replace(revolt, sensors=(replace(imu, name="broken"), *revolt.sensors)))
    boat.parameters.set("CAL_GYRO0_ZOFF", 0.002)
    duty = boat.supervisor.calibration
    duty.request(CalibrationKind.GYRO, boat.now_s)
    lie_still(boat, 6.0)
    assert phase(boat) is CalibrationPhase.DONE and "Gyro left out: broken is silent" in boat.texts()
    assert boat.parameters["CAL_GYRO0_ZOFF"] == pytest.approx(0.002)
    assert boat.parameters["CAL_GYRO1_ZOFF"] == pytest.approx(0.001)


def test_a_compass_is_not_accepted_under_way(
    make_boat: Callable[..., Any], revolt: VesselConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Accepted in Hold it moved the heading by 15 degrees in 4 s."""
    monkeypatch.setattr(calibration, "CompassCalibration", Fitted)
    rows = tuple(replace(row, heading="ahrs") if row.name == "imu" else row for row in revolt.sensors)
    boat = make_boat(replace(revolt, sensors=rows))
    duty = boat.supervisor.calibration
    duty.request(CalibrationKind.COMPASS, boat.now_s, save=False)
    boat.tick()
    duty.take([], boat.now_s)
    assert phase(boat) is CalibrationPhase.FITTED
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    assert boat.supervisor.arm(boat.now_s).accepted and boat.supervisor.status(boat.now_s).mode is ModeId.HOLD
    refused = duty.accept(boat.now_s)
    assert (refused.result, refused.reason) == (
        Result.TEMPORARILY_REJECTED,
        "Calibration refused: disarm, or choose Manual",
    )
    assert phase(boat) is CalibrationPhase.FITTED and boat.parameters["CAL_MAG0_XSCALE"] == 0.0
    boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s)
    assert duty.accept(boat.now_s).accepted and boat.parameters["CAL_MAG0_XSCALE"] == 4.0


def fit_with(diagonal: float) -> FieldFit:
    matrix = np.array([[diagonal, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 3.0]])
    return FieldFit(np.array([1.0, 2.0, 3.0]), matrix, False, 0.01, 0.1, np.full(24, 0.02), np.zeros(24), 0.001)


def test_a_fit_becomes_ten_parameters(make_boat: Callable[..., Any]) -> None:
    values = compass_values(1, fit_with(1.0))
    assert values == pytest.approx(
        {
            "CAL_MAG1_XOFF": 1.0,
            "CAL_MAG1_YOFF": 2.0,
            "CAL_MAG1_ZOFF": 3.0,
            "CAL_MAG1_XSCALE": 1.0,
            "CAL_MAG1_YSCALE": 2.0,
            "CAL_MAG1_ZSCALE": 3.0,
            "CAL_MAG1_XODIAG": 0.1,
            "CAL_MAG1_YODIAG": 0.2,
            "CAL_MAG1_ZODIAG": 0.3,
            "CAL_MAG1_WANDER": math.degrees(0.04),
        }
    )
    assert make_boat().parameters.set_all(values) is None
    with pytest.raises(ValueError, match="does not fit"):
        compass_values(0, fit_with(-1.0))
