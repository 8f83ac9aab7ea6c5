"""OBSTACLE_DISTANCE: what the boat knows of obstacles around it, for displays of proximity."""

from __future__ import annotations

import math
from typing import Any

from companion.io.mavlink.telemetry.view import UINT16_UNKNOWN, View
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import Persona
from companion.obstacles.surroundings import SECTORS

_MOST_CM = 0xFFFE - 1  # the next number says that nothing is there


def obstacle_distance(view: View, persona: Persona) -> Any:
    """OBSTACLE_DISTANCE in 72 sectors, the first ahead: all sensors together, with what they have seen lately. None
    while no ranging sensor is heard, or the place of the boat is not known.
    """
    around = view.vessel.supervisor.surroundings
    if view.tick is None or not around.on or not view.tick.nav.position_valid:
        return None
    most_cm = min(_MOST_CM, round(100.0 * around.reach_m))
    if most_cm <= 0:
        return None
    return mavlink.MAVLink_obstacle_distance_message(
        view.unix_us,
        mavlink.MAV_DISTANCE_SENSOR_UNKNOWN,
        [_centimetres(way_m, most_cm) for way_m in around.sectors_m(view.tick.nav).tolist()],
        round(360.0 / SECTORS),
        0,
        most_cm,
        360.0 / SECTORS,
        0.0,
        mavlink.MAV_FRAME_BODY_FRD,
    )


def _centimetres(way_m: float, most_cm: int) -> int:
    """One more than the largest distance where nothing is in reach; UINT16_MAX where nobody looks."""
    if math.isnan(way_m):
        return UINT16_UNKNOWN
    return most_cm + 1 if 100.0 * way_m > most_cm else round(100.0 * way_m)
