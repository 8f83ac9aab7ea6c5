"""HIGH_LATENCY2: the vessel's state in one message of 42 bytes, for a link that is paid by the byte
(`?telemetry=high_latency`)."""

from __future__ import annotations

import math
from typing import Any

from companion.core.actuation import ThrusterCondition
from companion.io.mavlink.telemetry.view import INT16_MAX, UINT16_UNKNOWN, View, degrees_e7, fitted
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import Persona

PERIOD_S = 5.0
_CELSIUS_UNKNOWN = -128


def high_latency2(view: View, persona: Persona) -> Any:
    """HIGH_LATENCY2. Its fields have coarse units: 2°, 0.2 m/s, decimetres, decametres. custom0 has base_mode, which
    tells clients whether the vessel is armed; custom1 has the number of failsafes that act."""
    tick, status = view.tick, view.status
    if tick is None:
        return None
    nav, battery = tick.nav, tick.inputs.battery
    base_mode = persona.base_mode(status.mode, status.armed)
    number = view.custom_mode(persona, status.mode)
    bearing_rad, distance_m = _to_target(view)
    thrusters = tick.command.thrusters
    throttle = sum(abs(thruster.throttle) for thruster in thrusters) / len(thrusters) if thrusters else 0.0
    return mavlink.MAVLink_high_latency2_message(
        timestamp=view.boot_ms,
        type=mavlink.MAV_TYPE_SURFACE_BOAT,
        autopilot=persona.autopilot,
        custom_mode=number >> 16 if persona.packs_main_and_sub else number,
        latitude=degrees_e7(nav.lat_deg) if nav.position_valid else 0,
        longitude=degrees_e7(nav.lon_deg) if nav.position_valid else 0,
        altitude=fitted(nav.altitude_m, 1.0, -INT16_MAX, INT16_MAX, 0),
        target_altitude=fitted(nav.altitude_m, 1.0, -INT16_MAX, INT16_MAX, 0),
        heading=_half_degrees(nav.yaw_rad),
        target_heading=_half_degrees(bearing_rad),
        target_distance=fitted(distance_m, 0.1, 0, UINT16_UNKNOWN, 0),
        throttle=fitted(throttle, 100.0, 0, 100, 0),
        airspeed=0,
        airspeed_sp=0,
        groundspeed=fitted(math.hypot(nav.north_mps, nav.east_mps), 5.0, 0, 255, 0),
        windspeed=fitted(nav.wind_speed_mps, 5.0, 0, 255, 0),
        wind_heading=_half_degrees(nav.wind_from_rad or 0.0),
        eph=fitted(nav.position_accuracy_m, 10.0, 0, 255, 255),
        epv=255,
        temperature_air=_CELSIUS_UNKNOWN,
        climb_rate=0,
        battery=fitted(None if battery is None else battery.remaining, 100.0, 0, 100, -1),
        wp_num=min(status.mission.seq + persona.first_item, UINT16_UNKNOWN),
        failure_flags=_failures(view),
        custom0=base_mode - 256 if base_mode > 127 else base_mode,
        custom1=len(status.failsafes),
        custom2=0,
    )


def _to_target(view: View) -> tuple[float, float]:
    """(bearing in rad, distance in m) to the setpoint's target; the boat's heading and 0 where there is none."""
    assert view.tick is not None
    nav, setpoint = view.tick.nav, view.tick.setpoint
    target = setpoint.progress.target
    if target is None:
        return nav.yaw_rad, 0.0
    north_m, east_m = target.north_m - nav.north_m, target.east_m - nav.east_m
    return math.atan2(east_m, north_m), math.hypot(north_m, east_m)


def _failures(view: View) -> int:
    """HL_FAILURE_FLAG bits."""
    tick, status = view.tick, view.status
    assert tick is not None
    battery, parameters = tick.inputs.battery, view.vessel.parameters
    low = battery is not None and battery.remaining is not None and battery.remaining < parameters["BAT_LOW_THR"]
    flags = {
        mavlink.HL_FAILURE_FLAG_GPS: not tick.nav.position_valid,
        mavlink.HL_FAILURE_FLAG_3D_MAG: not tick.nav.heading_valid,
        mavlink.HL_FAILURE_FLAG_BATTERY: low,
        mavlink.HL_FAILURE_FLAG_ENGINE: ThrusterCondition.FAILED in tick.conditions,
        mavlink.HL_FAILURE_FLAG_GEOFENCE: status.fence is not None and status.fence.breached,
        mavlink.HL_FAILURE_FLAG_ESTIMATOR: not (tick.nav.position_valid and tick.nav.heading_valid),
    }
    return sum(flag for flag, failed in flags.items() if failed)


def _half_degrees(angle_rad: float) -> int:
    return round(math.degrees(angle_rad)) % 360 // 2 if math.isfinite(angle_rad) else 0
