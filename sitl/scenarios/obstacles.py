"""A field of 20 round obstacles that only a lidar knows, one of them moving, across the boat's route.

The boat reaches the end of its route, or declares that impossible and holds; it touches nothing and stays inside the
fence. Judged by the truth, with the hull as a rectangle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.noise import stream
from sitl.obstacles import Obstacles, RoundObstacle, between_m
from sitl.scenarios.figure import finish_chart, new_figure, set_title
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, Track, between, distance_to, read_events, read_truth
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MISSION, _HOLD = 0x04040000, 0x03040000
_ROUTE_M, _BESIDE_M = 100.0, 30.0
_BEYOND_M, _BEHIND_M = 20.0, 15.0  # of the fence, from the ends of the route
_PLANNED_M = 15.0  # least water beside the route, and _ENDS_M beyond its ends, that the fence leaves to plans
_ENDS_M = 5.0
_FIELD_M = (18.0, 86.0)  # of the route, with obstacles
_CLEAR_M = 10.0  # around both ends of the route
_RADII_M = (0.5, 2.5)
_TIMEOUT_S = 420.0
_STAY_S = 30.0  # a ReVolt needs 25 s to stop


def lying(draws: Random, count: int) -> list[RoundObstacle]:
    """Obstacles that lie, scattered over the field: some overlap, so gaps may be too narrow."""
    found: list[RoundObstacle] = []
    while len(found) < count:
        north_m, east_m = draws.uniform(*_FIELD_M), draws.uniform(-_BESIDE_M + 4.0, _BESIDE_M - 4.0)
        radius_m = draws.uniform(*_RADII_M)
        ends = (math.hypot(north_m, east_m), math.hypot(north_m - _ROUTE_M, east_m))
        if min(ends) - radius_m > _CLEAR_M:
            found.append(RoundObstacle(north_m, east_m, radius_m))
    return found


def moving(draws: Random, now_s: float, speed_mps: float) -> RoundObstacle:
    """One that drifts across the route about where the boat then is, and never gives way."""
    meeting_m = draws.uniform(0.4, 0.7) * _ROUTE_M
    meeting_s = now_s + 10.0 + meeting_m / speed_mps * draws.uniform(1.0, 1.3)
    side, drift_mps = draws.choice((-1.0, 1.0)), draws.uniform(0.5, 0.9)
    course = side * (0.5 * math.pi + math.radians(draws.uniform(-25.0, 25.0)))
    north_mps, east_mps = drift_mps * math.cos(course), drift_mps * math.sin(course)
    return RoundObstacle(
        meeting_m - meeting_s * north_mps, -meeting_s * east_mps, draws.uniform(0.8, 2.0), north_mps, east_mps
    )


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail a mission of one leg to the north through the field."""
    rig, speed_mps = gcs.rig, float(settings["speed"])
    home = LocalFrame(rig.config.home.lat_deg, rig.config.home.lon_deg)
    draws = stream(rig.world.seed, "obstacles")
    gcs.ready()
    beside_m = _upload_fence(gcs, home)
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *home.to_geodetic(_ROUTE_M, 0.0))])
    count = int(settings["count"])
    rig.world.obstacles.round += lying(draws, count - 1)
    rig.world.obstacles.round.append(moving(draws, rig.now_s, speed_mps))
    return {
        **sail_to_end(gcs, speed_mps, "the end of the route, or Hold", _TIMEOUT_S, _STAY_S),
        "beside_m": beside_m,
    }


def sail_to_end(gcs: GroundStation, speed_mps: float, end: str, timeout_s: float, stay_s: float) -> dict[str, Any]:
    """Sail the mission of one item that is uploaded until it ends or the boat holds, and `stay_s` more. Returns what
    `measure` asks for. `end` names the end in the error of a time-out."""
    rig = gcs.rig
    gcs.set_mode(_MISSION)
    gcs.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1.0, speed_mps, -1.0)
    gcs.arm()
    started_s = rig.now_s
    gcs.wait(end, lambda: 0 in gcs.reached or _is_holding(gcs), timeout_s)
    ended_s = rig.now_s
    gcs.sail(stay_s)
    return {
        "obstacles": rig.world.obstacles,
        "started_s": started_s,
        "ended_s": ended_s,
        "reached": 0 in gcs.reached,
        "length_m": rig.config.length_m,
        "beam_m": rig.config.beam_m,
        "drifts_m": None if rig.config.limits.sway_n > 0.0 else gcs.parameter("DP_ALARM_R"),
    }


def _is_holding(gcs: GroundStation) -> bool:
    """Whether the boat has changed to Hold."""
    return int(gcs.last["HEARTBEAT"].custom_mode) == _HOLD


def _upload_fence(gcs: GroundStation, home: LocalFrame) -> float:
    """A rectangle around the field, and wider for a boat that keeps far from its fence. Returns its half width."""
    config = gcs.rig.config
    kept_m = 0.5 * config.length_m + config.parameters.get("FENCE_MARGIN", 0.0)
    beside_m = max(_BESIDE_M, kept_m + _PLANNED_M)
    north_m = _ROUTE_M + max(_BEYOND_M, kept_m + _ENDS_M)
    south_m = -max(_BEHIND_M, kept_m + _ENDS_M)
    corners = ((north_m, -beside_m), (north_m, beside_m), (south_m, beside_m), (south_m, -beside_m))
    command, frame = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, mavlink.MAV_FRAME_GLOBAL
    fence = [Item(command, *home.to_geodetic(*corner), params=(4.0, 0.0, 0.0, 0.0), frame=frame) for corner in corners]
    gcs.upload(fence, mavlink.MAV_MISSION_TYPE_FENCE)
    return beside_m


def hull_of(row: dict[str, float], length_m: float, beam_m: float) -> list[tuple[float, float]]:
    """Corners of the hull at a row of the truth."""
    c, s = math.cos(row["yaw_rad"]), math.sin(row["yaw_rad"])
    around = ((0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5))
    return [
        (
            row["north_m"] + c * a * length_m - s * b * beam_m,
            row["east_m"] + s * a * length_m + c * b * beam_m,
        )
        for a, b in around
    ]


def clear_water_m(track: Track, obstacles: Obstacles, length_m: float, beam_m: float) -> float:
    """The least distance between hull and obstacles, from five rows a second."""
    every = max(1, round(0.2 * len(track) / max(0.2, track[-1]["t_s"] - track[0]["t_s"])))
    return min(between_m(hull_of(row, length_m, beam_m), obstacles, row["t_s"]) for row in track[::every])


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """How near the hull comes to the obstacles, and how the voyage ends."""
    track = between(read_truth(folder), asked["started_s"])
    events = read_events(folder)
    declared = any(event.name == "obstacle_stops" for event in events)
    metrics = {
        "clear_water_m": clear_water_m(track, asked["obstacles"], asked["length_m"], asked["beam_m"]),
        "reached": float(asked["reached"]),
        "declared_impossible": float(declared),
        "beside_m": max(abs(east) for row in track for _, east in hull_of(row, asked["length_m"], asked["beam_m"])),
        "rounds": float(sum(event.name == "obstacle_round" for event in events)),
        "time_s": asked["ended_s"] - asked["started_s"],
        **at_end(track, asked),
    }
    checks = (
        Check("water between hull and obstacles", metrics["clear_water_m"], 0.3, "m", at_least=True),
        Check("the hull stays inside the fence", metrics["beside_m"], asked["beside_m"], "m"),
        Check(
            "route completed, or declared impossible",
            metrics["reached"] + metrics["declared_impossible"],
            1.0,
            "",
            at_least=True,
        ),
        held(metrics, asked),
    )
    return metrics, checks


def at_end(track: Track, asked: dict[str, Any]) -> dict[str, float]:
    """Speed in the last row, and the farthest that the boat is from where its voyage ended."""
    stay = between(track, asked["ended_s"])
    return {
        "speed_at_end_mps": math.hypot(track[-1]["surge_mps"], track[-1]["sway_mps"]),
        "moves_on_m": max(distance_to(row, stay[0]["north_m"], stay[0]["east_m"]) for row in stay),
    }


def held(metrics: dict[str, float], asked: dict[str, Any]) -> Check:
    """It lies still at the end; without sideways thrust, it moves about within its circles."""
    if asked["drifts_m"] is None:
        return Check("speed at the end", metrics["speed_at_end_mps"], 0.3, "m/s")
    return Check("from where the voyage ended", metrics["moves_on_m"], asked["drifts_m"], "m")


def plot(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `obstacles.png` into the folder. Raises ImportError without matplotlib."""
    draw_course(folder / "obstacles.png", asked, settings)


def draw_course(path: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw the boat's course among the obstacles, from the truth beside the picture. Raises ImportError without
    matplotlib."""
    track = between(read_truth(path.parent), asked["started_s"])
    figure = new_figure(8.0, 9.0)
    axes = figure.add_subplot()
    axes.plot([row["east_m"] for row in track], [row["north_m"] for row in track])
    _draw_obstacles(axes, asked["obstacles"], [row["t_s"] for row in track])
    finish_chart(axes)
    set_title(figure, settings)
    figure.savefig(path, dpi=90)


def _draw_obstacles(axes: Axes, obstacles: Obstacles, times: Sequence[float]) -> None:
    """Draw them; a moving one every 20 s."""
    from matplotlib.patches import Circle

    for one in obstacles.round:
        moves = one.north_mps != 0.0 or one.east_mps != 0.0
        shown = times[:: max(1, round(20.0 * len(times) / (times[-1] - times[0])))] if moves else times[:1]
        for t_s in shown:
            north_m, east_m = one.at(t_s)
            axes.add_patch(Circle((east_m, north_m), one.radius_m, color="tab:red" if moves else "tab:gray"))
    for wall in obstacles.walls:
        axes.plot([wall.begin[1], wall.end[1]], [wall.begin[0], wall.end[0]], color="black")
    for shoal in obstacles.shoals:
        axes.add_patch(Circle((shoal.east_m, shoal.north_m), shoal.radius_m, color="tab:olive", alpha=0.3))


def _with_lidar(conditions: Conditions, settings: Settings) -> Conditions:
    parameters = {**conditions.parameters, "MPC_XY_VEL_MAX": max(1.0, float(settings["speed"]))}
    return replace(conditions, lidar=True, parameters=parameters)


SCENARIO = Scenario(
    name="obstacles",
    text="a field of 20 obstacles that only a lidar knows, one moving: nothing is touched",
    vessel="otter",
    defaults={
        "wind": "2",
        "current": "0.1",
        "gnss": "rtk",
        "waves": "",
        "speed": "1.0",
        "count": "20",
    },
    sail=sail,
    measure=measure,
    plot=plot,
    prepare=_with_lidar,
    lasts_s=180.0,
)
