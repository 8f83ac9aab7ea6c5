"""OBSTACLE_DISTANCE as a ground station gets it that asks for it; pymavlink is the client."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.cli.rig import LockstepRig
from sitl.obstacles import RoundObstacle
from sitl.scenarios.rig import Conditions

_HALF_SECOND_US = 500_000


class Station:
    """A client on the boat's link."""

    def __init__(self, rig: LockstepRig) -> None:
        self.rig = rig
        self._codec: Any = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)

    def send(self, message: Any) -> None:
        self.rig.send(message.pack(self._codec))

    def hear(self, seconds: float) -> list[Any]:
        """All OBSTACLE_DISTANCE of the boat within that time."""
        found: list[Any] = []
        for _ in range(round(seconds / self.rig.vessel.period_s)):
            self.rig.step()
            for message in self._codec.parse_buffer(self.rig.receive()) or ():
                if message.get_type() == "OBSTACLE_DISTANCE":
                    found.append(message)
        return found

    def ask(self, command: int, *params: float) -> None:
        padded = (*params, *(0.0 for _ in range(7 - len(params))))
        self.send(mavlink.MAVLink_command_long_message(1, 1, command, 0, *padded))


@pytest.fixture
def station(tmp_path: Path) -> Iterator[Station]:
    rig = LockstepRig(Conditions("otter", seed=3, lidar=True), tmp_path / "log")
    rig.world.obstacles.round += [RoundObstacle(12.0, 0.0, 1.5), RoundObstacle(0.0, 20.0, 1.0)]
    station = Station(rig)
    station.send(mavlink.MAVLink_heartbeat_message(6, 8, 192, 0, 4, 3))
    assert station.hear(6.0) == [], "nobody has asked"
    yield station
    rig.close()


def test_it_is_streamed_at_the_rate_asked_for(station: Station) -> None:
    station.ask(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE, _HALF_SECOND_US)
    found = station.hear(5.0)
    assert 9 <= len(found) <= 11
    station.ask(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE, -1)
    station.hear(0.5)
    assert station.hear(3.0) == []


def test_it_says_where_what_lies(station: Station) -> None:
    station.ask(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE)
    (message,) = station.hear(1.0)
    assert (message.increment, message.increment_f, message.angle_offset) == (5, 5.0, 0.0)
    assert message.frame == mavlink.MAV_FRAME_BODY_FRD and len(message.distances) == 72
    truth = station.rig.world.truth
    nothing = message.max_distance + 1
    assert message.max_distance == 4000
    for north_m, east_m, radius_m in ((12.0, 0.0, 1.5), (0.0, 20.0, 1.0)):
        off_m = math.hypot(north_m - truth.north_m, east_m - truth.east_m) - radius_m
        bearing = math.atan2(east_m - truth.east_m, north_m - truth.north_m) - truth.yaw_rad
        sector = round(math.degrees(bearing) / 5.0) % 72
        assert message.distances[sector] / 100.0 == pytest.approx(off_m, abs=0.8)
    assert sum(cm != nothing for cm in message.distances) < 16


def test_nothing_is_said_without_a_sensor(tmp_path: Path) -> None:
    rig = LockstepRig(Conditions("otter", seed=3), tmp_path / "log")
    station = Station(rig)
    station.send(mavlink.MAVLink_heartbeat_message(6, 8, 192, 0, 4, 3))
    station.ask(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE, _HALF_SECOND_US)
    assert station.hear(4.0) == []
    rig.close()
