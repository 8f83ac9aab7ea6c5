"""What two autopilots are asked to do on the same water, and how each of them is made to do it.

Both begin at the same time, and so meet the same gusts. A route has a run-in: it is judged from home on, which is
passed at full speed, so that neither is judged by how it lies and waits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import VesselConfig, find, load
from companion.core.geodesy import LocalFrame
from sitl.evaluate.ardurover import ArduRover
from sitl.evaluate.figures import Figure, hold, route
from sitl.evaluate.rover_setup import RoverSetup
from sitl.evaluate.rover_station import AUTO, GUIDED, LOITER
from sitl.json_physics import parse_outputs, without_boards
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Point, Track, between, distance_to, read_truth, square
from sitl.scenarios.rig import Composer, Conditions
from sitl.scenarios.routes import ROUTES, transects
from sitl.world import World, WorldConditions

_HOLD, _MISSION = 0x03040000, 0x04040000
_SETTLE_S = 60.0
_RUN_IN_M = 30.0
_END_M = 2.0  # a route ends that far from its last waypoint
_NEAR_M, _NEAR_S = 1.5, 3.0
_SLOWEST_MPS = 0.08


@dataclass(frozen=True, slots=True)
class Task:
    """Hold at home, or a route of straight legs from home through `points`. Directions of `wind` and `current` that are
    left out come from the seed."""

    vessel: str
    wind: str
    current: str
    points: tuple[Point, ...] = ()
    hold_s: float = 600.0
    begin_s: float = 240.0  # of holding or of the run-in; until then the boat settles


@dataclass(frozen=True, slots=True)
class Sailed:
    """What is judged of a run. `point`, `yaw_rad`: what was to be held; None for a route, or where it was not asked.
    `version`: of the autopilot."""

    folder: Path
    from_s: float
    to_s: float = math.inf
    point: Point | None = None
    yaw_rad: float | None = None
    version: str = ""


TASKS: Mapping[str, Task] = {
    "hold, ReVolt": Task("revolt", "3", ""),
    "hold, ÅBOAT": Task("aboat", "6", "0.3"),
    "hold, Otter": Task("otter", "4", "0.2"),
    "hold, BlueBoat": Task("blueboat", "4", "0.2"),
    "hold, Heron": Task("heron", "4", "0.2"),
    "hold, WAM-V 16": Task("wamv16", "4", "0.2"),
    **{f"route {number}, ÅBOAT": Task("aboat", "6", "0.3", ROUTES[number].points) for number in "1234"},
    "square of 50 m, ÅBOAT": Task("aboat", "6", "0.3", square(50.0)),
    **{
        f"square of 100 m in a current of {share} %, ReVolt": Task(
            "revolt", "", f"{0.00987 * share:.3f}", square(100.0), begin_s=600.0
        )
        for share in (40, 60, 80)
    },
    "square of 50 m, Otter": Task("otter", "4", "0.2", square(50.0)),
    "square of 50 m, BlueBoat": Task("blueboat", "4", "0.2", square(50.0)),
    "survey lines, Otter": Task("otter", "4", "0.2", transects(6, 100.0, 12.0)),
    "survey lines, BlueBoat": Task("blueboat", "4", "0.2", transects(6, 100.0, 12.0)),
}


def judge(task: Task, sailed: Sailed) -> list[Figure]:
    """The figures of a run. Raises ValueError for a route that was not completed."""
    vessel, track = load(find(task.vessel)), between(read_truth(sailed.folder), sailed.from_s, sailed.to_s)
    if not task.points:
        return hold(track, vessel, sailed.point, sailed.yaw_rad)
    return route(_from_home(track), vessel, [(0.0, 0.0), *task.points], _END_M)


def _from_home(track: Track) -> Track:
    """The track from where it passes home, which is the first nearest place."""
    nearest_m, at = math.inf, 0
    for i, row in enumerate(track):
        off_m = distance_to(row, 0.0, 0.0)
        if off_m < nearest_m:
            nearest_m, at = off_m, i
        elif nearest_m < _END_M and off_m > nearest_m + _END_M:
            break
    return track[at:]


def _limit_s(task: Task, vessel: VesselConfig) -> float:
    length_m = sum(math.dist(a, b) for a, b in zip([(-_RUN_IN_M, 0.0), *task.points], task.points, strict=False))
    return 60.0 + length_m / _SLOWEST_MPS


# --- this project's autopilot ----------------------------------------------------------------------------------------


def sail_own(task: Task, seed: int, compose: Composer, folder: Path) -> Sailed:
    """Sail it with the companion. Raises GroundStationTimeout where it is not done in time."""
    conditions = Conditions(task.vessel, seed, task.wind or None, task.current or None, parameters={"PATH_KIND": 0.0})
    rig = compose(conditions, folder)
    try:
        gcs, home = GroundStation(rig), rig.config.home
        frame = LocalFrame(home.lat_deg, home.lon_deg)
        gcs.ready()
        gcs.set_mode(_HOLD)
        gcs.arm()
        gcs.reposition(*frame.to_geodetic(-_RUN_IN_M if task.points else 0.0, 0.0), home.yaw_rad)
        if not task.points:
            gcs.sail(task.begin_s + task.hold_s - rig.now_s)
            return Sailed(folder, task.begin_s, point=(0.0, 0.0), yaw_rad=home.yaw_rad)
        gcs.upload(
            [
                Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*point), params=(0.0, 0.0, 0.0, math.nan))
                for point in [(0.0, 0.0), *task.points]
            ]
        )
        gcs.sail(task.begin_s - rig.now_s)
        gcs.set_mode(_MISSION)
        gcs.wait("the last waypoint", lambda: len(task.points) in gcs.reached, _limit_s(task, rig.config))
        gcs.sail(5.0)
        return Sailed(folder, task.begin_s)
    finally:
        rig.close()


# --- ArduRover -------------------------------------------------------------------------------------------------------


def sail_rover(task: Task, seed: int, binary: Path, setup: RoverSetup, folder: Path) -> Sailed:
    """Sail it with ArduRover. Raises RoverError where it is not done in time."""
    vessel = load(find(task.vessel))
    world = World(
        without_boards(vessel), WorldConditions(seed=seed, wind=task.wind or None, current=task.current or None)
    )
    rover = ArduRover(binary, setup.parameters, vessel, world, parse_outputs(setup.outputs, vessel), folder)
    try:
        rover.ready()
        rover.set_mode(GUIDED)
        rover.arm()
        rover.go_to((-_RUN_IN_M if task.points else 0.0, 0.0))
        return (_route if task.points else _loiter)(rover, task, folder, _limit_s(task, vessel))
    finally:
        rover.close()


def _loiter(rover: ArduRover, task: Task, folder: Path, limit_s: float) -> Sailed:
    """It loiters where it is when it is told to: judged is by the point that it has made its target."""
    near_s = [math.inf]

    def near() -> bool:
        at = rover.station.at
        if at is None or math.hypot(*at) > _NEAR_M:
            near_s[0] = math.inf
        near_s[0] = min(near_s[0], rover.t_s)
        return rover.t_s - near_s[0] > _NEAR_S or rover.t_s > task.begin_s - _SETTLE_S

    rover.wait("home", near, limit_s)
    rover.set_mode(LOITER)
    rover.sail(task.begin_s - rover.t_s)
    point = rover.station.target
    rover.sail(task.hold_s)
    return Sailed(folder, task.begin_s, rover.t_s, point, version=rover.station.version)


def _route(rover: ArduRover, task: Task, folder: Path, limit_s: float) -> Sailed:
    last = len(task.points) + 1
    rover.upload([(0.0, 0.0), *task.points])
    rover.sail(task.begin_s - rover.t_s)
    rover.set_mode(AUTO)
    rover.wait("the last waypoint", lambda: rover.station.reached_item >= last, limit_s)
    rover.sail(5.0)
    return Sailed(folder, task.begin_s, version=rover.station.version)
