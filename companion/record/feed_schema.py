"""The messages of the feed, version by version: the one place that describes them.

The feed is a line of JSON a message, UTF-8. Numbers are SI and radians, as in the log; a missing value is null, and so
is one that is not finite. A reader ignores keys and kinds that it does not know. `kind` says what a message is:

hello   first, once: `version`, the vessel and its thrusters, the columns of the log, the modes and their numbers.
boat    what changes seldom: parameters, plans, the path, arming findings, sources, who has control. Once a second, if
        it has changed.
tick    one control step: `row` has the columns of the log's ticks.csv by name (`recorder.tick_columns`), `more` what
        the log keeps elsewhere (`MORE`). `sequence` rises by one a frame: a gap is what a slow reader has lost.
event   one event, as in events.csv. A new reader gets the last ones first.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from companion.core.actuation import ThrusterFeedback
from companion.core.decision import Event
from companion.core.estimate import Leader, NavState, TrackedTarget, WaveMotion
from companion.core.setpoint import PoseSetpoint, Progress, Setpoint
from companion.core.tick import Tick
from companion.record.recorder import tick_columns, tick_row

VERSION = 1

MORE: Mapping[str, str] = {
    "lat_deg": "latitude, degrees",
    "lon_deg": "longitude, degrees",
    "covariance_m2": "of the position: [north-north, north-east, east-east]",
    "velocity_accuracy_mps": "one sigma",
    "position_age_s": "of the last position that the filter took",
    "heading_age_s": "of the last heading that the filter took",
    "imu_age_s": "of the last inertial sample",
    "fix": "grade of the satellite fix",
    "satellites": "used by the receiver",
    "hdop": "as the receiver gives it",
    "clock": "whether a receiver gives the time",
    "wind_speed_mps": "true wind",
    "wind_from_rad": "true direction that it comes from",
    "current_north_mps": "velocity of the water over ground",
    "current_east_mps": "velocity of the water over ground",
    "current_accuracy_mps": "one sigma on the worse axis",
    "waves": "motion that positioning leaves alone: radps, north_m, east_m, yaw_rad; null where there is none",
    "roll_rad": "of the hull",
    "pitch_rad": "of the hull",
    "judged": "the newest innovation of each sense: sense, age_s, square, limit of the gate, accepted",
    "distrusted": "sensors that lie: sense, source, fault, excluded, asks",
    "battery": "voltage_v, current_a, remaining (0 to 1)",
    "depth_m": "of water below the transducer",
    "depth_age_s": "of that sounding",
    "corrections": "of the receiver: source, age_s, station",
    "feedback": "of each thruster, as measured: throttle, azimuth_rad, age_s; null where its bridge measures nothing",
    "limited": "whether surge, sway and yaw fall short of the demand",
    "gated": "limits that changed the demand",
    "health": "of devices, links and storage: name, ok, age_s, text",
    "refusals": "why arming would be refused",
    "intended_mode": "the mode last asked for",
    "landed": "whether the voyage is over",
    "mission": "state, seq, count",
    "fence": "breached, slowed; null without a fence",
    "home": "lat_deg, lon_deg, yaw_rad; null while there is none",
    "orbit": "circle that is sailed: north_m, east_m, radius_m",
    "leader": "system_id, north_m, east_m, north_mps, east_mps, yaw_rad, age_s, accuracy_m, counter, relative_m (one "
    "sigma of its place relative to the boat), relative_by (positions, difference or moving base)",
    "traffic": "vessels around: mmsi, name, lat_deg, lon_deg, course_rad, speed_mps, heading_rad, length_m, age_s",
    "progress": "where the setpoint leads: place, target ([north_m, east_m]), course_rad, distance_to_go_m",
    "pose": "whether the boat keeps a place: by dynamic positioning, or, without sideways thrust, near a point",
}
"""Keys of `more`, with their meaning."""


def line(message: Mapping[str, Any]) -> bytes:
    """A message as it goes over the socket."""
    return json.dumps(finite(message), separators=(",", ":"), allow_nan=False, default=str).encode() + b"\n"


def finite(value: Any) -> Any:
    """The value with None for every number that is not finite: JSON has no others."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: finite(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [finite(part) for part in value]
    return value


def event_message(event: Event, time_unix_ns: int) -> dict[str, Any]:
    """One event."""
    return {
        "kind": "event",
        "t_s": event.t_s,
        "time_unix_ns": time_unix_ns,
        "severity": event.severity.name,
        "name": event.name,
        "text": event.text,
    }


class TickEncoder:
    """Ticks → messages. `thrusters` and `devices` name the columns, as in the log."""

    def __init__(self, thrusters: Sequence[str], devices: Sequence[str]) -> None:
        self.columns = tuple(tick_columns(thrusters, devices))
        self._devices = tuple(devices)

    def message(self, tick: Tick, sequence: int, made_unix_ns: int) -> dict[str, Any]:
        """One tick. `made_unix_ns`: the wall clock when the tick was made, by which a reader tells its delay."""
        return {
            "kind": "tick",
            "sequence": sequence,
            "made_unix_ns": made_unix_ns,
            "row": row_of(self.columns, tick_row(tick, self._devices).rstrip("\n").split(",")),
            "more": more(tick),
        }


_WORDS = ("mode", "failsafes")


def row_of(columns: Iterable[str], cells: Iterable[str]) -> dict[str, Any]:
    """A row of ticks.csv by column: numbers, words, None for an empty cell."""
    return {name: _cell(name, cell) for name, cell in zip(columns, cells, strict=True)}


def _cell(name: str, cell: str) -> float | int | str | None:
    if name in _WORDS or name.endswith("_condition"):
        return cell
    if not cell:
        return None
    return int(cell) if cell.isdecimal() else float(cell)


def more(tick: Tick) -> dict[str, Any]:
    """What `MORE` lists."""
    nav, status, inputs, now_s = tick.nav, tick.status, tick.inputs, tick.t_s
    battery, corrections, home, fence, orbit = (
        inputs.battery,
        inputs.corrections,
        status.home,
        status.fence,
        status.orbit,
    )
    return {
        **_estimate(nav, now_s),
        "battery": None
        if battery is None
        else {"voltage_v": battery.voltage_v, "current_a": battery.current_a, "remaining": battery.remaining},
        "depth_m": None if inputs.depth is None else inputs.depth.below_transducer_m,
        "depth_age_s": None if inputs.depth is None else now_s - inputs.depth.t_s,
        "corrections": None
        if corrections is None
        else {
            "source": corrections.source,
            "age_s": corrections.age_s + now_s - corrections.t_s,
            "station": corrections.station,
        },
        "feedback": [None if report is None else feedback_row(report, now_s) for report in tick.feedback],
        "limited": list(tick.allocation.limited),
        "gated": list(tick.command.gated),
        "health": [{"name": row.name, "ok": row.ok, "age_s": row.age_s, "text": row.text} for row in tick.health],
        "refusals": list(status.arming_refusals),
        "intended_mode": status.intended_mode.value,
        "landed": status.landed,
        "mission": {"state": status.mission.state.name, "seq": status.mission.seq, "count": status.mission.count},
        "fence": None if fence is None else {"breached": fence.breached, "slowed": fence.slowed},
        "home": None if home is None else {"lat_deg": home.lat_deg, "lon_deg": home.lon_deg, "yaw_rad": home.yaw_rad},
        "orbit": None
        if orbit is None
        else {"north_m": orbit.north_m, "east_m": orbit.east_m, "radius_m": orbit.radius_m},
        "leader": None if status.leader is None else _leader(status.leader),
        "traffic": [row for target in status.traffic if (row := _target(target, now_s)) is not None],
        "progress": _progress(tick.setpoint.progress),
        "pose": _keeps_a_place(tick.setpoint),
    }


def _waves(waves: WaveMotion) -> dict[str, float]:
    return {"radps": waves.radps, "north_m": waves.north_m, "east_m": waves.east_m, "yaw_rad": waves.yaw_rad}


def _estimate(nav: NavState, now_s: float) -> dict[str, Any]:
    return {
        "lat_deg": nav.lat_deg,
        "lon_deg": nav.lon_deg,
        "covariance_m2": None if nav.position_covariance_m2 is None else list(nav.position_covariance_m2),
        "velocity_accuracy_mps": nav.velocity_accuracy_mps,
        "position_age_s": nav.position_age_s,
        "heading_age_s": nav.heading_age_s,
        "imu_age_s": nav.imu_age_s,
        "fix": nav.fix.name,
        "satellites": nav.satellites,
        "hdop": nav.hdop,
        "clock": nav.time_unix_ns is not None,
        "wind_speed_mps": nav.wind_speed_mps,
        "wind_from_rad": nav.wind_from_rad,
        "current_north_mps": nav.current_north_mps,
        "current_east_mps": nav.current_east_mps,
        "current_accuracy_mps": nav.current_accuracy_mps,
        "waves": None if nav.waves is None else _waves(nav.waves),
        "roll_rad": nav.roll_rad,
        "pitch_rad": nav.pitch_rad,
        "judged": [
            {
                "sense": row.sense,
                "age_s": now_s - row.t_s,
                "square": row.square,
                "limit": row.limit,
                "accepted": row.accepted,
            }
            for row in nav.judged
        ],
        "distrusted": [
            {"sense": row.sense, "source": row.source, "fault": row.fault, "excluded": row.excluded, "asks": row.asks}
            for row in nav.distrusted
        ],
    }


def feedback_row(report: ThrusterFeedback, now_s: float) -> dict[str, Any]:
    """An entry of `feedback`."""
    return {
        "throttle": report.throttle,
        "azimuth_rad": report.azimuth_rad,
        "age_s": now_s - report.t_s,
        "ok": report.ok,
    }


def _leader(leader: Leader) -> dict[str, Any]:
    return {
        "system_id": leader.system_id,
        "north_m": leader.north_m,
        "east_m": leader.east_m,
        "north_mps": leader.north_mps,
        "east_mps": leader.east_mps,
        "yaw_rad": leader.yaw_rad,
        "age_s": leader.age_s,
        "accuracy_m": leader.accuracy_m,
        "counter": leader.counter,
        "relative_m": None if math.isinf(leader.relative_m) else leader.relative_m,
        "relative_by": leader.relative_by.value,
    }


def _target(target: TrackedTarget, now_s: float) -> dict[str, Any] | None:
    known = target.known
    if known.lat_deg is None or known.lon_deg is None:
        return None
    return {
        "mmsi": known.mmsi,
        "name": target.label,
        "lat_deg": known.lat_deg,
        "lon_deg": known.lon_deg,
        "course_rad": known.course_rad,
        "speed_mps": known.speed_mps,
        "heading_rad": known.heading_rad,
        "length_m": None if known.bow_m is None or known.stern_m is None else known.bow_m + known.stern_m,
        "age_s": now_s - known.t_s,
    }


def _keeps_a_place(setpoint: Setpoint) -> bool:
    """Of a path, too, the progress has a place, but with the error beside it."""
    progress = setpoint.progress
    at_a_point = progress.place is not None and progress.cross_track_error_m is None
    return isinstance(setpoint, PoseSetpoint) or at_a_point


def _progress(progress: Progress) -> dict[str, Any]:
    place, target = progress.place, progress.target
    return {
        "place": None if place is None else [place.north_m, place.east_m],
        "target": None if target is None else [target.north_m, target.east_m],
        "course_rad": progress.course_rad,
        "distance_to_go_m": progress.distance_to_go_m,
    }
