"""Rows of the table of parameters: allocation, and supervision of the thrusters."""

from __future__ import annotations

from companion.params.spec import (
    YES_NO,
    ParamSpec,
    choice,
    integer,
    real,
)

ROWS: tuple[ParamSpec, ...] = (
    # allocation
    choice(
        "ALLOC_KIND",
        0,
        {0: "Constrained", 1: "Pseudo-inverse"},
        "Allocation",
        "Thrust allocation: optimal within limits and rates, or the pseudo-inverse cut to them",
    ),
    integer("ALLOC_ITER", 3, 1, 6, "", "Allocation", "Re-linearisations of the thrust allocation per cycle"),
    real("ALLOC_W_POWER", 1.0, 0.0, 100.0, "", "Allocation", "Weight of power in the thrust allocation"),
    real("ALLOC_W_TURN", 2.0, 0.0, 100.0, "", "Allocation", "Weight against turning the azimuths"),
    choice(
        "ALLOC_ECON",
        0,
        YES_NO,
        "Allocation",
        "Turn an azimuth thruster round where the mean demand of the last 20 s then needs a little less power",
    ),
    real(
        "JET_STEER_N",
        400.0,
        0.0,
        5000.0,
        "N",
        "Allocation",
        "Largest thrust that a water jet adds to steer: without thrust its nozzle has no effect",
    ),
    real("JET_MIN_THR", 0.05, 0.01, 0.5, "norm", "Allocation", "Lowest throttle at which a water jet's impeller turns"),
    real(
        "RUD_STEER",
        0.35,
        0.0,
        1.0,
        "norm",
        "Allocation",
        "Share of the thrust ahead that may be added to steer: without flow a rudder has no effect",
    ),
    # thrusters, commanded against measured
    choice(
        "THR_WATCH",
        1,
        YES_NO,
        "Thrusters",
        "Stop using a thruster whose feedback does not follow its command",
    ),
    choice("THR_LEARN_AZ", 1, YES_NO, "Thrusters", "Learn how fast azimuths turn, if slower than configured"),
    real("THR_TOL", 0.15, 0.02, 1.0, "norm", "Thrusters", "Tolerated difference of the measured throttle"),
    real("THR_TOL_AZ", 15.0, 2.0, 90.0, "deg", "Thrusters", "Tolerated difference of the measured azimuth"),
    real(
        "THR_TOL_CUR",
        1.8,
        1.1,
        10.0,
        "",
        "Thrusters",
        "Times the current for its throttle that a motor may draw before it counts as blocked or fouled",
    ),
    real("THR_LAG", 1.0, 0.1, 10.0, "s", "Thrusters", "Tolerated time constant of a propeller's lag"),
    real(
        "THR_FAIL_T",
        1.5,
        0.2,
        10.0,
        "s",
        "Thrusters",
        "How long a difference is tolerated before the thruster is no longer used",
    ),
    real(
        "THR_RETRY_T",
        60.0,
        0.0,
        3600.0,
        "s",
        "Thrusters",
        "When a thruster that is no longer used is tried again; 0: at the next arming",
    ),
)
