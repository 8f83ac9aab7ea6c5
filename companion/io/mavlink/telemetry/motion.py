"""Messages about the boat's position and motion, its setpoint and its thrusters."""

from __future__ import annotations

import math
from typing import Any

from companion.core.actuation import ThrusterCondition
from companion.core.estimate import NavState, air_over_ground
from companion.core.frames import body_to_ned
from companion.core.readings import FixType
from companion.core.setpoint import PathSetpoint, PoseSetpoint, Setpoint, desired_motion
from companion.io.mavlink.telemetry.view import (
    INT16_MAX,
    UINT8_UNKNOWN,
    UINT16_UNKNOWN,
    View,
    centidegrees,
    degrees_e7,
    fitted,
    millimetres,
    whole_degrees,
)
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import Persona

_COURSE_SPEED_MPS = 0.2  # below it a course over ground is noise
_DOWN = {
    ThrusterCondition.RETRACTED: 0.0,
    ThrusterCondition.MOVING: 0.5,
    ThrusterCondition.READY: 1.0,
    ThrusterCondition.FAILED: math.nan,
}
_IGNORE_POSITION = 0b111
_IGNORE_Z = 0b100100100  # position, velocity and acceleration downwards
_IGNORE_VELOCITY = 0b111000
_IGNORE_ACCELERATION = 0b111000000
_IGNORE_YAW = 1 << 10
_IGNORE_YAW_RATE = 1 << 11
_OUTPUTS = 32
# EKF_STATUS_FLAGS: velocity downwards, height; position relative and absolute as predicted before arming
_PREDICTED_AND_VERTICAL = 4 | 32 | 256 | 512


def attitude(view: View, persona: Persona) -> Any:
    """ATTITUDE."""
    if view.tick is None:
        return None
    nav = view.tick.nav
    return mavlink.MAVLink_attitude_message(
        view.boot_ms,
        nav.roll_rad,
        nav.pitch_rad,
        nav.yaw_rad,
        nav.roll_rate_radps,
        nav.pitch_rate_radps,
        nav.yaw_rate_radps,
    )


def global_position_int(view: View, persona: Persona) -> Any:
    """GLOBAL_POSITION_INT; the heading is unknown while it is not valid."""
    if view.tick is None:
        return None
    nav, home = view.tick.nav, view.status.home
    return mavlink.MAVLink_global_position_int_message(
        view.boot_ms,
        degrees_e7(nav.lat_deg),
        degrees_e7(nav.lon_deg),
        millimetres(nav.altitude_m),
        0 if home is None else millimetres(nav.altitude_m - home.altitude_m),
        fitted(nav.north_mps, 100.0, -INT16_MAX, INT16_MAX, 0),
        fitted(nav.east_mps, 100.0, -INT16_MAX, INT16_MAX, 0),
        0,
        centidegrees(nav.yaw_rad if nav.heading_valid else None),
    )


def gps_raw_int(view: View, persona: Persona) -> Any:
    """GPS_RAW_INT, made from the estimate, with the fix type and satellites of the receiver in use."""
    if view.tick is None:
        return None
    nav = view.tick.nav
    speed_mps = math.hypot(nav.north_mps, nav.east_mps)
    course = centidegrees(math.atan2(nav.east_mps, nav.north_mps) if speed_mps > _COURSE_SPEED_MPS else None)
    yaw = (centidegrees(nav.yaw_rad) or 36000) if nav.heading_valid else 0  # 0: not available
    return mavlink.MAVLink_gps_raw_int_message(
        view.unix_us,
        nav.fix,
        degrees_e7(nav.lat_deg),
        degrees_e7(nav.lon_deg),
        millimetres(nav.altitude_m),
        fitted(nav.hdop, 100.0, 0, UINT16_UNKNOWN, UINT16_UNKNOWN),
        UINT16_UNKNOWN,
        fitted(speed_mps, 100.0, 0, UINT16_UNKNOWN, UINT16_UNKNOWN),
        course,
        fitted(nav.satellites, 1.0, 0, UINT8_UNKNOWN - 1, UINT8_UNKNOWN),
        h_acc=fitted(nav.position_accuracy_m, 1000.0, 0, 0xFFFFFFFF, 0),
        vel_acc=fitted(nav.velocity_accuracy_mps, 1000.0, 0, 0xFFFFFFFF, 0),
        hdg_acc=fitted(nav.heading_accuracy_rad, math.degrees(1e5), 0, 0xFFFFFFFF, 0),
        yaw=yaw,
    )


def local_position_ned(view: View, persona: Persona) -> Any:
    """LOCAL_POSITION_NED; None while the position is not valid: MAVSDK takes the message as a sign that it is."""
    if view.tick is None or not view.tick.nav.position_valid:
        return None
    nav = view.tick.nav
    return mavlink.MAVLink_local_position_ned_message(
        view.boot_ms, nav.north_m, nav.east_m, 0.0, nav.north_mps, nav.east_mps, 0.0
    )


def gps_global_origin(view: View, persona: Persona) -> Any:
    """GPS_GLOBAL_ORIGIN: where the plane of LOCAL_POSITION_NED begins. Down is 0 there at the boat's own height."""
    frame, tick = view.vessel.frame, view.tick
    altitude_mm = millimetres(None if tick is None else tick.nav.altitude_m)
    return mavlink.MAVLink_gps_global_origin_message(
        degrees_e7(frame.lat_deg), degrees_e7(frame.lon_deg), altitude_mm, view.unix_us
    )


def vfr_hud(view: View, persona: Persona) -> Any:
    """VFR_HUD: speeds, heading, and the mean throttle of all thrusters; the airspeed field has the measured wind."""
    tick = view.tick
    if tick is None:
        return None
    nav, wind, thrusters = tick.nav, tick.inputs.wind, tick.command.thrusters
    throttle = sum(abs(thruster.throttle) for thruster in thrusters) / len(thrusters) if thrusters else 0.0
    return mavlink.MAVLink_vfr_hud_message(
        0.0 if wind is None else wind.speed_mps,
        math.hypot(nav.north_mps, nav.east_mps),
        whole_degrees(nav.yaw_rad),
        fitted(throttle, 100.0, 0, 100, 0),
        nav.altitude_m,
        0.0,
    )


def nav_controller_output(view: View, persona: Persona) -> Any:
    """NAV_CONTROLLER_OUTPUT: heading asked for, bearing and distance to the target, speed that is missing, cross-track
    error."""
    if view.tick is None:
        return None
    nav, progress = view.tick.nav, view.tick.setpoint.progress
    bearing_rad, distance_m = 0.0, 0.0
    if progress.target is not None:
        north_m, east_m = progress.target.north_m - nav.north_m, progress.target.east_m - nav.east_m
        bearing_rad, distance_m = math.atan2(east_m, north_m), math.hypot(north_m, east_m)
    if progress.distance_to_go_m is not None:
        distance_m = progress.distance_to_go_m
    desired = desired_motion(view.tick.setpoint)
    desired_rad = desired.yaw_rad if desired.yaw_rad is not None else progress.course_rad
    steered = isinstance(view.tick.setpoint, PoseSetpoint | PathSetpoint)
    return mavlink.MAVLink_nav_controller_output_message(
        0.0,
        0.0,
        whole_degrees(desired_rad if desired_rad is not None else nav.yaw_rad),
        whole_degrees(bearing_rad),
        fitted(distance_m, 1.0, 0, UINT16_UNKNOWN, 0),
        0.0,
        desired.surge_mps - nav.surge_mps if steered else 0.0,
        progress.cross_track_error_m or 0.0,
    )


def orbit_execution_status(view: View, persona: Persona) -> Any:
    """The circle that Circle sails: ground stations draw it, with an arrow. Nothing in other modes."""
    orbit = view.status.orbit
    if orbit is None:
        return None
    lat_deg, lon_deg = view.vessel.frame.to_geodetic(orbit.north_m, orbit.east_m)
    return mavlink.MAVLink_orbit_execution_status_message(
        view.unix_us, orbit.radius_m, mavlink.MAV_FRAME_GLOBAL_INT, degrees_e7(lat_deg), degrees_e7(lon_deg), 0.0
    )


def position_target_global_int(view: View, persona: Persona) -> Any:
    """POSITION_TARGET_GLOBAL_INT: the setpoint; None while there is none."""
    if view.tick is None or (target := _target(view.tick.setpoint)) is None:
        return None
    place, rest, mask = target
    lat_deg, lon_deg = (0.0, 0.0) if place is None else view.vessel.frame.to_geodetic(*place)
    altitude_m, frame = view.tick.nav.altitude_m, mavlink.MAV_FRAME_GLOBAL_INT
    return mavlink.MAVLink_position_target_global_int_message(
        view.boot_ms, frame, mask, degrees_e7(lat_deg), degrees_e7(lon_deg), altitude_m, *rest
    )


def position_target_local_ned(view: View, persona: Persona) -> Any:
    """POSITION_TARGET_LOCAL_NED: the setpoint in the plane of LOCAL_POSITION_NED; None while there is none."""
    if view.tick is None or (target := _target(view.tick.setpoint)) is None:
        return None
    place, rest, mask = target
    return mavlink.MAVLink_position_target_local_ned_message(
        view.boot_ms, mavlink.MAV_FRAME_LOCAL_NED, mask, *(place or (0.0, 0.0)), 0.0, *rest
    )


def _target(setpoint: Setpoint) -> tuple[tuple[float, float] | None, tuple[float, ...], int] | None:
    """(position; velocity, acceleration, yaw and yaw rate in the messages' order; mask of ignored fields) of a
    setpoint; None where it has neither position nor yaw."""
    desired = desired_motion(setpoint)
    mask, place = _IGNORE_Z, None
    if desired.place is not None:
        place = (desired.place.north_m, desired.place.east_m)
    else:
        mask |= _IGNORE_POSITION
        if desired.yaw_rad is None:
            return None
    velocity, acceleration, mask = _motion(setpoint, mask)
    if desired.yaw_rad is None:
        mask |= _IGNORE_YAW | _IGNORE_YAW_RATE
    return place, (*velocity, 0.0, *acceleration, 0.0, desired.yaw_rad or 0.0, desired.yaw_rate_radps), mask


def _motion(setpoint: Setpoint, mask: int) -> tuple[tuple[float, float], tuple[float, float], int]:
    """(velocity north, east), (acceleration north, east) and the mask of ignored fields."""
    still = (0.0, 0.0)
    if not isinstance(setpoint, PoseSetpoint | PathSetpoint):
        return still, still, mask | _IGNORE_VELOCITY | _IGNORE_ACCELERATION
    velocity = body_to_ned(setpoint.surge_mps, setpoint.sway_mps, setpoint.yaw_rad)
    if isinstance(setpoint, PathSetpoint):
        return velocity, still, mask | _IGNORE_ACCELERATION
    return velocity, body_to_ned(setpoint.surge_mps2, setpoint.sway_mps2, setpoint.yaw_rad), mask


def estimator_status(view: View, persona: Persona) -> Any:
    """ESTIMATOR_STATUS: which parts of the estimate are valid, and the position's accuracy."""
    if view.tick is None:
        return None
    nav = view.tick.nav
    return mavlink.MAVLink_estimator_status_message(
        view.unix_us, _estimator_flags(nav), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, nav.position_accuracy_m, math.nan
    )


def ekf_status_report(view: View, persona: Persona) -> Any:
    """EKF_STATUS_REPORT: the same for clients of ArduPilot, which count the height too. DroneKit arms no boat without
    the predicted position in it."""
    if view.tick is None:
        return None
    nav = view.tick.nav
    flags = _estimator_flags(nav) | (_PREDICTED_AND_VERTICAL if nav.position_valid else 0)
    return mavlink.MAVLink_ekf_status_report_message(flags, 0.0, 0.0, 0.0, 0.0, 0.0)


def _estimator_flags(nav: NavState) -> int:
    flags = 0
    if nav.heading_valid:
        flags |= mavlink.ESTIMATOR_ATTITUDE
    if nav.position_valid:
        flags |= mavlink.ESTIMATOR_VELOCITY_HORIZ | mavlink.ESTIMATOR_POS_HORIZ_REL | mavlink.ESTIMATOR_POS_HORIZ_ABS
    if nav.fix <= FixType.NONE:
        flags |= mavlink.ESTIMATOR_CONST_POS_MODE
    return flags


def wind_cov(view: View, persona: Persona) -> Any:
    """WIND_COV: the true wind, as the direction it blows to; None where it is not measured."""
    if view.tick is None:
        return None
    air, altitude_m = air_over_ground(view.tick.nav), view.tick.nav.altitude_m
    if air is None:
        return None
    unknown = math.nan
    return mavlink.MAVLink_wind_cov_message(view.unix_us, *air, 0.0, unknown, unknown, altitude_m, unknown, unknown)


def retraction(view: View, persona: Persona) -> Any:
    """NAMED_VALUE_FLOAT of the first retractable thruster (`bow_down`): 0 up, 0.5 moving, 1 down, NaN failed. None
    for a boat without one."""
    if view.tick is None or not view.tick.conditions:
        return None
    for thruster, condition in zip(view.vessel.config.thrusters, view.tick.conditions, strict=True):
        if thruster.retractable:
            return mavlink.MAVLink_named_value_float_message(
                view.boot_ms, f"{thruster.name[:5]}_down".encode("ascii"), _DOWN[condition]
            )
    return None


def actuator_output_status(view: View, persona: Persona) -> Any:
    """ACTUATOR_OUTPUT_STATUS: throttles −1…1 in the order of the vessel file, then the azimuths of the thrusters that
    turn, divided by π."""
    if view.tick is None:
        return None
    thrusters = view.tick.command.thrusters
    outputs = [thruster.throttle for thruster in thrusters]
    outputs += [thruster.azimuth_rad / math.pi for thruster in thrusters if thruster.azimuth_rad is not None]
    outputs = outputs[:_OUTPUTS]
    active = (1 << len(outputs)) - 1 if view.tick.command.armed else 0
    return mavlink.MAVLink_actuator_output_status_message(
        view.unix_us, active, outputs + [0.0] * (_OUTPUTS - len(outputs))
    )
