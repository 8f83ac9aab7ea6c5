"""Which inertial sensor the filter gets, and in what state."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from companion.core.readings import Imu
from companion.nav.corrections import corrections_of
from companion.nav.inertial_source import InertialSource
from companion.nav.integrity.evidence import Sense
from companion.nav.mounting import Mounting
from companion.params.store import Parameters
from tests.unit.nav.boat_truth import Voyage, config_of

GRAVITY_MPS2, LAT_DEG = 9.82, 63.4


class Judge:
    """Stands for the integrity monitor."""

    def __init__(self) -> None:
        self.distrusted: set[tuple[Sense, str]] = set()

    def raw(self, imu: Imu) -> None:
        pass

    def imu(self, imu: Imu) -> bool:
        return self.trusts(Sense.IMU, imu.source)

    def trusts(self, sense: Sense, source: str) -> bool:
        return (sense, source) not in self.distrusted


class Boat:
    def __init__(self, count: int) -> None:
        config, parameters = config_of(Voyage()), Parameters()
        gnss, row = config.sensors
        rows = (gnss, *(replace(row, name=f"imu{k}") for k in range(count)))
        self.judge: Any = Judge()
        self.corrections = corrections_of(rows, parameters)
        mounting = Mounting(replace(config, sensors=rows), parameters)
        self.source = InertialSource(rows, self.corrections, mounting, self.judge)

    def offer(self, t_s: float, number: int = 0) -> Imu | None:
        measured = self.source.corrected(Imu(t_s, f"imu{number}", 0.1, 0.0, -GRAVITY_MPS2, 0.0, 0.0, 0.02))
        felt, self.feels = self.source.felt(measured, LAT_DEG)
        return self.source.chosen(measured, felt)


def test_the_first_sensor_is_used_and_the_next_when_it_falls_silent() -> None:
    boat = Boat(2)
    assert boat.source.current is None
    assert boat.offer(0.0) is not None and boat.offer(0.003, 1) is None and boat.source.current == "imu0"
    taken = [boat.offer(0.01 * k, 1) for k in range(1, 200)]
    assert taken[-1] is not None and boat.source.current == "imu1"


def test_a_sensor_that_is_not_trusted_gives_way() -> None:
    boat = Boat(2)
    assert boat.offer(0.0) is not None
    boat.judge.distrusted.add((Sense.IMU, "imu0"))
    assert boat.offer(0.01) is None and boat.offer(0.013, 1) is not None


def test_forces_that_lie_are_left_out_and_taken_again() -> None:
    boat = Boat(1)
    assert boat.offer(0.0) is not None and boat.feels is None
    boat.judge.distrusted.add((Sense.ACCELEROMETER, "imu0"))
    felt = boat.offer(0.01)
    assert boat.feels is False and boat.source.lies("imu0")
    assert felt is not None and felt.x_mps2 == 0.0 and felt.yaw_rate_radps == 0.02
    boat.offer(0.02)
    assert boat.feels is None
    boat.judge.distrusted.clear()
    again = boat.offer(0.03)
    assert boat.feels is True and not boat.source.lies("imu0") and again is not None and again.x_mps2 == 0.1


def test_a_new_calibration_is_told_once() -> None:
    boat = Boat(1)
    boat.offer(0.0)
    assert not boat.source.recalibrated("imu0")
    boat.corrections["imu0"].version += 1
    assert boat.source.recalibrated("imu0") and not boat.source.recalibrated("imu0")


@pytest.mark.parametrize("count", [1, 3])
def test_later_samples_are_those_of_the_sensor_in_use_up_to_now(count: int) -> None:
    boat = Boat(count)
    for number in range(count):
        boat.offer(0.0, number)
    pending = [Imu(t, "imu0", 0.0, 0.0, -GRAVITY_MPS2, 0.0, 0.0, 0.0) for t in (0.01, 0.02, 0.03)]
    assert [imu.t_s for imu in boat.source.later(pending, 0.02)] == [0.01, 0.02]
