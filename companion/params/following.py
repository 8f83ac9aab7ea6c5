"""Rows of the table of parameters: following, Offboard, and the law of the RescueRunner thesis."""

from __future__ import annotations

from companion.params.spec import (
    ParamSpec,
    choice,
    integer,
    real,
)

ROWS: tuple[ParamSpec, ...] = (
    # following
    real(
        "FLW_TGT_DST",
        20.0,
        1.0,
        500.0,
        "m",
        "Follow",
        "Follow position: distance, astern along the track; a command overrides it until disarming or a change",
    ),
    real(
        "FLW_TGT_FA",
        180.0,
        -180.0,
        180.0,
        "deg",
        "Follow",
        "Follow position: bearing from the leader, 0 ahead, 90 starboard; a command overrides it likewise",
    ),
    real(
        "FLW_TGT_MAX_VEL",
        25.0,
        0.0,
        25.0,
        "m/s",
        "Follow",
        "Top speed in Follow; MPC_XY_VEL_MAX applies if it is lower",
    ),
    real(
        "FLW_TGT_HT",
        8.0,
        0.0,
        1000.0,
        "m",
        "Follow",
        "Height above the leader; accepted from clients, without effect on a boat",
    ),
    real(
        "FLW_TGT_RS",
        0.1,
        0.0,
        1.0,
        "norm",
        "Follow",
        "Follow responsiveness of aircraft; accepted from clients, without effect (see FOLL_*, PATH_*)",
    ),
    integer(
        "FLW_TGT_ALT_M",
        0,
        0,
        2,
        "",
        "Follow",
        "Follow altitude mode of aircraft; accepted from clients, without effect on a boat",
    ),
    integer(
        "FOLL_SYSID", 0, 0, 255, "", "Follow", "System id of the leader; 0: the first one heard, until it is silent"
    ),
    real("FOLL_MIN_DIST", 12.0, 0.5, 200.0, "m", "Follow", "Keep-out: smallest distance to the lead boat"),
    real(
        "FOLL_MARGIN",
        3.5,
        0.0,
        100.0,
        "m",
        "Follow",
        "Margin outside the keep-out circle, for errors of both positions",
    ),
    real(
        "FOLL_TTC",
        2.0,
        0.0,
        30.0,
        "s",
        "Follow",
        "Time to the keep-out circle below which the boat gets no thrust ahead, whatever its law asks for",
    ),
    real(
        "FOLL_GAP_BW",
        0.25,
        0.02,
        2.0,
        "1/s",
        "Follow",
        "Bandwidth of the gap loop: speed towards the follow position per distance from it",
    ),
    real("FOLL_CLOSE_V", 4.0, 0.1, 20.0, "m/s", "Follow", "Largest speed in excess of the leader's while closing up"),
    real(
        "FOLL_LOOK_T",
        2.0,
        0.3,
        20.0,
        "s",
        "Follow",
        "Look-ahead on the leader's track as time; applies where it is longer than PATH_LOOKAHEAD",
    ),
    real(
        "FOLL_LOSS_T",
        0.9,
        0.5,
        10.0,
        "s",
        "Follow",
        "Age of either boat's position at which Follow ends; three intervals of a slower source",
    ),
    choice(
        "FOLL_LOSS_ACT",
        1,
        {1: "Hold", 2: "RTL", 3: "Neutral", 4: "Manual"},
        "Follow",
        "Action when Follow loses the leader or a position; Manual leaves the boat to the sticks",
    ),
    real(
        "FOLL_BACK_T",
        3.0,
        0.5,
        60.0,
        "s",
        "Follow",
        "How long the data must be good before Follow resumes, unless another mode was chosen",
    ),
    real(
        "FOLL_WAIT_T",
        10.0,
        0.0,
        300.0,
        "s",
        "Follow",
        "How long Follow, chosen while armed, holds position and waits for a leader; 0: it is refused",
    ),
    choice(
        "FOLL_AUTH",
        1,
        {0: "Ground stations", 1: "Ground stations and lead boat"},
        "Follow",
        "Who chooses the mode, the newest choice counting; with 0 requests of the lead boat are ignored",
    ),
    real(
        "FOLL_LATENCY",
        0.1,
        0.0,
        2.0,
        "s",
        "Follow",
        "Assumed age of a leader's message on arrival where it cannot be measured (phone, ground station)",
    ),
    choice(
        "FOLL_REL",
        2,
        {0: "Positions", 1: "Difference of receivers", 2: "Moving base"},
        "Follow",
        "Best way that may place the leader relative to the boat; what it needs is used where it is there",
    ),
    real(
        "FOLL_COMMON",
        0.0,
        0.0,
        0.98,
        "norm",
        "Follow",
        "Share of the error variance that like receivers on both boats have in common; 0.9: one model, 0: not known",
    ),
    choice(
        "FOLL_LAW",
        0,
        {0: "Companion", 1: "Thesis"},
        "Follow",
        "Law of Follow: along the leader's track, or pursuit as in the RescueRunner thesis",
    ),
    # the RescueRunner thesis's law (FOLL_LAW 1): nozzle (1: full) per rad, throttle (1: full) per m/s, speed in m/s per
    # metre of distance
    *(
        real(f"FOLT_{term}{suffix}", default, 0.0, 20.0, unit, "Thesis law", f"{what} gain of {axis}")
        for suffix, axis, gains, unit in (
            ("", "the nozzle on the angle to the leader", (1.2, 0.0, 1.5), "1/rad"),
            ("_SPD", "the throttle on speed", (0.15, 0.5, 0.0), "s/m"),
            ("_DST", "the speed on distance", (0.15, 0.0, 0.0), "1/s"),
        )
        for term, what, default in zip(
            ("KP", "KI", "KD"), ("Proportional", "Integral", "Derivative"), gains, strict=True
        )
    ),
    real("FOLT_TF", 0.26, 0.0, 10.0, "s", "Thesis law", "Time constant that filters the derivatives"),
    # offboard
    real(
        "OFFB_TIMEOUT",
        0.8,
        0.2,
        60.0,
        "s",
        "Offboard",
        "Age at which the newest Offboard setpoint times out",
    ),
    choice(
        "OFFB_LOSS_ACT",
        1,
        {1: "Hold", 2: "RTL", 3: "Neutral"},
        "Offboard",
        "Action when setpoints stop in Offboard; with Neutral the boat goes on when they return",
    ),
)
