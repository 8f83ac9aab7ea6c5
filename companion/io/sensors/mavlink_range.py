"""A lidar, sonar, radar or rangefinder that speaks MAVLink on its own port: OBSTACLE_DISTANCE, DISTANCE_SENSOR.

Such are the bridges of many lidars (ArduPilot and PX4 take the same messages), and a computer that makes sectors of a
point cloud.
"""

from __future__ import annotations

import math

from companion.config.devices import SensorConfig
from companion.core.ports import ByteStream
from companion.core.readings import Reading
from companion.io.mavlink import ranges
from companion.io.mavlink.wire.framer import Framer, UnknownMessage
from companion.io.sensors.driver import StreamDriver


class MavlinkRange(StreamDriver):
    """MAVLink frames → `Ranges`, and `Depth` of a sensor that looks down. Remembers the unfinished frame.

    A reading is as old as its way to us: the stamps of such devices count from a start that nobody tells.
    """

    messages = "ranges"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._framer = Framer()
        self._heard_s = -math.inf
        self._now_s = 0.0

    def read(self, now_s: float) -> list[Reading]:
        """See `Sensor`."""
        self._now_s = now_s
        return list(super().read(now_s))

    def _complaint(self, age_s: float | None) -> str:
        complaint = super()._complaint(age_s)
        if complaint and self._stream.fault() is None and self._now_s - self._heard_s <= self._config.timeout_s:
            return "MAVLink, but neither OBSTACLE_DISTANCE nor DISTANCE_SENSOR: check what the device is set to send"
        return complaint

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        bad = self._framer.garbage
        config = self._config
        mounting = (config.heading_offset_rad, config.x_m, config.y_m)
        for message in self._framer.feed(data):
            self._heard_s = arrival_s
            self._bytes_since_valid = 0
            if isinstance(message, UnknownMessage):
                continue
            t_s = arrival_s - config.latency_s
            found: Reading | None = None
            if message.get_msgId() == ranges.OBSTACLE_DISTANCE:
                found = ranges.ranges_of(message, self.name, t_s, *mounting)
            elif message.get_msgId() == ranges.DISTANCE_SENSOR:
                found = ranges.reading_of(message, self.name, t_s, *mounting)
            if found is not None:
                self._count_valid(arrival_s, message.get_type())
                readings.append(found)
        self._bad += self._framer.garbage > bad
