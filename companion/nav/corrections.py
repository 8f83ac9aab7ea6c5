"""What calibrations found of a sensor, applied to its readings in its own axes: hard and soft iron, gyro bias.

The values are parameters (`companion/params/calibration.py`), which a calibration aboard writes; where a magnetometer
has none, the vessel's file counts. How the device is turned in the boat comes after this (`mounting.py`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from companion.config.devices import SensorConfig
from companion.config.sensors import is_inertial
from companion.core.readings import Imu, MagneticField
from companion.nav.lever_arms import ZERO, Matrix, Vector, relative, rotate
from companion.params.calibration import SENSORS
from companion.params.store import Parameters

_BOARD = "SENS_BOARD_"


def magnetometers(sensors: Sequence[SensorConfig]) -> tuple[SensorConfig, ...]:
    """The magnetometers that a calibration aboard can be kept of, in the order of their numbers."""
    return tuple(row for row in sensors if row.heading == "ahrs")[:SENSORS]


def inertial_sensors(sensors: Sequence[SensorConfig]) -> tuple[SensorConfig, ...]:
    """The inertial sensors that a calibration aboard can be kept of, in the order of their numbers."""
    return tuple(row for row in sensors if is_inertial(row))[:SENSORS]


class SensorCorrections:
    """Of one device: `imu` and `field` give its readings corrected.

    `version` grows when a parameter of it, or of its mounting, changes. Remembers the values in force.
    """

    def __init__(self, row: SensorConfig, parameters: Parameters, inertial: int | None, magnetic: int | None) -> None:
        """`inertial`, `magnetic`: its numbers in the parameters; None: it has none."""
        self.version = 0
        self._row = row
        self._parameters = parameters
        self._inertial, self._magnetic = inertial, magnetic
        self._prefixes = tuple(
            f"CAL_{kind}{number}_" for kind, number in (("GYRO", inertial), ("MAG", magnetic)) if number is not None
        )
        self._bias: Vector = ZERO
        self._read()
        parameters.on_change(self._parameter_changed)

    def imu(self, imu: Imu) -> Imu:
        """The sample without its gyro bias."""
        if self._bias == ZERO:
            return imu
        p, q, r = relative((imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps), self._bias)
        return replace(imu, roll_rate_radps=p, pitch_rate_radps=q, yaw_rate_radps=r)

    def field(self, field: MagneticField) -> Vector:
        """The field, mag_matrix · (measured − mag_offset)."""
        return rotate(self._matrix, relative((field.x, field.y, field.z), self._offset))

    def _parameter_changed(self, name: str, value: float) -> None:
        if name.startswith((*self._prefixes, _BOARD)):
            self._read()
            self.version += 1

    def _read(self) -> None:
        value = self._parameters
        row = self._row
        self._matrix: Matrix = (*row.mag_matrix[0], *row.mag_matrix[1], *row.mag_matrix[2])
        self._offset: Vector = row.mag_offset
        self.wander_rad = row.heading_wander_rad
        self.calibrated_aboard = False
        if self._magnetic is not None:
            self._read_magnetometer(f"CAL_MAG{self._magnetic}_")
        if self._inertial is not None:
            gyro = f"CAL_GYRO{self._inertial}_"
            self._bias = (value[f"{gyro}XOFF"], value[f"{gyro}YOFF"], value[f"{gyro}ZOFF"])

    def _read_magnetometer(self, prefix: str) -> None:
        value = self._parameters
        a, d, f = (value[f"{prefix}{axis}SCALE"] for axis in "XYZ")
        if a <= 0.0 or d <= 0.0 or f <= 0.0:
            return
        b, c, e = (value[f"{prefix}{axis}ODIAG"] for axis in "XYZ")
        self._matrix = (a, b, c, b, d, e, c, e, f)
        self._offset = (value[f"{prefix}XOFF"], value[f"{prefix}YOFF"], value[f"{prefix}ZOFF"])
        self.wander_rad = math.radians(value[f"{prefix}WANDER"])
        self.calibrated_aboard = True


def corrections_of(sensors: Sequence[SensorConfig], parameters: Parameters) -> Mapping[str, SensorCorrections]:
    """The corrections of every sensor that has some, by its name."""
    inertial = {row.name: number for number, row in enumerate(inertial_sensors(sensors))}
    magnetic = {row.name: number for number, row in enumerate(magnetometers(sensors))}
    return {
        row.name: SensorCorrections(row, parameters, inertial.get(row.name), magnetic.get(row.name))
        for row in sensors
        if row.name in inertial or row.heading == "ahrs"
    }
