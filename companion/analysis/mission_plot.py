"""A plan as a picture: waypoints, the four curves through them, fence and rally points, curvature and speed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any

from companion.analysis.figure import new_figure
from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType
from companion.guidance.path import PathKind, build_path
from companion.guidance.path_tracking import PathTracker
from companion.guidance.waypoint import Waypoint
from companion.mission.commands import CIRCLES, PLACES, POLYGONS, Command, is_no_circle
from companion.mission.executor import MissionExecutor
from companion.mission.plan import PlanItem, PlanKind, Plans
from companion.mission.plan_file import PlanFile, PlanFileError
from companion.mission.tasks import Complete, RoutePoint, Sail, SetSpeed
from companion.params.store import Parameters

_MOST_POINTS = 3000
_MOST_LABELS = 40
_PIECES = 24  # drawn pieces between two waypoints
_STEPS = 6000  # of the simulated ideal boat, about
_COLOURS = {
    PathKind.LINEAR: "tab:gray",
    PathKind.PCHIP: "tab:blue",
    PathKind.MAKIMA: "tab:green",
    PathKind.CUBIC: "tab:red",
}
_NAMES = {
    PathKind.LINEAR: "linear",
    PathKind.PCHIP: "PCHIP",
    PathKind.MAKIMA: "modified Akima",
    PathKind.CUBIC: "cubic spline",
}
_AT_REST = NavState(
    t_s=0.0, position_valid=True, heading_valid=True, lat_deg=0.0, lon_deg=0.0, altitude_m=0.0, north_m=0.0,
    east_m=0.0, roll_rad=0.0, pitch_rad=0.0, yaw_rad=0.0, surge_mps=0.0, sway_mps=0.0, north_mps=0.0, east_mps=0.0,
    roll_rate_radps=0.0, pitch_rate_radps=0.0, yaw_rate_radps=0.0, position_accuracy_m=0.0, velocity_accuracy_mps=0.0,
    heading_accuracy_rad=0.0, position_age_s=0.0, heading_age_s=0.0, imu_age_s=0.0,
    fix=FixType.RTK_FIXED, satellites=None, hdop=None, time_unix_ns=None,
)  # fmt: skip

Line = tuple[list[float], list[float]]
Place = tuple[float, float]


@dataclass(frozen=True, slots=True)
class PathLeg:
    """Points without a stop between them, from `begin`. `stop`: stop at the end; `cruise_mps`: at the start."""

    begin: Place
    waypoints: tuple[Waypoint, ...]
    stop: bool
    cruise_mps: float


@dataclass(frozen=True, slots=True)
class Drawn:
    """One kind of curve through a mission: positions (east, north); curvature and speed over the distance."""

    track: Line
    curvature: Line
    speed: Line


def legs_of(plan: PlanFile, frame: LocalFrame, cruise_mps: float) -> list[PathLeg]:
    """What the executor has the boat sail, in order, from home or else the first waypoint. Endless jumps end after
    `_MOST_POINTS` points."""
    plans = Plans()
    executor = MissionExecutor(plans)
    plans.replace(PlanKind.MISSION, plan.mission)
    if executor.begin() is not None:
        return []
    legs: list[PathLeg] = []
    place: Place | None = None if plan.home is None else frame.to_ned(*plan.home[:2])
    speed_mps, count = cruise_mps, 0
    actions = executor.take_actions()
    while not isinstance(task := executor.task, Complete | None) and count < _MOST_POINTS:
        speed_mps = next(
            (action.speed_mps or cruise_mps for action in reversed(actions) if isinstance(action, SetSpeed)), speed_mps
        )
        if isinstance(task, Sail):
            waypoints = tuple(_waypoint(point, frame) for point in task.route)
            place = place or (waypoints[0].north_m, waypoints[0].east_m)
            legs.append(PathLeg(place, waypoints, task.stop, speed_mps))
            place = (waypoints[-1].north_m, waypoints[-1].east_m)
            actions = tuple(action for point in task.route for action in executor.complete(point.seq))
            count += len(waypoints)
        else:
            actions = executor.complete(task.seq)
            count += 1
            if executor.task is task:
                break
    return legs


def _waypoint(point: RoutePoint, frame: LocalFrame) -> Waypoint:
    return Waypoint(*frame.to_ned(point.lat_deg, point.lon_deg), point.radius_m, point.speed_mps)


def curve(legs: Sequence[PathLeg], parameters: Parameters, kind: PathKind) -> Drawn:
    """The curve of that kind through `legs`, and the speed at which path tracking takes it with an ideal boat."""
    north, east, along, bends = [], [], [], []
    begun_m = 0.0
    for leg in legs:
        path = build_path([leg.begin, *((w.north_m, w.east_m) for w in leg.waypoints)], kind)
        stations = path.waypoint_s_m
        places = [a + (b - a) * k / _PIECES for a, b in pairwise(stations) for k in range(_PIECES)]
        for s_m in (*places, path.length_m):
            point = path.at(s_m)
            north.append(point.north_m)
            east.append(point.east_m)
            along.append(begun_m + s_m)
            bends.append(point.curvature_1pm)
        begun_m += path.length_m
    own = Parameters(
        {
            **{spec.name: parameters[spec.name] for spec in parameters.specs if not spec.read_only},
            "PATH_KIND": float(kind),
        }
    )
    return Drawn((east, north), (along, bends), _speeds(legs, own, begun_m))


def _speeds(legs: Sequence[PathLeg], parameters: Parameters, length_m: float) -> Line:
    slowest = max(0.05, min((leg.cruise_mps for leg in legs), default=0.05))
    dt_s = max(0.1, length_m / slowest / _STEPS)
    distances, speeds, begun_m = [], [], 0.0
    nav = _AT_REST
    for leg in legs:
        nav = replace(nav, north_m=leg.begin[0], east_m=leg.begin[1])
        tracker = PathTracker(parameters, can_sway=False)
        tracker.start(leg.waypoints, nav, leg.stop)
        s_m = 0.0
        for _ in range(2 * _STEPS):
            progress = tracker.update(nav, leg.cruise_mps, dt_s)
            setpoint, s_m = progress.setpoint, progress.s_m
            place, course_rad = setpoint.progress.place, setpoint.progress.course_rad
            if progress.finished or place is None or course_rad is None:
                break
            pace = max(setpoint.surge_mps, 0.01 * leg.cruise_mps)
            c, s = math.cos(course_rad), math.sin(course_rad)
            distances.append(begun_m + s_m)
            speeds.append(setpoint.surge_mps)
            nav = replace(
                nav, north_m=place.north_m + c * pace * dt_s, east_m=place.east_m + s * pace * dt_s, yaw_rad=course_rad,
                surge_mps=pace, north_mps=c * pace, east_mps=s * pace,
            )  # fmt: skip
        begun_m += s_m
        if leg.stop:
            distances.append(begun_m)
            speeds.append(0.0)
            nav = replace(nav, surge_mps=0.0, north_mps=0.0, east_mps=0.0)
    return distances, speeds


# --- drawing -------------------------------------------------------------------------------------------------------


def draw(plan: PlanFile, parameters: Parameters, cruise_mps: float, title: str, out: FilePath) -> None:
    """Write the picture. Raises PlanFileError without matplotlib, or with nothing to draw."""
    try:
        figure = new_figure(14.0, 7.5)
    except ImportError as error:
        raise PlanFileError(["--plot needs matplotlib: pip install 'usv-companion[report]'"]) from error
    first = next((item for item in plan.mission if item.command in PLACES), None)
    if first is None:
        raise PlanFileError([f"{title}: no waypoint in it, so there is nothing to draw"])
    origin = (first.lat_deg, first.lon_deg) if plan.home is None else plan.home[:2]
    frame = LocalFrame(*origin)
    legs = legs_of(plan, frame, cruise_mps)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.3, 1.0))
    chart, bends, speeds = (
        figure.add_subplot(grid[:, 0]),
        figure.add_subplot(grid[0, 1]),
        figure.add_subplot(grid[1, 1]),
    )
    curves = {kind: curve(legs, parameters, kind) for kind in PathKind}
    for kind, drawn in curves.items():
        style: dict[str, Any] = {
            "color": _COLOURS[kind],
            "label": _NAMES[kind],
            "linewidth": 2.2 if kind is PathKind.PCHIP else 1.0,
        }
        style |= {"linestyle": "--", "zorder": 3} if kind is PathKind.LINEAR else {}
        chart.plot(*drawn.track, **style)
        bends.plot(*drawn.curvature, **style)
        speeds.plot(*drawn.speed, **style)
    _draw_places(chart, plan, frame)
    _finish(figure, (chart, bends, speeds), title, curves)
    figure.savefig(out, dpi=110)


def _finish(figure: Any, axes: tuple[Any, Any, Any], title: str, curves: dict[PathKind, Drawn]) -> None:
    chart, bends, speeds = axes
    figure.suptitle(title)
    chart.set(xlabel="east of home, m", ylabel="north of home, m")
    chart.set_aspect("equal", adjustable="datalim")
    chart.legend(loc="best", fontsize="small")
    values = sorted(abs(value) for drawn in curves.values() for value in drawn.curvature[1])
    if values:
        limit = max(
            1e-3, 1.3 * values[int(0.97 * (len(values) - 1))]
        )  # the peaks of sharp turns would flatten the rest
        bends.set_ylim(-limit, limit)
    bends.set(xlabel="along the path, m", ylabel="curvature, 1/m (to starboard +)")
    speeds.set(xlabel="along the track, m", ylabel="speed, m/s", ylim=(0.0, None))
    for axis in axes:
        axis.grid(alpha=0.3)


def _draw_places(chart: Any, plan: PlanFile, frame: LocalFrame) -> None:
    for outline, inclusion in fence_zones(plan.fence, frame):
        colour = "tab:olive" if inclusion else "tab:red"
        chart.fill(
            *outline, facecolor="none" if inclusion else colour, edgecolor=colour,
            alpha=1.0 if inclusion else 0.35, linewidth=1.5, label="stay inside" if inclusion else "keep out",
        )  # fmt: skip
    places = [item for item in plan.mission if item.command in PLACES]
    points = [frame.to_ned(item.lat_deg, item.lon_deg) for item in places]
    chart.plot([p[1] for p in points], [p[0] for p in points], "ko", markersize=4 if len(points) <= 100 else 2)
    every = math.ceil(len(points) / _MOST_LABELS)
    for item, (north_m, east_m) in list(zip(places, points, strict=True))[::every]:
        chart.annotate(
            str(item.number), (east_m, north_m), textcoords="offset points", xytext=(4, 4), fontsize="x-small"
        )
    for item in plan.rally:
        north_m, east_m = frame.to_ned(item.lat_deg, item.lon_deg)
        chart.plot(east_m, north_m, "m^", markersize=8)
        chart.annotate(
            "rally", (east_m, north_m), textcoords="offset points", xytext=(5, -8), fontsize="x-small", color="m"
        )
    if plan.home is not None:
        north_m, east_m = frame.to_ned(*plan.home[:2])
        chart.plot(east_m, north_m, "k*", markersize=12)
        chart.annotate("home", (east_m, north_m), textcoords="offset points", xytext=(6, -10), fontsize="x-small")


def fence_zones(fence: Sequence[PlanItem], frame: LocalFrame) -> Iterator[tuple[Line, bool]]:
    """Outline (east, north) of each zone, and whether to stay inside it."""
    at = 0
    while at < len(fence):
        item = fence[at]
        count = 1
        if item.command in POLYGONS:
            count = max(1, int(item.param1))
            corners = [frame.to_ned(vertex.lat_deg, vertex.lon_deg) for vertex in fence[at : at + count]]
            yield ([c[1] for c in corners], [c[0] for c in corners]), item.command == Command.FENCE_POLYGON_INCLUSION
        elif item.command in CIRCLES and not is_no_circle(item):
            north_m, east_m = frame.to_ned(item.lat_deg, item.lon_deg)
            around = [math.tau * k / 72 for k in range(72)]
            ring = (
                [east_m + item.param1 * math.sin(a) for a in around],
                [north_m + item.param1 * math.cos(a) for a in around],
            )
            yield ring, item.command == Command.FENCE_CIRCLE_INCLUSION
        at += count
