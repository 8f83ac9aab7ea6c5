"""A stand-in for ArduRover: as much of its two protocols as `sitl.evaluate.ardurover` uses, and a simple autopilot of a
BlueBoat. Written from the documentation of the JSON interface and of MAVLink.

The parameter STAND_IN makes it misbehave: 1 refuses the mission, 2 dies when armed, 3 never arms.
"""

from __future__ import annotations

import argparse
import json
import math
import socket
import struct
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

REFUSES, DIES, STAYS_DISARMED = 1, 2, 3
_LOITER, _AUTO, _GUIDED = 5, 10, 15
_EARTH_M = 6378137.0


class StandIn:
    def __init__(self, pulses_port: int, words_port: int, home: str, habit: int) -> None:
        self.habit = habit
        self.lat_deg, self.lon_deg = map(float, home.split(",")[:2])
        self.pulses, self.words = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        self.pulses.connect(("127.0.0.1", pulses_port))
        self.words.connect(("127.0.0.1", words_port))
        self.words.setblocking(False)
        self.wire = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.mode, self.armed, self.count, self.current = 4, False, 0, 1
        self.items: list[tuple[float, float]] = []
        self.target = (0.0, 0.0)
        self.at = (0.0, 0.0)

    def run(self) -> None:
        left_us, right_us = 1500, 1500
        while True:
            self.pulses.send(struct.pack("<HHI16H", 18458, 100, self.count, left_us, 0, right_us, *[0] * 13))
            state = json.loads(self.pulses.recv(4096))
            self.count += 1
            north, east, _ = state["position"]
            self.at = (north, east)
            while (data := self._heard()) is not None:
                for message in self.wire.parse_buffer(data) or ():
                    self._obey(message)
            if self.count % 10 == 0:
                self._tell()
            left_us, right_us = self._steer(state)

    def _heard(self) -> bytes | None:
        try:
            return self.words.recv(4096)
        except (BlockingIOError, ConnectionRefusedError):
            return None

    def _say(self, message: Any) -> None:
        self.words.send(message.pack(self.wire))

    def _place(self, point: tuple[float, float]) -> tuple[int, int]:
        north, east = (math.degrees(metres / _EARTH_M) for metres in point)
        return (
            round((self.lat_deg + north) * 1e7),
            round((self.lon_deg + east / math.cos(math.radians(self.lat_deg))) * 1e7),
        )

    def _point(self, lat_e7: int, lon_e7: int) -> tuple[float, float]:
        north, east = lat_e7 * 1e-7 - self.lat_deg, lon_e7 * 1e-7 - self.lon_deg
        return (
            math.radians(north) * _EARTH_M,
            math.radians(east) * _EARTH_M * math.cos(math.radians(self.lat_deg)),
        )

    def _tell(self) -> None:
        armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
        self._say(mavlink.MAVLink_heartbeat_message(11, 3, 1 | armed, self.mode, 4, 3))
        flags = mavlink.EKF_ATTITUDE | mavlink.EKF_VELOCITY_HORIZ | mavlink.EKF_POS_HORIZ_ABS
        self._say(mavlink.MAVLink_ekf_status_report_message(flags, 0.1, 0.1, 0.1, 0.1, 0.1))
        self._say(mavlink.MAVLink_global_position_int_message(self.count * 10, *self._place(self.at), *[0] * 6))
        place = self._place(self.target)
        self._say(mavlink.MAVLink_position_target_global_int_message(0, 5, 0, *place, *[0.0] * 9))
        self._say(mavlink.MAVLink_mission_current_message(self.current))

    def _obey(self, message: Any) -> None:
        kind = message.get_type()
        if kind == "COMMAND_LONG":
            self._command(message)
        elif kind == "SET_POSITION_TARGET_GLOBAL_INT":
            self.target = self._point(message.lat_int, message.lon_int)
        elif kind == "MISSION_COUNT":
            self.items, self.wanted = [], message.count
            self._ask()
        elif kind == "MISSION_ITEM_INT" and message.seq == len(self.items):
            self.items.append(self._point(message.x, message.y))
            self._ask()

    def _command(self, message: Any) -> None:
        if message.command == mavlink.MAV_CMD_DO_SET_MODE:
            self.mode = int(message.param2)
            if self.mode == _LOITER:
                self.target = self.at
        elif message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            if self.habit == DIES:
                raise SystemExit(1)
            self.armed = self.habit != STAYS_DISARMED
        elif message.command == mavlink.MAV_CMD_REQUEST_MESSAGE:
            version = (4 << 24) | (7 << 16)
            commit = list(b"abc\0\0\0\0\0")
            self._say(mavlink.MAVLink_autopilot_version_message(0, version, 0, 0, 0, commit, [0] * 8, [0] * 8, 0, 0, 0))

    def _ask(self) -> None:
        if self.habit == REFUSES:
            self._say(mavlink.MAVLink_mission_ack_message(255, 190, mavlink.MAV_MISSION_ERROR))
        elif len(self.items) < self.wanted:
            self._say(mavlink.MAVLink_mission_request_message(255, 190, len(self.items)))
        else:
            self._say(mavlink.MAVLink_mission_ack_message(255, 190, mavlink.MAV_MISSION_ACCEPTED))

    def _steer(self, state: Any) -> tuple[int, int]:
        if not self.armed:
            return 1500, 1500
        if self.mode == _AUTO and self.current < len(self.items):
            self.target = self.items[self.current]
        north, east = self.target[0] - self.at[0], self.target[1] - self.at[1]
        distance_m = math.hypot(north, east)
        if self.mode == _AUTO and distance_m < 0.5 and self.current < len(self.items):
            self._say(mavlink.MAVLink_mission_item_reached_message(self.current))
            self.current += 1
        off = math.remainder(math.atan2(east, north) - state["attitude"][2], math.tau)
        speed = min(0.3, 0.3 * distance_m) * max(math.cos(off), 0.0)
        turn = max(-0.4, min(0.4, 0.6 * off - 0.5 * state["imu"]["gyro"][2]))
        return round(1500 + 400 * (speed + turn)), round(1500 + 400 * (speed - turn))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--sim-port-out", type=int)
    parser.add_argument("--serial0")
    parser.add_argument("--home")
    parser.add_argument("--defaults", type=Path)
    arguments, _ = parser.parse_known_args()
    lines = dict(line.split() for line in arguments.defaults.read_text().splitlines())
    port = int(arguments.serial0.rpartition(":")[2])
    StandIn(arguments.sim_port_out, port, arguments.home, int(lines.get("STAND_IN", 0))).run()


if __name__ == "__main__":
    main()
