"""Messages about measurements that do not steer the boat: GNSS corrections and depth."""

from __future__ import annotations

from typing import Any

from companion.core.readings import FixType
from companion.io.mavlink.telemetry.view import UINT8_UNKNOWN, UINT16_UNKNOWN, View, fitted
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import Persona

_GPS_EPOCH_S = 315_964_800  # of Unix time
_LEAP_S = 18  # GPS time minus UTC, since 2017
_WEEK_S = 604_800
_STALE_S = 30.0
_DEPTH_STALE_S = 5.0
_MOST_CM = 0xFFFE


def gps_rtk(view: View, persona: Persona) -> Any:
    """GPS_RTK: when the corrections in use were made, and whether the carrier phase is resolved. None while no receiver
    reports corrections.

    Fields that NMEA does not have (baseline, hypotheses, rate) stay 0.
    """
    corrections = None if view.tick is None else view.tick.inputs.corrections
    if view.tick is None or corrections is None or view.now_s - corrections.t_s > _STALE_S:
        return None
    nav = view.tick.nav
    week, of_week_s = divmod(view.unix_us / 1e6 - _GPS_EPOCH_S + _LEAP_S, _WEEK_S)
    return mavlink.MAVLink_gps_rtk_message(
        time_last_baseline_ms=max(0, round(1000.0 * (corrections.t_s - corrections.age_s))) & 0xFFFFFFFF,
        rtk_receiver_id=0,
        wn=fitted(week, 1.0, 0, UINT16_UNKNOWN, 0),
        tow=fitted(of_week_s, 1000.0, 0, 1000 * _WEEK_S, 0),
        rtk_health=int(nav.fix >= FixType.RTK_FLOAT),
        rtk_rate=0,
        nsats=fitted(nav.satellites, 1.0, 0, UINT8_UNKNOWN, 0),
        baseline_coords_type=mavlink.RTK_BASELINE_COORDINATE_SYSTEM_NED,
        baseline_a_mm=0,
        baseline_b_mm=0,
        baseline_c_mm=0,
        accuracy=fitted(nav.position_accuracy_m, 1000.0, 0, 0xFFFFFFFF, 0),
        iar_num_hypotheses=0,
    )


def distance_sensor(view: View, persona: Persona) -> Any:
    """DISTANCE_SENSOR: depth below the transducer, as a downward sonar; None while it is not measured."""
    depth = None if view.tick is None else view.tick.inputs.depth
    if depth is None or view.now_s - depth.t_s > _DEPTH_STALE_S:
        return None
    return mavlink.MAVLink_distance_sensor_message(
        view.boot_ms,
        0,
        fitted(depth.range_m, 100.0, 0, _MOST_CM, _MOST_CM),
        fitted(depth.below_transducer_m, 100.0, 0, _MOST_CM, 0),
        mavlink.MAV_DISTANCE_SENSOR_ULTRASOUND,
        0,
        mavlink.MAV_SENSOR_ROTATION_PITCH_270,
        UINT8_UNKNOWN,
    )
