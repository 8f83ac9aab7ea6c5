"""Rows of the table of parameters: how inertial sensors and compasses are mounted, and where the battery is measured.

Names and numbers are PX4's, so that QGroundControl's pages Sensors and Power set them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from companion.params.spec import ParamSpec, choice, integer, real

COMPASSES = 3
WITH_THE_BOARD = -1
NO_BATTERY, ANY_DEVICE = -1, 0
_DEVICES = 4

ROTATIONS_DEG: Mapping[int, tuple[int, int, int]] = {
    0: (0, 0, 0), 1: (0, 0, 45), 2: (0, 0, 90), 3: (0, 0, 135), 4: (0, 0, 180), 5: (0, 0, 225), 6: (0, 0, 270),
    7: (0, 0, 315), 8: (180, 0, 0), 9: (180, 0, 45), 10: (180, 0, 90), 11: (180, 0, 135), 12: (0, 180, 0),
    13: (180, 0, 225), 14: (180, 0, 270), 15: (180, 0, 315), 16: (90, 0, 0), 17: (90, 0, 45), 18: (90, 0, 90),
    19: (90, 0, 135), 20: (270, 0, 0), 21: (270, 0, 45), 22: (270, 0, 90), 23: (270, 0, 135), 24: (0, 90, 0),
    25: (0, 270, 0), 26: (0, 180, 90), 27: (0, 180, 270), 28: (90, 90, 0), 29: (180, 90, 0), 30: (270, 90, 0),
    31: (90, 180, 0), 32: (270, 180, 0), 33: (90, 270, 0), 34: (180, 270, 0), 35: (270, 270, 0), 36: (90, 180, 90),
    37: (90, 0, 270), 38: (90, 68, 293), 39: (0, 315, 0), 40: (90, 315, 0),
}  # fmt: skip
"""Roll, pitch and yaw of a device in the boat, by MAVLink's MAV_SENSOR_ORIENTATION."""


def _name(angles_deg: tuple[int, int, int]) -> str:
    parts = (f"{axis} {angle}°" for axis, angle in zip(("roll", "pitch", "yaw"), angles_deg, strict=True) if angle)
    return ", ".join(parts).capitalize() or "Ahead"


_ROTATIONS = {number: _name(angles_deg) for number, angles_deg in ROTATIONS_DEG.items()}


def _mounting() -> Iterator[ParamSpec]:
    text = "How the inertial sensors are turned in the boat, beside what the vessel file says"
    yield choice("SENS_BOARD_ROT", 0, _ROTATIONS, "Mounting", text, reboot=True)
    for axis, turn in (("X", "roll"), ("Y", "pitch"), ("Z", "yaw")):
        text = f"Small {turn} of the inertial sensors in the boat, added to SENS_BOARD_ROT"
        yield real(f"SENS_BOARD_{axis}_OFF", 0.0, -45.0, 45.0, "deg", "Mounting", text)
    for n in range(COMPASSES):
        text = (
            f"How magnetometer {n} is turned in the boat, counted as in the vessel file among those with heading ahrs"
        )
        names = {WITH_THE_BOARD: "As the inertial sensors"} | _ROTATIONS
        yield choice(f"CAL_MAG{n}_ROT", WITH_THE_BOARD, names, "Mounting", text, reboot=True)


ROWS: tuple[ParamSpec, ...] = (
    *_mounting(),
    choice(
        "BAT1_SOURCE",
        ANY_DEVICE,
        {NO_BATTERY: "None", ANY_DEVICE: "Any device"} | {n: f"Bridge {n}" for n in range(1, _DEVICES + 1)},
        "Battery",
        "Device whose measurement of the battery counts; bridges count as in the vessel file",
    ),
    integer(
        "BAT1_N_CELLS",
        0,
        0,
        100,
        "",
        "Battery",
        "Cells in series, to judge the charge by voltage if neither device nor vessel file gives it; 0: off",
    ),
    real("BAT1_V_EMPTY", 3.6, 0.5, 5.0, "V", "Battery", "Voltage of an empty cell under load"),
    real("BAT1_V_CHARGED", 4.05, 0.5, 5.0, "V", "Battery", "Voltage of a full cell under load"),
)
