"""Rows of the table of parameters: names that QGroundControl's PX4 pages look up."""

from __future__ import annotations

from companion.params.spec import ParamSpec, fixed

ROWS: tuple[ParamSpec, ...] = (
    fixed("SYS_AUTOSTART", 50000, "Airframe"),
    fixed("SYS_AUTOCONFIG", 0, "Airframe reset"),
    fixed("CAL_GYRO0_ID", 1, "Gyro present"),
    fixed("CAL_ACC0_ID", 1, "Accelerometer present"),
    fixed("CAL_MAG0_ID", 1, "Heading source present"),
    fixed("CAL_MAG1_ID", 0, "No second magnetometer"),
    fixed("CAL_MAG2_ID", 0, "No third magnetometer"),
    fixed("SYS_HAS_MAG", 0, "No magnetometer to calibrate"),
    fixed("COM_RC_IN_MODE", 1, "Joystick only: no transmitter to calibrate"),
    *(fixed(f"COM_FLTMODE{n}", -1, "No mode switch") for n in range(1, 7)),
    *(
        fixed(f"RC_MAP_{n}", 0, "No transmitter map")
        for n in ("ROLL", "PITCH", "YAW", "THROTTLE", "FLAPS", "AUX1", "AUX2", "FLTMODE")
    ),
    fixed("RTL_RETURN_ALT", 0, "A boat stays on the water"),
    fixed("RTL_DESCEND_ALT", 0, "A boat stays on the water"),
    fixed("RTL_LAND_DELAY", -1, "RTL ends in Hold"),
    fixed("COM_DISARM_LAND", -1, "No disarming by itself"),
    fixed("BAT_EMERGEN_THR", 0, "Not used"),
    fixed("GF_MAX_VER_DIST", 0, "A boat stays on the water"),
    fixed("SDLOG_MODE", 0, "Logs are always written"),
)
