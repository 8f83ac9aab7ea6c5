"""A Pixhawk used as an inertial sensor: HEARTBEAT, and HIGHRES_IMU and ATTITUDE at the rates that the host requests.

Packed and parsed by pymavlink. Source: MAVLink common.xml; PX4 answers SET_MESSAGE_INTERVAL with COMMAND_ACK.
"""

from __future__ import annotations

import math
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.lies import HeadingLies, ImuLies
from sitl.magnetometer import MagnetometerModel
from sitl.memory import MemoryDevice
from sitl.sensors import ImuModel, imu_errors, north_of

_SYSTEM, _BOARD = 42, 1  # alone, and as part of a board that drives thrusters
_FIELDS = 0x1FF  # new values: accelerations, rates and magnetic field


class PixhawkEmulator:
    """Sends a heartbeat each second and the requested messages, `latency_s` after they are valid.

    On the port of a bridge it is the same autopilot as that one: its id, its kind, no answer to what that one obeys.
    """

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        dt_s = 1.0 / self.rate_hz
        errors = imu_errors(around.aboard, config.name, around.home, around.epoch_unix_ns, dt_s, around.seed)
        self._model = ImuModel(config, around.home, dt_s, around.seed, errors)
        self._field = MagnetometerModel(config, around.home, around.epoch_unix_ns, around.seed, around.aboard)
        self._lies, self._field_lies = (
            ImuLies(around.faults, config.name, around.seed),
            HeadingLies(around.faults, config.name, around.seed),
        )
        self._config, self._port, self._around = config, port, around
        self._north_rad = north_of(around.home, around.epoch_unix_ns) if config.heading == "magnetic" else 0.0
        self._shares = config.port in around.boards
        self._system = _BOARD if self._shares else _SYSTEM
        self._kind = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA if self._shares else mavlink.MAV_AUTOPILOT_PX4
        self._codec: Any = mavlink.MAVLink(None, srcSystem=self._system, srcComponent=1)
        self._codec.robust_parsing = True
        self._intervals_s: dict[int, float] = {}
        self._due_s: dict[int, float] = {mavlink.MAVLINK_MSG_ID_HEARTBEAT: 0.0}

    def speak(self, t_s: float) -> None:
        """Measure now, and send what is due."""
        around = self._around
        x, y, z, p, q, r, roll, pitch, yaw = self._lies.told(self._model.sample(around.hull, around.waves), t_s)
        self._hear(t_s)
        if "imu_lost" in around.faults.active:
            return
        if self._due(mavlink.MAVLINK_MSG_ID_HEARTBEAT, 1.0, t_s):
            self._send(
                mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_SURFACE_BOAT, self._kind, 0, 0, 3, 3),
                t_s,
            )
        if self._due(mavlink.MAVLINK_MSG_ID_HIGHRES_IMU, None, t_s):
            yaw_rad = self._field_lies.told(around.hull.yaw_rad, t_s)
            field = self._field.sample(around.waves.roll_rad, around.waves.pitch_rad, yaw_rad)
            own_us = round((t_s + self._lies.clock_off_s(t_s)) * 1e6)
            measured = mavlink.MAVLink_highres_imu_message(
                own_us, x, y, z, p, q, r, *field, 1013.0, 0.0, 0.0, 20.0, _FIELDS
            )
            for packet in self._lies.sent(measured.pack(self._codec)):
                self._port.send(packet, t_s + self._config.latency_s)
        if self._due(mavlink.MAVLINK_MSG_ID_ATTITUDE, None, t_s):
            heading = math.remainder(yaw - self._north_rad, math.tau)
            self._send(mavlink.MAVLink_attitude_message(round(t_s * 1e3), roll, pitch, heading, p, q, r), t_s)

    def _due(self, number: int, interval_s: float | None, t_s: float) -> bool:
        interval_s = self._intervals_s.get(number) if interval_s is None else interval_s
        if interval_s is None or t_s + 1e-6 < self._due_s.get(number, 0.0):
            return False
        self._due_s[number] = max(t_s, self._due_s.get(number, t_s) + interval_s)
        return True

    def _send(self, message: Any, t_s: float) -> None:
        self._port.send(message.pack(self._codec), t_s + self._config.latency_s)

    def _hear(self, t_s: float) -> None:
        data = b"".join(data for _, data in self._port.receive(t_s))
        for message in self._codec.parse_buffer(data) or ():
            if message.get_type() != "COMMAND_LONG" or message.target_system != self._system:
                continue
            known = message.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL and int(message.param1) in (
                mavlink.MAVLINK_MSG_ID_HIGHRES_IMU,
                mavlink.MAVLINK_MSG_ID_ATTITUDE,
            )
            if known:
                self._intervals_s[int(message.param1)] = message.param2 * 1e-6
            elif self._shares:
                continue
            result = mavlink.MAV_RESULT_ACCEPTED if known else mavlink.MAV_RESULT_UNSUPPORTED
            self._send(mavlink.MAVLink_command_ack_message(message.command, result), t_s)
