"""Ticks as ULog, for PlotJuggler, Flight Review's tools and pyulog. Source: PX4 guide, "ULog File Format".

One topic for each step of the tick; each thruster is an instance of `usv_thruster`. Beside them stand PX4's own topics
(`ulog_px4.py`). SI units and radians, NaN for a
missing value. It is written through at every tick; readers accept a file that ends in mid-message.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping, Sequence

from companion.core.actuation import ThrusterCondition
from companion.core.decision import ModeId
from companion.core.setpoint import Point, desired_motion
from companion.core.tick import Tick
from companion.record import ulog_px4
from companion.record.ulog_topics import topic

FILE = "ticks.ulg"
_MAGIC = b"ULog\x01\x12\x35\x01"
_MESSAGE = struct.Struct("<HB")
_MODES = {mode: number for number, mode in enumerate(ModeId)}
_CONDITIONS = {condition: number for number, condition in enumerate(ThrusterCondition)}


_MOTION = topic(
    "usv_motion",
    double="lat_deg lon_deg",
    float="north_m east_m roll_rad pitch_rad yaw_rad surge_mps sway_mps north_mps east_mps yaw_rate_radps "
    "position_accuracy_m heading_accuracy_rad position_age_s wind_speed_mps wind_from_rad "
    "current_north_mps current_east_mps",
    uint8_t="position_valid heading_valid fix",
)
_STATUS = topic(
    "usv_status", float="load speed_override_mps", int32_t="mission_seq", uint8_t="mode armed failsafes mission_state"
)
_SETPOINT = topic(
    "usv_setpoint",
    float="north_m east_m yaw_rad surge_mps sway_mps yaw_rate_radps target_north_m target_east_m "
    "cross_track_error_m distance_to_go_m",
)
_WRENCH = topic(
    "usv_wrench",
    float="demanded_surge_n demanded_sway_n demanded_yaw_nm achieved_surge_n achieved_sway_n achieved_yaw_nm",
)
_THRUSTER = topic(
    "usv_thruster", float="throttle azimuth_rad force_n measured_throttle measured_azimuth_rad", uint8_t="condition"
)
_BATTERY = topic("usv_battery", float="voltage_v current_a remaining")
_OWN = (_MOTION, _STATUS, _SETPOINT, _WRENCH, _THRUSTER, _BATTERY)
_TOPICS = (*_OWN, *ulog_px4.TOPICS)


class UlogEncoder:
    """`header` begins a file, `tick` is one tick, `parameter` a change. Remembers only the numbers of its topics."""

    def __init__(self, thrusters: Sequence[str]) -> None:
        self._thrusters = tuple(thrusters)
        self._layouts = [topic.layout for topic in _TOPICS]
        self._first_thruster = len(_TOPICS)  # their message numbers come last

    def header(self, information: Mapping[str, str], parameters: Mapping[str, float], whole: frozenset[str]) -> bytes:
        """Begins a file. `information`: about the run; `whole`: names of parameters that are whole numbers. Times are
        the vessel's."""
        parts = [_MAGIC, struct.pack("<Q", 0), _message("B", bytes(40))]
        parts += [_message("F", topic.definition) for topic in _TOPICS]
        parts += [
            _message("I", _keyed(f"char[{len(text.encode())}] {key}", text.encode()))
            for key, text in information.items()
            if text
        ]
        parts += [self._parameter(name, value, name in whole) for name, value in parameters.items()]
        for number, each in enumerate(_TOPICS):
            if each is not _THRUSTER:
                parts.append(_message("A", struct.pack("<BH", 0, number) + each.name.encode()))
        for i, _ in enumerate(self._thrusters):
            parts.append(_message("A", struct.pack("<BH", i, self._first_thruster + i) + _THRUSTER.name.encode()))
        return b"".join(parts)

    def parameter(self, name: str, value: float, whole: bool) -> bytes:
        """A parameter that changed during the run."""
        return self._parameter(name, value, whole)

    def tick(self, tick: Tick) -> bytes:
        """All topics of a tick, and its events as log messages."""
        now_us = round(tick.t_s * 1e6)
        rows = [
            self._row(0, 0, now_us, _motion(tick)),
            self._row(1, 1, now_us, _status(tick)),
            self._row(2, 2, now_us, _setpoint(tick)),
            self._row(3, 3, now_us, _wrench(tick)),
        ]
        rows += [
            self._row(4, self._first_thruster + i, now_us, _thruster(tick, i)) for i in range(len(self._thrusters))
        ]
        battery = tick.inputs.battery
        if battery is not None:
            rows.append(
                self._row(5, 5, now_us, (battery.voltage_v, _or_nan(battery.current_a), _or_nan(battery.remaining)))
            )
        rows += [self._row(len(_OWN) + at, len(_OWN) + at, now_us, values) for at, values in ulog_px4.rows(tick)]
        for event in tick.events:
            rows.append(
                _message(
                    "L",
                    struct.pack("<BQ", ord("0") + min(7, event.severity), round(event.t_s * 1e6))
                    + event.text.encode()[:1000],
                )
            )
        return b"".join(rows)

    def _row(self, topic: int, number: int, now_us: int, values: Sequence[float]) -> bytes:
        return _message("D", self._layouts[topic].pack(number, now_us, *values))

    @staticmethod
    def _parameter(name: str, value: float, whole: bool) -> bytes:
        kind, data = ("int32_t", struct.pack("<i", int(value))) if whole else ("float", struct.pack("<f", value))
        return _message("P", _keyed(f"{kind} {name}", data))


def _message(kind: str, body: bytes) -> bytes:
    return _MESSAGE.pack(len(body), ord(kind)) + body


def _keyed(key: str, value: bytes) -> bytes:
    return bytes([len(key)]) + key.encode() + value


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


def _motion(tick: Tick) -> tuple[float, ...]:
    nav = tick.nav
    return (
        nav.lat_deg, nav.lon_deg, nav.north_m, nav.east_m, nav.roll_rad, nav.pitch_rad, nav.yaw_rad, nav.surge_mps,
        nav.sway_mps, nav.north_mps, nav.east_mps, nav.yaw_rate_radps, nav.position_accuracy_m,
        nav.heading_accuracy_rad, nav.position_age_s, _or_nan(nav.wind_speed_mps), _or_nan(nav.wind_from_rad),
        _or_nan(nav.current_north_mps), _or_nan(nav.current_east_mps),
        nav.position_valid, nav.heading_valid, int(nav.fix),
    )  # fmt: skip


def _status(tick: Tick) -> tuple[float, ...]:
    status = tick.status
    return (
        tick.load, _or_nan(status.speed_override_mps), status.mission.seq, _MODES[status.mode], status.armed,
        min(255, len(status.failsafes)), int(status.mission.state),
    )  # fmt: skip


def _setpoint(tick: Tick) -> tuple[float, ...]:
    progress, motion = tick.setpoint.progress, desired_motion(tick.setpoint)
    return (
        *_place(motion.place),
        _or_nan(motion.yaw_rad),
        motion.surge_mps,
        motion.sway_mps,
        motion.yaw_rate_radps,
        *_place(progress.target),
        _or_nan(progress.cross_track_error_m),
        _or_nan(progress.distance_to_go_m),
    )


def _place(point: Point | None) -> tuple[float, float]:
    return (math.nan, math.nan) if point is None else (point.north_m, point.east_m)


def _wrench(tick: Tick) -> tuple[float, ...]:
    demanded, achieved = tick.wrench, tick.allocation.achieved
    return demanded.surge_n, demanded.sway_n, demanded.yaw_nm, achieved.surge_n, achieved.sway_n, achieved.yaw_nm


def _thruster(tick: Tick, i: int) -> tuple[float, ...]:
    command = tick.command.thrusters[i]
    measured = tick.feedback[i] if i < len(tick.feedback) else None
    condition = tick.conditions[i] if i < len(tick.conditions) else ThrusterCondition.READY
    back = (math.nan, math.nan) if measured is None else (_or_nan(measured.throttle), _or_nan(measured.azimuth_rad))
    return command.throttle, _or_nan(command.azimuth_rad), command.force_n, *back, _CONDITIONS[condition]
