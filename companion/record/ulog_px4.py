"""PX4's topics of the tick, so that Flight Review, ulog2kml and other tools for PX4's logs show the track, the
attitude, the battery and the modes. Source: PX4, messages VehicleGlobalPosition, VehicleLocalPosition,
VehicleAttitude, SensorGps, BatteryStatus, VehicleStatus."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from companion.core.decision import ModeId
from companion.core.readings import FixType, GnssFix
from companion.core.tick import Tick
from companion.nav.lever_arms import quaternion_of
from companion.record.ulog_topics import topic

_GLOBAL = topic(
    "vehicle_global_position", double="lat lon", float="alt eph epv", uint8_t="lat_lon_valid alt_valid dead_reckoning"
)
_LOCAL = topic(
    "vehicle_local_position",
    float="x y z vx vy vz heading eph epv evh",
    uint8_t="xy_valid z_valid v_xy_valid heading_good_for_control",
)
_ATTITUDE = topic("vehicle_attitude", quaternion="q")
_RATES = topic("vehicle_angular_velocity", float="xyz_x xyz_y xyz_z")
_GPS = topic(
    "vehicle_gps_position",
    double="latitude_deg longitude_deg altitude_msl_m",
    float="eph epv hdop vel_m_s",
    uint8_t="fix_type satellites_used",
)
_BATTERY = topic("battery_status", float="voltage_v current_a remaining", uint8_t="connected")
_STATUS = topic("vehicle_status", uint8_t="arming_state nav_state failsafe vehicle_type system_type")
TOPICS = (_GLOBAL, _LOCAL, _ATTITUDE, _RATES, _GPS, _BATTERY, _STATUS)

_STANDBY, _ARMED = 1, 2
_ROVER, _SURFACE_BOAT = 3, 11  # VehicleStatus.VEHICLE_TYPE_ROVER; MAV_TYPE_SURFACE_BOAT
_NAV_STATES: Mapping[ModeId, int] = {
    ModeId.MANUAL: 0, ModeId.FORCES: 1, ModeId.HEADING: 15, ModeId.HOLD: 4, ModeId.MISSION: 3, ModeId.RTL: 5,
    ModeId.DOCK: 18, ModeId.FOLLOW: 19, ModeId.OFFBOARD: 14, ModeId.CIRCLE: 21,
    ModeId.TRIAL: 24, ModeId.RATE: 10,
}  # fmt: skip
_NO_FIX = (FixType.NONE, FixType.FIX_2D)


def rows(tick: Tick) -> Iterator[tuple[int, Sequence[float]]]:
    """(place in TOPICS, values without the timestamp) of what this tick has."""
    nav, status, battery = tick.nav, tick.status, tick.inputs.battery
    accuracy_m = nav.position_accuracy_m
    if nav.position_valid:
        known = nav.fix not in _NO_FIX
        yield 0, (nav.lat_deg, nav.lon_deg, nav.altitude_m, accuracy_m, accuracy_m, 1, 1, not known)
    yield (
        1,
        (
            nav.north_m, nav.east_m, 0.0, nav.north_mps, nav.east_mps, 0.0, nav.yaw_rad, accuracy_m, accuracy_m,
            nav.velocity_accuracy_mps, nav.position_valid, 0, nav.position_valid, nav.heading_valid,
        ),
    )  # fmt: skip
    yield 2, quaternion_of(nav.roll_rad, nav.pitch_rad, nav.yaw_rad)
    yield 3, (nav.roll_rate_radps, nav.pitch_rate_radps, nav.yaw_rate_radps)
    fix = next((reading for reading in reversed(tick.readings) if isinstance(reading, GnssFix)), None)
    if fix is not None:
        sigma = math.nan if fix.position_accuracy_m is None else fix.position_accuracy_m
        hdop = math.nan if fix.hdop is None else fix.hdop
        speed = math.hypot(nav.north_mps, nav.east_mps)
        yield (
            4,
            (
                fix.lat_deg, fix.lon_deg, fix.altitude_m or 0.0, sigma, sigma, hdop, speed, int(fix.fix),
                min(255, fix.satellites or 0),
            ),
        )  # fmt: skip
    if battery is not None:
        unknown = -1.0  # as PX4 has it
        current = unknown if battery.current_a is None else battery.current_a
        yield 5, (battery.voltage_v, current, unknown if battery.remaining is None else battery.remaining, 1)
    armed = _ARMED if status.armed else _STANDBY
    yield 6, (armed, _NAV_STATES[status.mode], bool(status.failsafes), _ROVER, _SURFACE_BOAT)
