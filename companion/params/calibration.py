"""Rows of the table of parameters: what calibrations by a ground station found of magnetometers and gyros.

Magnetometers are numbered in the order of the vessel's file, those with `heading = "ahrs"`; so are the gyros of the
inertial sensors. The level is kept in SENS_BOARD_X_OFF and SENS_BOARD_Y_OFF (`devices.py`).
"""

from __future__ import annotations

from companion.params.devices import COMPASSES
from companion.params.spec import ParamSpec, real

SENSORS = COMPASSES  # of each kind
_GROUP = "Calibration"
_ANY = 1.0e6  # magnetometers have all kinds of units


def _magnetometer(n: int) -> tuple[ParamSpec, ...]:
    which = f"magnetometer {n}"
    return (
        *(
            real(
                f"CAL_MAG{n}_{axis}OFF",
                0.0,
                -_ANY,
                _ANY,
                "",
                _GROUP,
                f"Hard iron of {which}, {axis.lower()}",
                decimals=6,
            )
            for axis in "XYZ"
        ),
        *(
            real(
                f"CAL_MAG{n}_{axis}SCALE",
                0.0,
                0.0,
                _ANY,
                "",
                _GROUP,
                f"Soft iron of {which}, {axis.lower()} on the diagonal; all three 0: as the vessel's file says",
                decimals=6,
            )
            for axis in "XYZ"
        ),
        *(
            real(
                f"CAL_MAG{n}_{axis}ODIAG",
                0.0,
                -_ANY,
                _ANY,
                "",
                _GROUP,
                f"Soft iron of {which}, {pair} off the diagonal",
                decimals=6,
            )
            for axis, pair in zip("XYZ", ("xy", "xz", "yz"), strict=True)
        ),
        real(
            f"CAL_MAG{n}_WANDER",
            1.0,
            0.0,
            45.0,
            "deg",
            _GROUP,
            f"Slow heading error that the calibration of {which} left",
        ),
    )


def _gyro(n: int) -> tuple[ParamSpec, ...]:
    return tuple(
        real(
            f"CAL_GYRO{n}_{axis}OFF",
            0.0,
            -0.1,
            0.1,
            "rad/s",
            _GROUP,
            f"Bias of gyro {n}, {axis.lower()}",
            decimals=6,
        )
        for axis in "XYZ"
    )


ROWS: tuple[ParamSpec, ...] = (
    *(spec for n in range(SENSORS) for spec in _magnetometer(n)),
    *(spec for n in range(SENSORS) for spec in _gyro(n)),
)
