"""Accelerations, rates and attitude of a Pixhawk, or any autopilot that speaks MAVLink, over serial or network.

Source: MAVLink common.xml. HIGHRES_IMU is taken before SCALED_IMU, SCALED_IMU before RAW_IMU; RAW_IMU only of
ArduPilot, which fills it with mG, mrad/s and mgauss as it does SCALED_IMU (PX4 does not send it). All are body axes
forward, starboard, down. The autopilot is asked for the messages (SET_MESSAGE_INTERVAL) until they come; it knows us as
an onboard computer of its own system.
"""

from __future__ import annotations

import math
from typing import Any

from companion.config.devices import SensorConfig
from companion.core.angles import wrap_pi
from companion.core.ports import ByteStream
from companion.core.readings import Imu, MagneticField, Reading
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, UnknownMessage, frame, pack
from companion.io.sensors.driver import StreamDriver
from companion.io.sensors.own_yaw import OwnYaw
from companion.io.sensors.sample_clock import SampleClock

_ONBOARD_COMPUTER: int = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
_HEARTBEAT_S = 1.0
_ASK_S = 2.0  # between two requests for what does not come
_COMES_S = 1.0  # a message counts as coming for so long
_ATTITUDE_AGE_S = 0.1
_ATTITUDE_HZ = 20.0
_HEARD_S = 3.0
_G_MPS2 = 9.80665
_MILLI = 1e-3
_HIGHRES: int = mavlink.MAVLINK_MSG_ID_HIGHRES_IMU
_SCALED: int = mavlink.MAVLINK_MSG_ID_SCALED_IMU
_RAW: int = mavlink.MAVLINK_MSG_ID_RAW_IMU
_ATTITUDE: int = mavlink.MAVLINK_MSG_ID_ATTITUDE
_RANK = {_HIGHRES: 0, _SCALED: 1, _RAW: 2}
_ALL_FIELDS = 0x3F  # of HIGHRES_IMU's fields_updated: accelerations and rates
_FIELD_UPDATED = 0x1C0


class MavlinkImu(StreamDriver):
    """MAVLink frames → `Imu` with the attitude that goes with it, `MagneticField` for our own AHRS, and `Heading` from
    the autopilot's yaw where `heading` in the vessel's file allows it.

    Remembers the unfinished frame, the first autopilot that was heard, when each message last came and was asked for,
    the relation of the clocks, and the last attitude.
    """

    messages = "MAVLink messages"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._framer = Framer()
        self._autopilot: tuple[int, int] | None = None  # system, component
        self._ardupilot = False
        self._seen_s: dict[int, float] = {}
        self._asked_s = self._beat_s = -math.inf
        self._sequence = 0
        self._now_s = 0.0
        self._heard_s = -math.inf
        self._clocks: dict[int, SampleClock] = {}
        self._attitude: tuple[float, float, float, float] | None = None  # when, roll, pitch, yaw
        self._own_yaw = OwnYaw(config)
        self._gives_field = config.heading == "ahrs"

    def read(self, now_s: float) -> list[Reading]:
        """See `Sensor`. Sends the heartbeat and the requests that are due."""
        self._now_s = now_s
        readings = list(super().read(now_s))
        if self._autopilot is not None:
            self._speak(now_s)
        return readings

    def _complaint(self, age_s: float | None) -> str:
        complaint = super()._complaint(age_s)
        if not complaint or self._stream.fault() is not None or self._now_s - self._heard_s > _HEARD_S:
            return complaint
        if self._autopilot is None:
            return "MAVLink, but no autopilot's heartbeat yet"
        return (
            "the autopilot does not send the IMU messages that it is asked for (HIGHRES_IMU, SCALED_IMU): "
            "check its port's protocol and rates"
        )

    # --- in ---------------------------------------------------------------------------------------------------------

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        bad = self._framer.garbage
        for message in self._framer.feed(data):
            if isinstance(message, UnknownMessage):
                continue
            number = message.get_msgId()
            source = (message.get_srcSystem(), message.get_srcComponent())
            if (
                number == mavlink.MAVLINK_MSG_ID_HEARTBEAT
                and self._autopilot is None
                and message.autopilot != mavlink.MAV_AUTOPILOT_INVALID
            ):
                self._autopilot = source
                self._ardupilot = message.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
            self._valid += 1
            self._bytes_since_valid = 0
            self._heard_s = arrival_s
            if source == self._autopilot:
                self._pace.note(arrival_s, message.get_type())
                self._take(number, message, arrival_s, readings)
        self._bad += self._framer.garbage > bad

    def _take(self, number: int, message: Any, arrival_s: float, readings: list[Reading]) -> None:
        if number == _ATTITUDE:
            self._take_attitude(message, arrival_s, readings)
        elif number in _RANK and (number != _RAW or self._ardupilot):
            self._seen_s[number] = arrival_s
            if not any(self._comes(other, arrival_s) for other, rank in _RANK.items() if rank < _RANK[number]):
                self._take_imu(number, message, arrival_s, readings)

    def _comes(self, number: int, now_s: float) -> bool:
        return now_s - self._seen_s.get(number, -math.inf) <= _COMES_S

    def _take_imu(self, number: int, message: Any, arrival_s: float, readings: list[Reading]) -> None:
        self._last_valid_s = arrival_s  # only these count: a heartbeat alone brings no measurement
        axes = ("x", "y", "z")
        if number == _HIGHRES:
            if message.fields_updated & _ALL_FIELDS != _ALL_FIELDS:
                return
            t_s, force_unit, unit = self._time_s(number, message.time_usec, 1e-6, arrival_s), 1.0, 1.0
        else:
            stamp, tick_s = (message.time_usec, 1e-6) if number == _RAW else (message.time_boot_ms, 1e-3)
            t_s, force_unit, unit = self._time_s(number, stamp, tick_s, arrival_s), _G_MPS2 * _MILLI, _MILLI
        force, rate, field = ([getattr(message, f"{axis}{what}") for axis in axes] for what in ("acc", "gyro", "mag"))
        if not math.isfinite(sum(force) + sum(rate)):
            return
        if (
            self._gives_field
            and math.isfinite(sum(field))
            and (number != _HIGHRES or message.fields_updated & _FIELD_UPDATED == _FIELD_UPDATED)
        ):
            readings.append(MagneticField(t_s, self.name, *(unit * value for value in field)))
        attitude = self._attitude
        roll_pitch_yaw = (
            attitude[1:] if attitude is not None and abs(t_s - attitude[0]) <= _ATTITUDE_AGE_S else (None, None, None)
        )
        readings.append(
            Imu(
                t_s,
                self.name,
                *(force_unit * value for value in force),
                *(unit * value for value in rate),
                *roll_pitch_yaw,
            )
        )

    def _take_attitude(self, message: Any, arrival_s: float, readings: list[Reading]) -> None:
        self._seen_s[_ATTITUDE] = arrival_s
        t_s = self._time_s(_ATTITUDE, message.time_boot_ms, 1e-3, arrival_s)
        if not math.isfinite(message.roll + message.pitch + message.yaw):
            return
        self._attitude = t_s, message.roll, message.pitch, wrap_pi(message.yaw)
        if (heading := self._own_yaw.heading(t_s, message.yaw)) is not None:
            readings.append(heading)

    def _time_s(self, number: int, stamp: int, tick_s: float, arrival_s: float) -> float:
        clock = self._clocks.get(number)
        if clock is None:
            wrap = 2**64 if tick_s < _MILLI else 2**32
            clock = self._clocks[number] = SampleClock(self._config.latency_s, tick_s=tick_s, wrap=wrap)
        t_s = clock.time_s(stamp, arrival_s)
        self._pace.late(arrival_s - self._config.latency_s - t_s)
        return t_s

    # --- out --------------------------------------------------------------------------------------------------------

    def _speak(self, now_s: float) -> None:
        if now_s - self._beat_s >= _HEARTBEAT_S:
            self._beat_s = now_s
            beat = (
                mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
                mavlink.MAV_AUTOPILOT_INVALID,
                0,
                0,
                mavlink.MAV_STATE_ACTIVE,
                3,
            )
            self._send(mavlink.MAVLink_heartbeat_message(*beat), now_s)
        missing = [] if self._comes(_HIGHRES, now_s) or self._comes(_SCALED, now_s) else [_HIGHRES, _SCALED]
        if not self._comes(_ATTITUDE, now_s):
            missing.append(_ATTITUDE)
        if missing and now_s - self._asked_s >= _ASK_S:
            self._asked_s = now_s
            for number in missing:
                self._ask(number, _ATTITUDE_HZ if number == _ATTITUDE else self._config.rate_hz, now_s)

    def _ask(self, number: int, rate_hz: float, now_s: float) -> None:
        assert self._autopilot is not None
        command = (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0, float(number), 1e6 / rate_hz, 0.0, 0.0, 0.0, 0.0, 0.0)
        self._send(mavlink.MAVLink_command_long_message(*self._autopilot, *command), now_s)

    def _send(self, message: Any, now_s: float) -> None:
        assert self._autopilot is not None
        self._stream.write(frame(pack(message), self._sequence, self._autopilot[0], _ONBOARD_COMPUTER), now_s)
        self._sequence = (self._sequence + 1) & 0xFF
