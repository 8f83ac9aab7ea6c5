"""A lidar whose bridge sends MAVLink OBSTACLE_DISTANCE: the nearest thing in each of 72 sectors of 5°.

Packed by pymavlink. Source: MAVLink common.xml.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.memory import MemoryDevice
from sitl.noise import stream
from sitl.obstacles import RoundObstacle
from sitl.traffic import ScriptedVessel

_SECTORS, _STEP_DEG = 72, 5.0
_RAYS = 5  # in each sector
_LEAST_M, _MOST_M = 0.5, 40.0
_NOISE_M = 0.05
_MISSED = 0.02  # share of sectors that see nothing of what is there: spray, dark surfaces
_FALSE = 0.0005  # share of sectors that see what is not there


class LidarEmulator:
    """Looks all around from its place aboard, in the direction of the hull."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._config, self._port, self._around = config, port, around
        self._draws = np.random.default_rng(stream(around.seed, f"{config.name} white").randrange(2**32))
        self._codec: Any = mavlink.MAVLink(None, srcSystem=1, srcComponent=mavlink.MAV_COMP_ID_OBSTACLE_AVOIDANCE)
        sectors = np.arange(_SECTORS)[:, None] * _STEP_DEG
        rays = (np.arange(_RAYS)[None, :] + 0.5) / _RAYS - 0.5
        self._rays_rad = np.radians(sectors + rays * _STEP_DEG)

    def speak(self, t_s: float) -> None:
        """Look now, and send."""
        hull, config, draws = self._around.hull, self._config, self._draws
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        place = (
            hull.north_m + c * config.x_m - s * config.y_m,
            hull.east_m + s * config.x_m + c * config.y_m,
        )
        bearings = self._rays_rad + hull.yaw_rad - config.heading_offset_rad
        vessels = [one for vessel in self._around.traffic.vessels for one in _circles(vessel, t_s)]
        nearest = self._around.obstacles.distances_m(place, bearings, t_s, vessels).min(axis=1)
        nearest = nearest + draws.normal(0.0, _NOISE_M, _SECTORS)
        nearest[draws.random(_SECTORS) < _MISSED] = math.inf
        false = draws.random(_SECTORS) < _FALSE
        nearest[false] = draws.uniform(_LEAST_M, _MOST_M, int(false.sum()))
        most_cm = round(100.0 * _MOST_M)
        cm = [
            most_cm + 1 if not math.isfinite(off) or off > _MOST_M else max(0, round(100.0 * off))
            for off in nearest.tolist()
        ]
        message = mavlink.MAVLink_obstacle_distance_message(
            round(t_s * 1e6),
            mavlink.MAV_DISTANCE_SENSOR_LASER,
            cm,
            round(_STEP_DEG),
            round(100.0 * _LEAST_M),
            most_cm,
            _STEP_DEG,
            0.0,
            mavlink.MAV_FRAME_BODY_FRD,
        )
        self._port.send(message.pack(self._codec), t_s + config.latency_s)


def _circles(vessel: ScriptedVessel, t_s: float) -> list[RoundObstacle]:
    """The hull of a vessel as circles along its keel, at the time for which they are made."""
    motion, radius_m = vessel.at(t_s), 0.5 * vessel.beam_m
    reach_m = max(0.0, 0.5 * vessel.length_m - radius_m)
    count = 1 + 2 * math.ceil(reach_m / max(radius_m, 0.1))
    north, east = math.cos(motion.course_rad), math.sin(motion.course_rad)
    offs = np.linspace(-reach_m, reach_m, count).tolist()
    return [RoundObstacle(motion.north_m + off * north, motion.east_m + off * east, radius_m) for off in offs]
