"""The one table of parameters, and the store that holds their values.

Everything that can be tuned under way stands here once: name, default, unit, range, group and text feed MAVLink, the state file,
ground-station metadata and the documentation. A vessel's TOML overrides defaults in its `[parameters]` table; what an operator sets
goes over that and is kept in the state file (`companion/record/state_file.py`). Blocks hold the `Parameters` object and read
`parameters["NAME"]` each time, so that every change takes effect at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any


class ParamType(Enum):
    REAL32 = "Float"
    INT32 = "Int32"


@dataclass(frozen=True, slots=True)
class ParamSpec:
    """One parameter. `choices` names the values of an enumeration."""

    name: str
    default: float
    minimum: float
    maximum: float
    unit: str
    group: str
    text: str
    type: ParamType = ParamType.REAL32
    decimals: int = 2
    reboot: bool = False
    read_only: bool = False
    choices: Mapping[int, str] = field(default_factory=dict)


class ParamRefusal(Enum):
    """Why a value was not taken; the names are those of MAVLink's MAV_PARAM_ERROR."""

    DOES_NOT_EXIST = 1
    VALUE_OUT_OF_RANGE = 2
    READ_ONLY = 5


def _real(name: str, default: float, minimum: float, maximum: float, unit: str, group: str, text: str, **more: Any) -> ParamSpec:
    return ParamSpec(name, default, minimum, maximum, unit, group, text, **more)


def _int(name: str, default: int, minimum: int, maximum: int, unit: str, group: str, text: str, **more: Any) -> ParamSpec:
    return ParamSpec(name, default, minimum, maximum, unit, group, text, ParamType.INT32, 0, **more)


def _choice(name: str, default: int, choices: Mapping[int, str], group: str, text: str, **more: Any) -> ParamSpec:
    return _int(name, default, min(choices), max(choices), "", group, text, choices=choices, **more)


def _fixed(name: str, value: int, text: str) -> ParamSpec:
    """A name that QGroundControl's PX4 pages look up; served so that they do not complain, and read-only."""
    return _int(name, value, value, value, "", "Compatibility", text, read_only=True)


FAILSAFE_ACTIONS = {0: "Ignore", 1: "Hold", 2: "RTL", 3: "Neutral"}
FEEDFORWARD_KINDS = {0: "Off", 1: "Thesis, as printed", 2: "Thesis, scaled at sea", 3: "Full"}
_YES_NO = {0: "No", 1: "Yes"}
_DEGREES_PER_S = "deg/s"

TABLE: tuple[ParamSpec, ...] = (
    # identity
    _int("MAV_SYS_ID", 1, 1, 250, "", "MAVLink", "System id of this vessel", reboot=True),
    # failsafes
    _choice("NAV_DLL_ACT", 1, FAILSAFE_ACTIONS, "Failsafe", "What to do when no ground station has been heard for COM_DL_LOSS_T, armed and in a mode steered by itself"),
    _real("COM_DL_LOSS_T", 10.0, 1.0, 300.0, "s", "Failsafe", "Silence of all ground stations that counts as loss"),
    _choice("NAV_RCL_ACT", 1, FAILSAFE_ACTIONS, "Failsafe", "What to do when the sticks fall silent in a mode steered by sticks"),
    _real("COM_RC_LOSS_T", 0.5, 0.2, 10.0, "s", "Failsafe", "Silence of the sticks that counts as loss; until then the last stick stands, then comes NAV_RCL_ACT"),
    _choice("FS_POS_ACT", 3, FAILSAFE_ACTIONS, "Failsafe", "What to do when the position is lost in a mode that needs it (Hold and RTL need it too: they become Neutral)"),
    _real("FS_POS_T", 5.0, 0.5, 60.0, "s", "Failsafe", "How long dead reckoning may go on before the position counts as lost"),
    _choice("COM_LOW_BAT_ACT", 2, FAILSAFE_ACTIONS, "Failsafe", "What to do when the battery is below BAT_CRIT_THR"),
    _real("BAT_LOW_THR", 0.25, 0.05, 0.9, "norm", "Failsafe", "Battery share left at which to warn", decimals=2),
    _real("BAT_CRIT_THR", 0.12, 0.02, 0.8, "norm", "Failsafe", "Battery share left at which to act"),
    _choice("FS_LEAK_ACT", 2, FAILSAFE_ACTIONS, "Failsafe", "What to do when the leak sensor is wet"),
    _choice("FS_ACT_ACT", 3, FAILSAFE_ACTIONS, "Failsafe", "What to do when a thruster bridge stops answering, or thrusters fail so that the boat cannot go ahead or steer"),
    # arming and home
    _choice("ARM_CHECKS", 1, _YES_NO, "Arming", "Refuse to arm while a check fails"),
    _choice("ARM_NEED_POS", 1, _YES_NO, "Arming", "A valid position and heading are needed to arm, also in manual modes"),
    _choice("HOME_ON_ARM", 0, _YES_NO, "Arming", "Move home to where the boat is each time it is armed"),
    # navigation
    _choice("NAV_WILD_RULE", 0, {0: "Gate by covariance", 1: "Thesis: 1 m, 20 in a row"}, "Navigation", "How wild positions are told from true ones"),
    _real("COM_POS_FS_EPH", 10.0, 0.1, 100.0, "m", "Navigation", "Position accuracy (one sigma) beyond which the position counts as lost"),
    _choice("AHRS_LAW", 0, {0: "Companion", 1: "Thesis"}, "Navigation", "Filter that makes a heading of a raw magnetometer: the companion's own, or that of the RescueRunner thesis, which takes turns for tilt"),
    _real("AHRS_COURSE_T", 50.0, 0.0, 1000.0, "s", "Navigation", "Time constant with which that heading is drawn to the course over ground, after 10 s above 5 m/s; 0: never. 50 s is the thesis's gain of 1e-4 at 200 Hz"),
    _real("AHRS_DRIFT", 0.5, 0.0, 5.0, "m/s", "Navigation", "Speed sideways by wind and current that explains a difference of course and heading: so much is not corrected"),
    # manual
    _choice("MAN_AXIS_SURGE", 0, {0: "x (stick forward)", 1: "z (throttle)"}, "Manual", "Axis of MANUAL_CONTROL that gives surge"),
    _int("MAN_GCS_SYSID", 0, 0, 255, "", "Manual", "System id whose sticks are obeyed; 0: the first heard, until it is silent"),
    _real("MAN_DEADBAND", 0.05, 0.0, 0.5, "norm", "Manual", "Stick share around the centre that counts as centred"),
    _real("MAN_YAW_RATE", 20.0, 1.0, 90.0, _DEGREES_PER_S, "Manual", "Turn of the heading setpoint at full stick in Heading and Hold"),
    _choice("MAN_RC_SAFE_CH", 5, {0: "None", 5: "5", 6: "6", 7: "7", 8: "8"}, "Manual", "Transmitter channel whose high position always forces Manual"),
    _choice("MAN_RC_LOWER_CH", 0, {0: "None", 5: "5", 6: "6", 7: "7", 8: "8"}, "Manual", "Transmitter channel whose switch, when moved in Manual, lowers (high) and retracts (low) the retractable thrusters"),
    # dynamic positioning
    _real("DP_BW_SURGE", 0.35, 0.05, 2.0, "rad/s", "Dynamic positioning", "Bandwidth of the surge loop; higher holds tighter and works the thrusters more"),
    _real("DP_BW_SWAY", 0.35, 0.05, 2.0, "rad/s", "Dynamic positioning", "Bandwidth of the sway loop"),
    _real("DP_BW_YAW", 0.45, 0.05, 3.0, "rad/s", "Dynamic positioning", "Bandwidth of the yaw loop"),
    _real("DP_DAMPING", 0.9, 0.3, 2.0, "", "Dynamic positioning", "Relative damping of the three loops"),
    _real("DP_INTEGRAL", 0.12, 0.0, 0.5, "", "Dynamic positioning", "Integral action as a share of the bandwidth; 0 switches it off"),
    _real("DP_FEEDFORWARD", 1.0, 0.0, 1.5, "", "Dynamic positioning", "Share of the model feed-forward that is used"),
    _real("DP_SMOOTH_T", 0.5, 0.0, 2.0, "s", "Dynamic positioning", "Time constant that smooths the feedback: quieter thrusters, at the cost of damping"),
    _real("DP_SPEED_AHEAD", 0.5, 0.05, 10.0, "m/s", "Dynamic positioning", "Largest speed ahead of the reference"),
    _real("DP_SPEED_ASTERN", 0.2, 0.05, 10.0, "m/s", "Dynamic positioning", "Largest speed astern of the reference"),
    _real("DP_SPEED_SWAY", 0.1, 0.02, 5.0, "m/s", "Dynamic positioning", "Largest sideways speed of the reference"),
    _real("DP_YAW_RATE", 3.0, 0.5, 60.0, _DEGREES_PER_S, "Dynamic positioning", "Largest yaw rate of the reference"),
    _real("DP_ACC_SURGE", 0.1, 0.01, 3.0, "m/s^2", "Dynamic positioning", "Largest surge acceleration of the reference"),
    _real("DP_ACC_SWAY", 0.04, 0.01, 3.0, "m/s^2", "Dynamic positioning", "Largest sway acceleration of the reference"),
    _real("DP_ACC_YAW", 1.5, 0.1, 60.0, "deg/s^2", "Dynamic positioning", "Largest yaw acceleration of the reference"),
    _real("DP_TRANSIT_DIST", 6.0, 0.0, 200.0, "m", "Dynamic positioning", "Go-to points further off than this are sailed to bow first; nearer ones are taken in any direction"),
    _choice("DP_LAW", 0, {0: "Companion", 1: "Thesis"}, "Dynamic positioning", "Reference generator and control law: the companion's own, or those of the ReVolt thesis as printed, without anti-windup"),
    _choice("DP_FF_KIND", 3, FEEDFORWARD_KINDS, "Dynamic positioning", "Model feed-forward; the thesis's two need the vessel's [thesis_model], and are nothing without"),
    _real("DP_WATCH_R", 3.0, 0.2, 100.0, "m", "Dynamic positioning", "Watch circle around a held point; outside it the boat warns"),
    _real("DP_ALARM_R", 6.0, 0.2, 200.0, "m", "Dynamic positioning", "Circle around a held point outside which the boat raises the alarm"),
    _choice("DP_CONSEQ", 1, _YES_NO, "Dynamic positioning", "Say while holding whether the boat would still hold if one thruster failed"),
    _real("DP_NUDGE_MAX", 3.0, 0.1, 20.0, "m", "Dynamic positioning", "Longest way of one nudge"),
    _real("DP_NUDGE_YAW", 45.0, 1.0, 180.0, "deg", "Dynamic positioning", "Largest turn of one nudge"),
    # docking
    _real("DOCK_SPEED", 0.05, 0.01, 0.5, "m/s", "Docking", "Speed at which the boat comes alongside"),
    _real("DOCK_PUSH_N", 5.0, 0.0, 500.0, "N", "Docking", "Force that holds the boat against the berth, over what wind and current take"),
    _real("DOCK_TOL", 0.1, 0.02, 2.0, "m", "Docking", "Distance from the standoff point within which the approach may begin"),
    _real("DOCK_TOL_YAW", 2.0, 0.2, 20.0, "deg", "Docking", "Heading error within which the approach may begin"),
    _real("DOCK_ALIGN_T", 3.0, 0.0, 60.0, "s", "Docking", "How long the boat must stand within the tolerances before it comes alongside"),
    _real("DOCK_POS_ACC", 0.2, 0.02, 5.0, "m", "Docking", "Docking is given up while the position is known no better than this"),
    _real("DOCK_OFF_MAX", 0.3, 0.05, 5.0, "m", "Docking", "Docking is given up further off the line of approach than this"),
    _real("DOCK_YAW_MAX", 8.0, 1.0, 45.0, "deg", "Docking", "Docking is given up at a heading error above this"),
    _real("DOCK_WAVE_MAX", 0.12, 0.02, 1.0, "m/s", "Docking", "Docking is given up while lining up when waves move the boat by more than this (rms)"),
    _real("DOCK_TIMEOUT", 120.0, 10.0, 1800.0, "s", "Docking", "Docking is given up when lining up or coming alongside takes longer"),
    # the thesis's law (DP_LAW 1), as tuned at sea
    *(
        _real(f"DPT_K{term}_{axis}", default, 0.0, 1000.0, "", "Thesis law", f"{what} gain of {axis.lower()}, {unit}")
        for term, what, gains in (("P", "Proportional", (25.0, 25.0, 30.0)), ("I", "Integral", (0.3, 0.3, 0.3)), ("D", "Derivative", (75.0, 75.0, 50.0)))
        for axis, default, unit in zip(("SURGE", "SWAY", "YAW"), gains, ("N per m", "N per m", "Nm per rad"), strict=True)
    ),
    _real("DPT_LEAD_AHEAD", 1.5, 0.01, 50.0, "m", "Thesis law", "How far the reference is led ahead; its steady speed is a fifth of that a second"),
    _real("DPT_LEAD_ASTERN", 1.0, 0.01, 50.0, "m", "Thesis law", "How far the reference is led astern"),
    _real("DPT_LEAD_STBD", 0.6, 0.01, 50.0, "m", "Thesis law", "How far the reference is led to starboard"),
    _real("DPT_LEAD_PORT", 0.5, 0.01, 50.0, "m", "Thesis law", "How far the reference is led to port"),
    _real("DPT_LEAD_YAW", 35.0, 1.0, 180.0, "deg", "Thesis law", "How far the reference's heading is led"),
    # path
    _choice("PATH_KIND", 1, {0: "Linear", 1: "PCHIP", 2: "Modified Akima", 3: "Cubic spline"}, "Path", "Curve laid through the waypoints"),
    _choice("PATH_SURVEY", 1, _YES_NO, "Path", "Legs on which the mission has the camera shoot are straight lines, whatever the curve"),
    _real("PATH_LOOKAHEAD", 3.0, 0.5, 100.0, "m", "Path", "Shortest look-ahead distance"),
    _real("PATH_LOOK_TIME", 2.5, 0.5, 20.0, "s", "Path", "Look-ahead as a time at the present speed, where that is longer"),
    _real("PATH_INTEGRAL", 0.25, 0.0, 2.0, "", "Path", "Integral gain of the line of sight, against current and wind"),
    _real("PATH_ACC_LAT", 0.1, 0.01, 5.0, "m/s^2", "Path", "Largest sideways acceleration in a bend; lowers the speed ahead of tight curves"),
    _real("PATH_YAW_RATE", 12.0, 1.0, 90.0, _DEGREES_PER_S, "Path", "Largest yaw rate in a bend"),
    _real("PATH_ACC", 0.08, 0.01, 5.0, "m/s^2", "Path", "Acceleration and braking along the path"),
    _choice("PATH_CTRL", 0, {0: "PID", 1: "LQR"}, "Path", "What holds speed and heading under way: the loops of the law in WP_LAW, or a linear-quadratic regulator"),
    _real("PATH_BW_SURGE", 0.4, 0.05, 3.0, "rad/s", "Path", "Bandwidth of the speed loop"),
    _real("PATH_BW_YAW", 0.8, 0.05, 5.0, "rad/s", "Path", "Bandwidth of the heading loop under way; lower where a jet's nozzle cannot follow"),
    _real("NAV_ACC_RAD", 1.5, 0.2, 100.0, "m", "Path", "Acceptance radius of a waypoint that does not bring its own"),
    _choice("WP_LAW", 0, {0: "Companion", 1: "Thesis"}, "Path", "How waypoints are sailed: along the path, or by bearings to intermediate waypoints as in the ÅBOAT thesis (WPT_*)"),
    _real("WP_SPEED", 0.6, 0.05, 20.0, "m/s", "Path", "Speed on missions, until the mission changes it"),
    _real("MPC_XY_VEL_MAX", 1.0, 0.1, 25.0, "m/s", "Path", "Top speed in any mode steered by itself"),
    _choice("WP_YAW_MODE", 0, {0: "At the waypoint", 1: "Along the whole leg"}, "Path", "Where a waypoint's heading is held; along the leg the boat moves by dynamic positioning"),
    # the ÅBOAT thesis's law (WP_LAW 1)
    _real("WPT_DENSITY", 5.0, 0.5, 100.0, "", "Thesis law", "Intermediate waypoints a 100 m"),
    _real("WPT_RADIUS", 5.0, 0.2, 100.0, "m", "Thesis law", "Radius inside which a waypoint counts as reached, where it does not bring its own"),
    _real("WPT_KP_SURGE", 200.0, 0.0, 5000.0, "", "Thesis law", "Proportional gain of speed, N per m/s"),
    _real("WPT_KI_SURGE", 40.0, 0.0, 5000.0, "", "Thesis law", "Integral gain of speed, N per m"),
    _real("WPT_KD_SURGE", 0.0, 0.0, 5000.0, "", "Thesis law", "Derivative gain of speed, N per m/s^2"),
    _real("WPT_KP_YAW", 350.0, 0.0, 5000.0, "", "Thesis law", "Proportional gain of heading, Nm per rad"),
    _real("WPT_KI_YAW", 40.0, 0.0, 5000.0, "", "Thesis law", "Integral gain of heading, Nm per rad s"),
    _real("WPT_KD_YAW", 430.0, 0.0, 5000.0, "", "Thesis law", "Derivative gain of heading, Nm per rad/s"),
    # linear-quadratic regulator (PATH_CTRL 1)
    _real("LQR_ERR_SPEED", 0.1, 0.01, 5.0, "m/s", "Path", "Error of speed worth LQR_EFFORT of the surge limit"),
    _real("LQR_ERR_YAW", 10.0, 0.5, 90.0, "deg", "Path", "Error of heading worth LQR_EFFORT of the yaw limit"),
    _real("LQR_ERR_RATE", 15.0, 0.5, 90.0, _DEGREES_PER_S, "Path", "Error of yaw rate worth LQR_EFFORT of the yaw limit"),
    _real("LQR_INT_T", 8.0, 0.5, 120.0, "s", "Path", "For how long such an error may last before it weighs as much by its integral"),
    _real("LQR_EFFORT", 0.15, 0.01, 1.0, "norm", "Path", "Share of the limits that is worth the errors above"),
    _choice("WP_STUCK_ACT", 1, {0: "Ignore", 1: "Hold", 2: "RTL"}, "Path", "What to do when the boat under way has made no way for WP_STUCK_T; it says so sooner"),
    _real("WP_STUCK_T", 120.0, 40.0, 3600.0, "s", "Path", "How long no way made is borne before WP_STUCK_ACT"),
    # mission
    _choice("MIS_ON_START", 0, {0: "Stay in Hold, disarmed", 1: "Resume"}, "Mission", "After a restart in mid-mission"),
    _choice("MIS_DONE_ACT", 1, {1: "Hold", 2: "RTL", 3: "Neutral"}, "Mission", "What to do after the last item"),
    _choice("RTL_USE_RALLY", 1, _YES_NO, "Mission", "RTL goes to the nearest of home and the rally points"),
    _choice("GF_ACTION", 2, {0: "Fence off", 1: "Warn", 2: "Hold", 3: "RTL"}, "Fence", "What to do when the boat leaves the fence or, steered by stick, is about to; but for 0, modes that steer by themselves are kept inside"),
    _choice("FENCE_GROUP0", 0, {0: "Inside all", 1: "Inside any"}, "Fence", "How inclusion zones of group 0 (all that QGroundControl draws) count together"),
    _real("FENCE_MARGIN", 0.5, 0.0, 50.0, "m", "Fence", "What missions, go-to points and ways home keep between the hull (half its length around the middle) and the fence"),
    # traffic
    _choice("CA_ACTION", 0, {0: "Off", 1: "Warn", 2: "Slow or stop", 3: "Alter course"}, "Traffic", "What to do about vessels (AIS) that would come nearer than CA_DIST; only under way in Mission, RTL and Hold's go-to more than to warn. No substitute for a lookout"),
    _real("CA_DIST", 10.0, 1.0, 2000.0, "m", "Traffic", "Clear water to keep between the hulls, each taken as the circle around it"),
    _real("CA_TIME", 120.0, 20.0, 900.0, "s", "Traffic", "How far ahead to look for vessels to keep clear of"),
    _real("CA_STAND_T", 45.0, 10.0, 600.0, "s", "Traffic", "Where the other vessel has to give way: how long before it would be too near this one acts after all"),
    # following
    _real("FLW_TGT_DST", 20.0, 1.0, 500.0, "m", "Follow", "Station: distance from the lead boat, astern along its track. A station that was commanded counts until this is set, or the boat is disarmed"),
    _real("FLW_TGT_FA", 180.0, -180.0, 180.0, "deg", "Follow", "Station: bearing from the lead boat in its own frame; 180 astern, 0 ahead, 90 abeam to starboard. A commanded one counts as for FLW_TGT_DST"),
    _real("FLW_TGT_MAX_VEL", 25.0, 0.0, 25.0, "m/s", "Follow", "Top speed in Follow; MPC_XY_VEL_MAX counts where it is lower"),
    _real("FLW_TGT_HT", 8.0, 0.0, 1000.0, "m", "Follow", "Height above the leader: taken from clients that set it, without effect on a boat"),
    _real("FLW_TGT_RS", 0.1, 0.0, 1.0, "norm", "Follow", "Responsiveness of an aircraft's follow-me: taken from clients that set it, without effect; FOLL_* and PATH_* tune this boat"),
    _int("FLW_TGT_ALT_M", 0, 0, 2, "", "Follow", "Altitude mode of an aircraft's follow-me: taken from clients that set it, without effect on a boat"),
    _int("FOLL_SYSID", 0, 0, 255, "", "Follow", "System id of the leader; 0: the first heard, until it is silent"),
    _real("FOLL_MIN_DIST", 12.0, 0.5, 200.0, "m", "Follow", "Keep-out: never nearer to the lead boat than this"),
    _real("FOLL_MARGIN", 3.5, 0.0, 100.0, "m", "Follow", "What is kept from the keep-out circle on purpose, for errors of both positions"),
    _real("FOLL_TTC", 2.0, 0.0, 30.0, "s", "Follow", "Time to the keep-out circle, going on as now, below which the boat has no thrust ahead, whatever its law asks for"),
    _real("FOLL_GAP_BW", 0.25, 0.02, 2.0, "1/s", "Follow", "Bandwidth of the gap loop: speed towards the station for each metre off it"),
    _real("FOLL_CLOSE_V", 4.0, 0.1, 20.0, "m/s", "Follow", "How much faster than the leader the boat closes up, at most"),
    _real("FOLL_LOOK_T", 2.0, 0.3, 20.0, "s", "Follow", "Look-ahead on the leader's track as a time at the present speed, where that is longer than PATH_LOOKAHEAD"),
    _real("FOLL_LOSS_T", 0.9, 0.5, 10.0, "s", "Follow", "Age of the leader's position, or of the boat's own, at which it has left Follow at the latest; three intervals of a source that sends less often"),
    _choice("FOLL_LOSS_ACT", 1, {1: "Hold", 2: "RTL", 3: "Neutral", 4: "Manual"}, "Follow", "What to do when the leader, its position or the boat's own is lost in Follow; Manual leaves the boat to the sticks"),
    _real("FOLL_BACK_T", 3.0, 0.5, 60.0, "s", "Follow", "How long the data must be good again before the boat goes back to Follow by itself, unless somebody chose another mode"),
    _real("FOLL_WAIT_T", 0.0, 0.0, 60.0, "s", "Follow", "How long Follow, chosen while armed and without a leader, waits for one, without thrust: some send only once the boat is in Follow. 0: it is refused"),
    _choice("FOLL_AUTH", 1, {0: "Ground stations", 1: "Ground stations and lead boat"}, "Follow", "Who chooses the mode, the newest decision counting: with 0 what the lead boat's crew asks for is not obeyed"),
    _real("FOLL_LATENCY", 0.1, 0.0, 2.0, "s", "Follow", "How old a leader's message is when it comes in, where that cannot be measured (a ground station's, a phone's)"),
    _choice("FOLL_LAW", 0, {0: "Companion", 1: "Thesis"}, "Follow", "How the leader is followed: along its track, or by pursuit as in the RescueRunner thesis"),
    # the RescueRunner thesis's law (FOLL_LAW 1): nozzle (1: full) per rad, throttle (1: full) per m/s, speed in m/s per metre of distance
    *(
        _real(f"FOLT_{term}{suffix}", default, 0.0, 20.0, unit, "Thesis law", f"{what} gain of {axis}")
        for suffix, axis, gains, unit in (
            ("", "the nozzle, of the angle to the leader", (1.2, 0.0, 1.5), "1/rad"),
            ("_SPD", "the throttle, of speed", (0.15, 0.5, 0.0), "s/m"),
            ("_DST", "the speed, of distance", (0.15, 0.0, 0.0), "1/s"),
        )
        for term, what, default in zip(("KP", "KI", "KD"), ("Proportional", "Integral", "Derivative"), gains, strict=True)
    ),
    _real("FOLT_TF", 0.26, 0.0, 10.0, "s", "Thesis law", "Time constant that filters the derivatives"),
    # offboard
    _real("OFFB_TIMEOUT", 0.8, 0.2, 60.0, "s", "Offboard", "Age at which the newest setpoint of the computer that steers in Offboard counts no more"),
    _choice("OFFB_LOSS_ACT", 1, {1: "Hold", 2: "RTL", 3: "Neutral"}, "Offboard", "What to do when setpoints stop in Offboard; with Neutral the boat goes on when they come again"),
    # allocation
    _choice("ALLOC_KIND", 0, {0: "Constrained", 1: "Pseudo-inverse"}, "Allocation", "Optimal within limits and rates, or the unconstrained solution cut to them"),
    _int("ALLOC_ITER", 3, 1, 6, "", "Allocation", "Re-linearisations of the thrust allocation in a cycle"),
    _real("ALLOC_W_POWER", 1.0, 0.0, 100.0, "", "Allocation", "Weight of power in the thrust allocation"),
    _real("ALLOC_W_TURN", 2.0, 0.0, 100.0, "", "Allocation", "Weight against turning the azimuths"),
    _real("JET_STEER_N", 400.0, 0.0, 5000.0, "N", "Allocation", "Largest thrust of a water jet that is given for the sake of steering where less is asked for: without thrust its nozzle does nothing"),
    _real("JET_MIN_THR", 0.05, 0.01, 0.5, "norm", "Allocation", "Least throttle of a water jet whose impeller turns"),
    # thrusters, commanded against measured
    _choice("THR_WATCH", 1, _YES_NO, "Thrusters", "Leave out a thruster that does not do what it is told, by its own feedback"),
    _real("THR_TOL", 0.15, 0.02, 1.0, "norm", "Thrusters", "How far the measured throttle may be off"),
    _real("THR_TOL_AZ", 15.0, 2.0, 90.0, "deg", "Thrusters", "How far the measured azimuth may be off"),
    _real("THR_LAG", 1.0, 0.1, 10.0, "s", "Thrusters", "Time constant with which a sound propeller may still lag behind"),
    _real("THR_FAIL_T", 1.5, 0.2, 10.0, "s", "Thrusters", "How long it may be off before it is left out"),
    _real("THR_RETRY_T", 60.0, 0.0, 3600.0, "s", "Thrusters", "When a thruster that was left out is tried again; 0: when the boat is armed anew"),
    # names that QGroundControl's PX4 pages look up
    _fixed("SYS_AUTOSTART", 50000, "Airframe"),
    _fixed("SYS_AUTOCONFIG", 0, "Airframe reset"),
    _fixed("CAL_GYRO0_ID", 1, "Gyro present"),
    _fixed("CAL_ACC0_ID", 1, "Accelerometer present"),
    _fixed("CAL_MAG0_ID", 1, "Heading source present"),
    _fixed("CAL_MAG1_ID", 0, "No second magnetometer"),
    _fixed("CAL_MAG2_ID", 0, "No third magnetometer"),
    _fixed("SYS_HAS_MAG", 0, "No magnetometer to calibrate"),
    _fixed("COM_RC_IN_MODE", 1, "Joystick only: no transmitter to calibrate"),
    *(_fixed(f"COM_FLTMODE{n}", -1, "No mode switch") for n in range(1, 7)),
    *(_fixed(f"RC_MAP_{n}", 0, "No transmitter map") for n in ("ROLL", "PITCH", "YAW", "THROTTLE", "FLAPS", "AUX1", "AUX2", "FLTMODE")),
    _fixed("RTL_RETURN_ALT", 0, "A boat stays on the water"),
    _fixed("RTL_DESCEND_ALT", 0, "A boat stays on the water"),
    _fixed("RTL_LAND_DELAY", -1, "RTL ends in Hold"),
    _fixed("COM_DISARM_LAND", -1, "No disarming by itself"),
    _fixed("BAT_EMERGEN_THR", 0, "Not used"),
    _fixed("GF_MAX_VER_DIST", 0, "A boat stays on the water"),
    _fixed("SDLOG_MODE", 0, "Logs are always written"),
)


class Parameters:
    """Values of all parameters. Reading is a dictionary look-up; the table never changes while the process runs."""

    def __init__(self, defaults: Mapping[str, float] | None = None, table: Iterable[ParamSpec] = TABLE) -> None:
        """`defaults`: the vessel's own, over the table's. Raises ValueError for a name or value that the table refuses."""
        self.specs: tuple[ParamSpec, ...] = tuple(sorted(table, key=lambda spec: spec.name))
        self._by_name = {spec.name: spec for spec in self.specs}
        self.index = {spec.name: i for i, spec in enumerate(self.specs)}
        self.defaults = {spec.name: self._coerced(spec, spec.default) for spec in self.specs}
        for name, value in (defaults or {}).items():
            refusal = self.refusal(name, value)
            if refusal is not None:
                raise ValueError(f"parameter {name} = {value}: {refusal.name.lower().replace('_', ' ')}")
            self.defaults[name] = self._coerced(self._by_name[name], value)
        self._values = dict(self.defaults)
        self._listeners: list[Callable[[str, float], None]] = []

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def spec(self, name: str) -> ParamSpec | None:
        return self._by_name.get(name)

    def changed(self) -> dict[str, float]:
        """What differs from the defaults: what the state file keeps."""
        return {name: value for name, value in self._values.items() if value != self.defaults[name]}

    def on_change(self, listener: Callable[[str, float], None]) -> None:
        """`listener(name, value)` after every accepted change."""
        self._listeners.append(listener)

    def refusal(self, name: str, value: float) -> ParamRefusal | None:
        """Why `value` would not be taken, or None."""
        spec = self._by_name.get(name)
        if spec is None:
            return ParamRefusal.DOES_NOT_EXIST
        if spec.read_only:
            return ParamRefusal.READ_ONLY
        if not math.isfinite(value):
            return ParamRefusal.VALUE_OUT_OF_RANGE
        low, taken, high = (self._coerced(spec, number) for number in (spec.minimum, value, spec.maximum))
        if not low <= taken <= high or (spec.choices and taken not in spec.choices):
            return ParamRefusal.VALUE_OUT_OF_RANGE
        return None

    def set(self, name: str, value: float) -> ParamRefusal | None:
        """Take `value` and tell the listeners, or say why not and leave all as it was."""
        refusal = self.refusal(name, value)
        if refusal is None:
            value = self._coerced(self._by_name[name], value)
            self._values[name] = value
            for listener in self._listeners:
                listener(name, value)
        return refusal

    def reset(self) -> None:
        """All back to the vessel's defaults."""
        for name, value in self.defaults.items():
            if self._values[name] != value:
                self.set(name, value)

    @staticmethod
    def _coerced(spec: ParamSpec, value: float) -> float:
        if spec.type is ParamType.INT32:
            return round(value) if math.isfinite(value) else value
        return _float32(value)


def _float32(value: float) -> float:
    """The nearest value that survives a MAVLink float, so that what a client wrote equals what it reads back."""
    if not math.isfinite(value):
        return value
    mantissa, exponent = math.frexp(value)
    return math.ldexp(round(math.ldexp(mantissa, 24)), exponent - 24)
