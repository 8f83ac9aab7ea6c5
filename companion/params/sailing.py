"""Parameters of boats with a sail."""

from __future__ import annotations

from companion.params.spec import choice, real

NO_MOTOR, WITHOUT_WIND, BY_MOTOR_ALONE = 0, 1, 2  # of SAIL_MOTOR

_USES = {NO_MOTOR: "Never", WITHOUT_WIND: "Without wind", BY_MOTOR_ALONE: "Always, sheet free"}

ROWS = (
    real("SAIL_NO_GO_ANGLE", 45.0, 25.0, 80.0, "deg", "Sailing", "Closest to the true wind that the boat sails"),
    real(
        "SAIL_XTRACK",
        15.0,
        2.0,
        1000.0,
        "m",
        "Sailing",
        "Beating, the boat tacks where it is so far off the line between two waypoints",
    ),
    real("SAIL_HEEL_MAX", 35.0, 5.0, 60.0, "deg", "Sailing", "Heel beyond which the sheet is eased"),
    real("SAIL_WIND_MIN", 0.8, 0.0, 10.0, "m/s", "Sailing", "Wind below which the boat says that it cannot sail"),
    real(
        "SAIL_WIND_T",
        120.0,
        0.0,
        3600.0,
        "s",
        "Sailing",
        "How long the boat sails by the last wind after the wind vane has failed; then the sheet is free",
    ),
    real("SAIL_TACK_T", 12.0, 3.0, 120.0, "s", "Sailing", "Time for a tack; a boat that needs longer gybes instead"),
    choice("SAIL_MOTOR", WITHOUT_WIND, _USES, "Sailing", "When the motors beside the sail push"),
)
