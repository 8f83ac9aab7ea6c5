"""Into a harbour through its entrance, with an uncharted shoal before the berth: by lidar, and echo sounder for the
bottom.

The boat comes to the point inside, or declares that impossible and holds; it touches neither quay nor bottom. Judged by
the truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.noise import stream
from sitl.obstacles import Obstacles, Shoal, Wall
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, between, read_events, read_truth
from sitl.scenarios.obstacles import at_end, clear_water_m, draw_course, held, hull_of, sail_to_end
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, Settings

_TIMEOUT_S = 500.0
_STAY_S = 15.0
_SOUTH_M, _NORTH_M, _WEST_M, _EAST_M = 30.0, 110.0, -40.0, 40.0  # of the basin
_ENTRANCE_M = 18.0
_BERTH_M = (95.0, 0.0)
_LEAST_M = 1.2  # CP_DEPTH_MIN
_DRAUGHT_M = 0.4


def quays(entrance_m: float) -> list[Wall]:
    """Four sides; the southern one has a gap whose middle is at `entrance_m` east."""
    west, east = entrance_m - 0.5 * _ENTRANCE_M, entrance_m + 0.5 * _ENTRANCE_M
    return [
        Wall((_SOUTH_M, _WEST_M), (_SOUTH_M, west)),
        Wall((_SOUTH_M, east), (_SOUTH_M, _EAST_M)),
        Wall((_SOUTH_M, _WEST_M), (_NORTH_M, _WEST_M)),
        Wall((_SOUTH_M, _EAST_M), (_NORTH_M, _EAST_M)),
        Wall((_NORTH_M, _WEST_M), (_NORTH_M, _EAST_M)),
    ]


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail a mission of one leg through the harbour's wall to the berth; the entrance lies beside the straight way."""
    rig, speed_mps = gcs.rig, float(settings["speed"])
    home = LocalFrame(rig.config.home.lat_deg, rig.config.home.lon_deg)
    draws = stream(rig.world.seed, "harbour")
    gcs.ready()
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *home.to_geodetic(*_BERTH_M))])
    entrance_m = draws.uniform(-22.0, 22.0)
    rig.world.obstacles.walls += quays(entrance_m)
    shoal_m = draws.uniform(0.35, 0.6)  # of the way from the entrance to the berth
    place = (
        _SOUTH_M + shoal_m * (_BERTH_M[0] - _SOUTH_M),
        (1.0 - shoal_m) * entrance_m + draws.uniform(-4.0, 4.0),
    )
    rig.world.obstacles.shoals.append(Shoal(*place, draws.uniform(9.0, 14.0), draws.uniform(0.0, 0.5)))
    return sail_to_end(gcs, speed_mps, "the berth, or Hold", _TIMEOUT_S, _STAY_S)


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Least distance to the quays, least water under the hull, and how the voyage ends."""
    track = between(read_truth(folder), asked["started_s"])
    obstacles: Obstacles = asked["obstacles"]
    events = read_events(folder)
    depths = [
        obstacles.depth_m(*corner) for row in track[::5] for corner in hull_of(row, asked["length_m"], asked["beam_m"])
    ]
    metrics = {
        "clear_water_m": clear_water_m(track, obstacles, asked["length_m"], asked["beam_m"]),
        "least_depth_m": min(depths),
        "reached": float(asked["reached"]),
        "declared_impossible": float(any(event.name == "obstacle_stops" for event in events)),
        "shoals_found": float(sum(event.name == "shoal" for event in events)),
        "time_s": asked["ended_s"] - asked["started_s"],
        **at_end(track, asked),
    }
    ended = metrics["reached"] + metrics["declared_impossible"]
    checks = (
        Check("water between hull and quays", metrics["clear_water_m"], 0.3, "m", at_least=True),
        Check("depth of water under the hull", metrics["least_depth_m"], _DRAUGHT_M, "m", at_least=True),
        Check("route completed, or declared impossible", ended, 1.0, "", at_least=True),
        held(metrics, asked),
    )
    return metrics, checks


def plot(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `harbour.png` into the folder. Raises ImportError without matplotlib."""
    draw_course(folder / "harbour.png", asked, settings)


def _equipped(conditions: Conditions, settings: Settings) -> Conditions:
    parameters = {
        **conditions.parameters,
        "MPC_XY_VEL_MAX": max(1.0, float(settings["speed"])),
        "CP_DEPTH_MIN": _LEAST_M,
    }
    return replace(conditions, lidar=True, sounder=True, parameters=parameters)


SCENARIO = Scenario(
    name="harbour",
    text="into a harbour with a shoal, by lidar and echo sounder: neither quay nor bottom is touched",
    vessel="otter",
    defaults={"wind": "2", "current": "0.1", "gnss": "rtk", "waves": "", "speed": "0.8"},
    sail=sail,
    measure=measure,
    plot=plot,
    prepare=_equipped,
    lasts_s=250.0,
)
