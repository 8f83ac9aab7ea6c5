"""A magnetometer calibrated while the boat turns: by its own engine, by hand, in waves; and what goes wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from companion.config.devices import SensorConfig
from companion.core.readings import GroundVelocity, Imu, MagneticField, Reading
from companion.nav.compass_calibration import CompassCalibration
from companion.nav.compass_turns import Turns, TurnsError, fit_turns
from companion.nav.field_fit import FieldFit, headings
from companion.nav.mounting import Mounting
from companion.params.store import Parameters
from tests.unit.nav.ahrs_motion import DECLINATION_RAD, GRAVITY_MPS2, Motion, Sailing, sail

DIP_RAD = math.radians(71.3)
OFFSET = np.array([9.0, -14.0, 6.0])  # in µT of a field of 50: more than its horizontal part
DISTORTION = 50.0 * np.array([[1.06, 0.03, -0.02], [0.03, 0.94, 0.02], [-0.02, 0.02, 1.03]])
ROW = SensorConfig(name="imu", driver="mtdata2", port="memory:imu", heading="ahrs", x_m=-0.81, z_m=-0.2)
SAILING = Sailing(
    parts=((6.0, 1.5, 0.0), (50.0, 1.5, 0.03), (50.0, 1.5, -0.03)),
    wave_rad=math.radians(2.0),
    wave_m=0.05,
    iron=0.0,
    lever_m=(0.81, 0.0, 0.0),
)
BY_HAND = replace(SAILING, parts=((6.0, 0.0, 0.0), (90.0, 0.0, 0.0171)), wave_m=0.02, heel=0.0)
WITH_RESTS = replace(BY_HAND, parts=((6.0, 0.0, 0.0), *8 * ((5.0, 0.0, 0.0356), (45.0, 0.0, 0.0))))  # 20 deg/s
TICK = 20  # samples


def readings_of(motion: Motion, field: bool = True) -> list[list[Reading]]:
    """Those of each tick."""
    measured = motion.field @ DISTORTION.T + OFFSET
    ticks: list[list[Reading]] = []
    for k in range(0, len(motion.t_s), 4):
        t_s = float(motion.t_s[k])
        if k % TICK == 0:
            ticks.append([GroundVelocity(t_s, "gnss", *motion.velocity[k].tolist())])
        ticks[-1].append(Imu(t_s, "imu", *motion.force[k].tolist(), *motion.rates[k].tolist()))
        if field and k % 16 == 0:
            ticks[-1].append(MagneticField(t_s, "imu", *measured[k].tolist()))
    return ticks


def calibrated(ticks: Sequence[Sequence[Reading]], **mounted: float) -> tuple[CompassCalibration, list[float]]:
    """The calibration after these ticks, of devices that are `mounted` so by parameters; its progress meanwhile."""
    boat: Any = SimpleNamespace(sensors=(ROW,))
    mounting = Mounting(boat, Parameters(mounted))
    calibration = CompassCalibration(ROW, mounting, {"gnss": (0.0, 0.0, -0.2)}, GRAVITY_MPS2, DIP_RAD, 0.0)
    progress = []
    for k, readings in enumerate(ticks):
        calibration.update(readings, 0.1 * k)
        progress.append(calibration.progress)
    return calibration, progress


def worst_deg(found: FieldFit, motion: Motion) -> float:
    """Largest heading error over a circle on a level boat, beside the one that no calibration sees: a turn of all."""
    yaw = np.linspace(0.0, 2 * math.pi, 72)
    zero: Any = np.zeros((72, 2))
    h = math.cos(DIP_RAD)
    true = np.stack([h * np.cos(yaw), -h * np.sin(yaw), np.full(72, math.sin(DIP_RAD))], axis=1)
    heading, _ = headings((true @ DISTORTION.T + OFFSET - found.offset) @ found.matrix, zero)
    return math.degrees(float(np.max(np.abs(np.remainder(heading - yaw + math.pi, 2 * math.pi) - math.pi))))


@pytest.mark.parametrize(
    "sailing",
    [SAILING, BY_HAND, replace(BY_HAND, seed=5), WITH_RESTS],
    ids=["circles", "hand", "another", "with rests"],
)
def test_two_slow_turns_calibrate(sailing: Sailing) -> None:
    motion = sail(sailing)
    calibration, progress = calibrated(readings_of(motion))
    assert calibration.failure is None and calibration.result is not None
    assert worst_deg(calibration.result, motion) < 2.0 < 30.0
    assert progress == sorted(progress) and progress[-1] == 1.0
    assert abs(DECLINATION_RAD) > 0.05  # which does not matter to it
    assert math.hypot(*calibration.direction) == pytest.approx(1.0)
    before = calibration.result
    calibration.update([Imu(1000.0, "imu", 0.0, 0.0, -9.8, 0.0, 0.0, 0.0)], 1000.0)
    assert calibration.result is before and calibration.failure is None


def test_a_turned_device_is_fitted_in_its_own_axes() -> None:
    """The board looks to starboard, its magnetometer lies upside down."""
    board = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    over = np.diag([1.0, -1.0, -1.0])

    def seen(reading: Reading) -> Reading:
        if isinstance(reading, MagneticField):
            x, y, z = (over.T @ [reading.x, reading.y, reading.z]).tolist()
            return replace(reading, x=x, y=y, z=z)
        if not isinstance(reading, Imu):
            return reading
        force = board.T @ [reading.x_mps2, reading.y_mps2, reading.z_mps2]
        rates = board.T @ [reading.roll_rate_radps, reading.pitch_rate_radps, reading.yaw_rate_radps]
        return Imu(reading.t_s, reading.source, *force.tolist(), *rates.tolist())

    ticks = readings_of(sail(BY_HAND))
    straight = calibrated(ticks)[0].result
    turned = calibrated([[seen(r) for r in tick] for tick in ticks], SENS_BOARD_ROT=2, CAL_MAG0_ROT=8)[0].result
    assert straight is not None and turned is not None
    assert over @ turned.offset == pytest.approx(straight.offset, abs=0.01)
    assert over @ turned.matrix @ over.T == pytest.approx(straight.matrix, abs=1e-4)


def test_one_turn_is_not_the_end() -> None:
    motion = sail(replace(BY_HAND, parts=((6.0, 0.0, 0.0), (45.0, 0.0, 0.0171))))
    calibration, progress = calibrated(readings_of(motion))
    assert calibration.result is None and calibration.failure is None
    assert 0.4 < progress[-1] < 0.8 and len(calibration.sectors) == 24


def test_a_boat_that_only_rocks_gets_nowhere() -> None:
    motion = sail(replace(BY_HAND, parts=((70.0, 0.0, 0.0),), wave_rad=math.radians(6.0)))
    calibration, progress = calibrated(readings_of(motion))
    assert calibration.failure == "no turn for 60 s" and progress[-1] < 0.2


def test_a_sensor_without_data_is_named() -> None:
    motion = sail(replace(BY_HAND, parts=((8.0, 0.0, 0.0),)))
    assert calibrated(readings_of(motion, field=False))[0].failure == "no field from imu"
    assert calibrated([[]] * 50)[0].failure == "imu is silent"


@pytest.mark.parametrize("missing", [range(1), range(5, 20), (4, 10, 16, 22)], ids=["one", "many", "four"])
def test_missing_headings_fit_into_a_status_text(missing: Sequence[int]) -> None:
    """Turns that the gyro counts and the fit has no samples of: the text came in two."""
    yaw = np.array([(k + 0.5) * math.tau / 24 for k in range(24) if k not in missing for _ in range(40)])
    h, tilt = math.cos(DIP_RAD), np.zeros((len(yaw), 2))
    field = np.stack([h * np.cos(yaw), -h * np.sin(yaw), np.full(len(yaw), math.sin(DIP_RAD))], axis=1)
    field += 0.001 * np.random.default_rng(722201).standard_normal(field.shape)
    with pytest.raises(TurnsError, match="no headings to the ") as raised:
        fit_turns(Turns(np.arange(len(yaw), dtype=float), field, tilt, DIP_RAD))
    print(raised.value, "|", raised.value.brief)
    assert len(f"Compass not calibrated: {raised.value.brief}") <= 50 and raised.value.brief.startswith("no headings ")


def test_iron_that_moves_is_refused() -> None:
    ticks = readings_of(sail(BY_HAND))
    moved = [
        [replace(r, y=r.y + 8.0) if isinstance(r, MagneticField) and k % 40 > 20 else r for r in readings]
        for k, readings in enumerate(ticks)
    ]
    failure = calibrated(moved)[0].failure
    assert failure is not None and "left" in failure
