"""Rows of the table of parameters: names that ground stations look up, and that do nothing on a boat.

`tests/protocol/data/qgroundcontrol_parameters.toml` says which of QGroundControl's PX4 pages looks up which name.
"""

from __future__ import annotations

from companion.params.spec import ParamSpec, fixed, real

FIRST_MOTOR = 101  # PX4's number of the output function "Motor 1"
MOTORS = 12  # as many as PX4 has

_AFLOAT = "A boat stays on the water"

ROWS: tuple[ParamSpec, ...] = (
    # Airframe
    fixed("SYS_AUTOSTART", 50000, "Airframe: the vessel file describes the boat"),
    fixed("SYS_AUTOCONFIG", 0, "Airframe: nothing to reset"),
    # Sensors
    fixed("CAL_GYRO0_ID", 1, "Gyro present"),
    fixed("CAL_ACC0_ID", 1, "Accelerometer present"),
    fixed("CAL_MAG0_ID", 1, "Heading source present"),
    fixed("CAL_MAG1_ID", 0, "No second magnetometer"),
    fixed("CAL_MAG2_ID", 0, "No third magnetometer"),
    fixed("SYS_HAS_MAG", 0, "Whether there is a magnetometer to calibrate: 1 where the vessel's file has one"),
    fixed("CAL_MAG_SIDES", 32, "A boat's compass is calibrated upright"),
    *(
        fixed(f"ACT_FUNC{n}", number, f"Motor {n} is thruster {n} of the vessel's file", f"Motor {n}")
        for n, number in enumerate(range(FIRST_MOTOR, FIRST_MOTOR + MOTORS), start=1)
    ),
    fixed("SENS_DPRES_OFF", 0.0, "No airspeed sensor", whole=False),
    # Radio and Flight Modes
    fixed(
        "COM_RC_IN_MODE",
        1,
        "No transmitter is required; one that is heard counts all the same",
        "No transmitter required",
    ),
    fixed("RC_MAP_FLAPS", 0, "A boat has no flaps", "None"),
    fixed("RC_MAP_AUX1", 0, "Servos are moved by DO_SET_SERVO, not by the transmitter", "None"),
    fixed("RC_MAP_AUX2", 0, "Servos are moved by DO_SET_SERVO, not by the transmitter", "None"),
    *(fixed(f"RC_MAP_PARAM{n}", 0, "No parameter is set by a knob of the transmitter", "None") for n in (1, 2, 3)),
    fixed("RC_MAP_GEAR_SW", 0, "A boat has no landing gear; MAN_RC_LOWER_CH lowers thrusters", "None"),
    fixed("RC_GEAR_TH", 0.75, "A boat has no landing gear", whole=False),
    *(
        fixed(f"RC_MAP_{name}_SW", 0, "Modes are chosen by one channel: RC_MAP_FLTMODE", "None")
        for name in ("MODE", "ACRO", "POSCTL", "RATT", "STAB")
    ),
    # Power
    fixed("BAT1_V_LOAD_DROP", 0.0, "The vessel file's resistance_ohm corrects for load", whole=False),
    # Safety
    fixed("BAT_EMERGEN_THR", 0.0, "Not used: BAT_CRIT_THR is the last level", whole=False),
    fixed("COM_OBS_AVOID", 0, "No other computer plans ways round obstacles", "Off"),
    fixed("GF_MAX_VER_DIST", 0.0, _AFLOAT, whole=False),
    fixed("RTL_RETURN_ALT", 0.0, _AFLOAT, whole=False),
    fixed("RTL_DESCEND_ALT", 0.0, _AFLOAT, whole=False),
    fixed("RTL_LAND_DELAY", -1.0, "RTL ends in Hold", whole=False),
    fixed("SDLOG_MODE", 0, "Logs are always written", "Always"),
    # Other ground stations
    fixed("FRAME_CLASS", 2, "A boat, to ArduPilot's ground stations"),
    fixed("ARMING_SKIPCHK", 0, "No arming check is skipped; without the name MAVProxy says that they are disabled"),
    real(
        "MIS_TAKEOFF_ALT",
        2.5,
        0.0,
        1000.0,
        "m",
        "Compatibility",
        "Take-off altitude, which MAVSDK reads and sets; without effect on a boat",
    ),
)
