"""Messages about following: a short report to the leader module, and to ground stations the leader's position and the
quality of its link."""

from __future__ import annotations

import math
from typing import Any

from companion.core.decision import ModeId
from companion.core.estimate import Leader, RelativeBy, TrackedTarget
from companion.core.geodesy import LocalFrame
from companion.core.readings import AisTarget
from companion.io.mavlink.telemetry.high_latency import PERIOD_S
from companion.io.mavlink.telemetry.motion import retraction
from companion.io.mavlink.telemetry.view import View
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.link_options import ALL, HIGH_LATENCY, LEADER
from companion.io.mavlink.wire.personas import Persona

LEADER_STREAMS = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 1.0,
    mavlink.MAVLINK_MSG_ID_DEBUG_VECT: 1.0,
}
"""Message id → period in s on a link with `?telemetry=leader`: 103 bytes/s in all."""
NARROW = {LEADER: LEADER_STREAMS, HIGH_LATENCY: {mavlink.MAVLINK_MSG_ID_HIGH_LATENCY2: PERIOD_S}}
"""Telemetry option of a link → message id → period in s, for the options that do not stream everything."""

_UNKNOWN_M = 9999.0
_SHOWN_S = 30.0  # after its last position, a leader is no longer shown


def streamed(endpoint: Endpoint, number: int) -> bool:
    """Whether a message may be sent to that endpoint without a request."""
    return endpoint.telemetry == ALL or number in NARROW[endpoint.telemetry]


def report(view: View, persona: Persona) -> Any:
    """DEBUG_VECT "follow" for the leader module. x: throttle of the first thruster, −1…1. y: its direction in degrees;
    of a jet the nozzle, positive pushes to starboard. z: packets of the module received here, modulo 65536."""
    if view.tick is None:
        return None
    first = view.tick.command.thrusters[0]
    azimuth_rad = 0.0 if first.azimuth_rad is None else first.azimuth_rad
    return mavlink.MAVLink_debug_vect_message(
        b"follow", view.unix_us, first.throttle, math.degrees(azimuth_rad), float(view.received & 0xFFFF)
    )


def named_values(view: View, persona: Persona) -> Any:
    """NAMED_VALUE_FLOAT: the retractable thruster; in Trial the seconds that are left (`trial_left`).

    In Follow also the distance to the leader in m (`lead_gap`), one sigma of its place relative to the boat in m
    (`lead_sigma`, 9999 unknown), what that rests on (`lead_by`: 0 positions, 1 difference of receivers, 2 moving base)
    and the counter of its link, 0 good … 40 (`lead_link`).
    """
    values = [retraction(view, persona)]
    if view.status.trial_left_s is not None:
        left = view.status.trial_left_s
        values.append(mavlink.MAVLink_named_value_float_message(view.boot_ms, b"trial_left", left))
    leader = view.status.leader
    if view.tick is not None and leader is not None and view.status.mode is ModeId.FOLLOW:
        nav = view.tick.nav
        gap_m = math.hypot(leader.north_m - nav.north_m, leader.east_m - nav.east_m)
        by = float(list(RelativeBy).index(leader.relative_by))
        for name, value in (
            (b"lead_gap", gap_m),
            (b"lead_link", float(leader.counter)),
            (b"lead_sigma", min(_UNKNOWN_M, leader.relative_m)),
            (b"lead_by", by),
        ):
            values.append(mavlink.MAVLink_named_value_float_message(view.boot_ms, name, value))
    return tuple(value for value in values if value is not None)


def as_vessel(leader: Leader | None, frame: LocalFrame, now_s: float) -> TrackedTarget | None:
    """The leader as a vessel for AIS_VESSEL, with its MAVLink system id as MMSI; real MMSIs are never that small. None
    where it is not known."""
    if leader is None or leader.age_s > _SHOWN_S:
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
