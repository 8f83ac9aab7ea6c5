"""How inertial sensors and magnetometers are turned in the boat: SENS_BOARD_ROT, SENS_BOARD_X_OFF…, CAL_MAGn_ROT.

This comes after what the vessel's file says: drivers give readings in the axes of the device as the file turns it.
"""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.vessel import NavigatedBoat
from companion.core.readings import Imu, MagneticField
from companion.nav.corrections import magnetometers
from companion.nav.lever_arms import Matrix, Vector, multiply, quaternion_of, rotate, rotation
from companion.params.devices import ROTATIONS_DEG
from companion.params.store import Parameters

_OFFSETS = ("SENS_BOARD_X_OFF", "SENS_BOARD_Y_OFF", "SENS_BOARD_Z_OFF")


class Mounting:
    """Readings in a device's axes → the boat's. Rotations are those at the start, offsets count at once. Remembers the
    rotations, and the matrix of the offsets in force."""

    def __init__(self, config: NavigatedBoat, parameters: Parameters) -> None:
        self._parameters = parameters
        self._board_deg = ROTATIONS_DEG[int(parameters["SENS_BOARD_ROT"])]
        self._unlevelled = _matrix(self._board_deg)
        sources = [row.name for row in magnetometers(config.sensors)]
        chosen = {source: int(parameters[f"CAL_MAG{n}_ROT"]) for n, source in enumerate(sources)}
        self._own = {
            source: _matrix(ROTATIONS_DEG[number]) for source, number in chosen.items() if number in ROTATIONS_DEG
        }
        self._turn: Matrix | None = None
        self._version = -1  # of the parameters that it was made of

    def turned(self, imu: Imu) -> Imu:
        """The sample in body axes. The device's own attitude in it stays as it is."""
        matrix = self._board()
        if matrix is None:
            return imu
        x, y, z = rotate(matrix, (imu.x_mps2, imu.y_mps2, imu.z_mps2))
        roll, pitch, yaw = rotate(matrix, (imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps))
        return replace(
            imu, x_mps2=x, y_mps2=y, z_mps2=z, roll_rate_radps=roll, pitch_rate_radps=pitch, yaw_rate_radps=yaw
        )

    def unlevelled(self, vector: Vector) -> Vector:
        """A vector of an inertial sensor in the boat's axes, but for the offsets."""
        return vector if self._unlevelled is None else rotate(self._unlevelled, vector)

    def field(self, field: MagneticField) -> MagneticField:
        """The field in the boat's axes."""
        matrix = self.compass(field.source)
        if matrix is None:
            return field
        x, y, z = rotate(matrix, (field.x, field.y, field.z))
        return replace(field, x=x, y=y, z=z)

    def compass(self, source: str) -> Matrix | None:
        """The rotation of the magnetic field that `source` measures; None for none."""
        return self._own[source] if source in self._own else self._board()

    def _board(self) -> Matrix | None:
        """The inertial sensors' rotation: offsets · SENS_BOARD_ROT; None where there is nothing to turn."""
        parameters = self._parameters
        if parameters.version != self._version:
            self._version = parameters.version
            offsets_deg = (parameters[_OFFSETS[0]], parameters[_OFFSETS[1]], parameters[_OFFSETS[2]])
            self._turn = _matrix(self._board_deg, offsets_deg)
        return self._turn


def _matrix(angles_deg: Vector, offsets_deg: Vector = (0.0, 0.0, 0.0)) -> Matrix | None:
    if not any(angles_deg) and not any(offsets_deg):
        return None
    turns = (quaternion_of(*map(math.radians, deg)) for deg in (offsets_deg, angles_deg))
    return rotation(multiply(*turns))
