"""What is told of following: to the lead boat's module in one small message, to ground stations where the leader is and how well the link carries."""

from __future__ import annotations

import math
from typing import Any

from companion.core.geodesy import LocalFrame
from companion.core.types import AisTarget, Leader, ModeId, TrackedTarget
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.dialects import Dialect
from companion.io.mavlink.endpoint import Endpoint
from companion.io.mavlink.high_latency import PERIOD_S
from companion.io.mavlink.link_options import ALL, HIGH_LATENCY, LEADER
from companion.io.mavlink.telemetry_motion import retraction
from companion.io.mavlink.view import View

LEADER_STREAMS = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 1.0,
    mavlink.MAVLINK_MSG_ID_DEBUG_VECT: 1.0,
}
"""Message id → period in s on a link with `?telemetry=leader`: 103 bytes a second in all."""
NARROW = {LEADER: LEADER_STREAMS, HIGH_LATENCY: {mavlink.MAVLINK_MSG_ID_HIGH_LATENCY2: PERIOD_S}}
"""The same by the name of the link's telemetry, where that is not everything."""

_SHOWN_S = 30.0  # after its last position a leader is no longer shown


def streamed(endpoint: Endpoint, number: int) -> bool:
    """Whether a message may be sent there unasked."""
    return endpoint.telemetry == ALL or number in NARROW[endpoint.telemetry]


def report(view: View, dialect: Dialect) -> Any:
    """DEBUG_VECT "follow": throttle −1…1 and direction in degrees (of a jet its nozzle, + pushes to starboard) of the first thruster, and how many packets of the
    leader module have come in on this endpoint, modulo 65536."""
    if view.tick is None:
        return None
    first = view.tick.command.thrusters[0]
    azimuth_rad = 0.0 if first.azimuth_rad is None else first.azimuth_rad
    return mavlink.MAVLink_debug_vect_message(
        b"follow", view.unix_us, first.throttle, math.degrees(azimuth_rad), float(view.received & 0xFFFF)
    )


def named_values(view: View, dialect: Dialect) -> Any:
    """The retractable thruster; in Follow the distance to the leader in m and the counter of the link, 0 good … 40."""
    values = [retraction(view, dialect)]
    leader = view.status.leader
    if view.tick is not None and leader is not None and view.status.mode is ModeId.FOLLOW:
        nav = view.tick.nav
        gap_m = math.hypot(leader.north_m - nav.north_m, leader.east_m - nav.east_m)
        for name, value in ((b"lead_gap", gap_m), (b"lead_link", float(leader.counter))):
            values.append(mavlink.MAVLink_named_value_float_message(view.boot_ms, name, value))
    return tuple(value for value in values if value is not None)


def as_vessel(leader: Leader | None, frame: LocalFrame | None, now_s: float) -> TrackedTarget | None:
    """The leader as AIS_VESSEL shows vessels, its MAVLink system id in place of an MMSI: no station's real number is that small."""
    if leader is None or frame is None or leader.age_s > _SHOWN_S:
        return None
    lat_deg, lon_deg = frame.to_geodetic(leader.north_m, leader.east_m)
    known = AisTarget(
        now_s,
        f"mavlink:{leader.system_id}",
        leader.system_id,
        lat_deg,
        lon_deg,
        math.atan2(leader.east_mps, leader.north_mps),
        math.hypot(leader.north_mps, leader.east_mps),
        leader.yaw_rad,
        name="LEADER",
    )
    return TrackedTarget(known, now_s, 1)
