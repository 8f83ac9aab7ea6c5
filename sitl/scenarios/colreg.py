"""Another vessel on a collision course, which never gives way and is seen by its AIS alone.

The boat keeps clear as the collision regulations ask, and returns to its route. Metrics come from the truth, with the
hulls as rectangles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from sitl.noise import stream
from sitl.scenarios.figure import legend, mark_times, new_figure, set_title
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, Track, between, read_events, read_truth, receiver_error_m
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number
from sitl.traffic import ScriptedVessel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MISSION = 0x04040000
_MEETING_M, _ONWARD_M = 150.0, 180.0  # way to the meeting, and from there to the end of the route
_MEETING_S, _ONWARD_S = 80.0, 80.0  # the least time for each: a fast boat sails a longer route
_AS_FAST_MPS = 2.0  # a faster boat meets vessels that are faster by as much
_RADIUS_M = 3.0
_LAST_M = 20.0  # of the route, on which the boat is to be back
_BACK_M = 1.25  # to the route, beside the slow error of the receiver
_TIMEOUT_S = 700.0
_START_S = 8.0  # time that the boat loses while it gains speed
_STAND_S = 45.0  # default of CA_STAND_T
_SITUATIONS: dict[str, tuple[float, float, float, str]] = {  # course relative to the boat's, its spread, speed, event
    "head_on": (180.0, 5.0, 1.5, "traffic_head_on"),
    "crossing_starboard": (-90.0, 20.0, 1.5, "traffic_crossing_starboard"),
    "crossing_port": (90.0, 20.0, 1.5, "traffic_crossing_port"),
    "overtaking": (0.0, 5.0, 0.5, "traffic_overtaking"),
    "overtaken": (0.0, 5.0, 2.4, "traffic_overtaken"),
    "standing": (0.0, 180.0, 0.0, "traffic_standing"),
}


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail a mission of one leg to the north, towards a meeting half-way."""
    situation = settings["situation"]
    if situation not in _SITUATIONS:
        raise ScenarioError(f"situation={situation}: one of {', '.join(_SITUATIONS)}")
    home = LocalFrame(gcs.rig.config.home.lat_deg, gcs.rig.config.home.lon_deg)
    gcs.ready()
    speed_mps = number(settings, "speed") or gcs.parameter("WP_SPEED")
    meeting_m = max(_MEETING_M, _MEETING_S * speed_mps)
    route_m = meeting_m + (number(settings, "onward") or max(_ONWARD_M, _ONWARD_S * speed_mps))
    point = home.to_geodetic(route_m, 0.0)
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *point, params=(0.0, _RADIUS_M, 0.0, math.nan))])
    gcs.set_mode(_MISSION)
    gcs.arm()
    started_s = gcs.rig.now_s
    meeting_s = started_s + _START_S + meeting_m / speed_mps
    vessel = _other(gcs, situation, (started_s, meeting_s), meeting_m, max(1.0, speed_mps / _AS_FAST_MPS))
    gcs.rig.world.traffic.vessels.append(vessel)
    gcs.wait("the end of the route", lambda: 0 in gcs.reached, _TIMEOUT_S)
    return {
        "vessel": vessel,
        "situation": situation,
        "started_s": started_s,
        "meeting_s": meeting_s,
        "finished_s": gcs.rig.now_s,
        "length_m": gcs.rig.config.length_m,
        "beam_m": gcs.rig.config.beam_m,
        "route_m": route_m,
    }


def _other(
    gcs: GroundStation, situation: str, times_s: tuple[float, float], meeting_m: float, faster: float
) -> ScriptedVessel:
    """The vessel that meets the boat half-way, a little earlier or later by the seed. `times_s`: now, and of the
    meeting; `faster`: times the speed of its situation."""
    now_s, meeting_s = times_s
    draws = stream(gcs.rig.world.seed, "traffic")
    course_deg, spread_deg, other_mps, _ = _SITUATIONS[situation]
    course = math.radians(course_deg + draws.uniform(-spread_deg, spread_deg))
    other_mps *= faster * draws.uniform(0.85, 1.15)
    late_s = draws.uniform(-2.0, 2.0)
    north_mps, east_mps = other_mps * math.cos(course), other_mps * math.sin(course)
    points = tuple(
        (t_s, meeting_m + north_mps * (t_s - meeting_s - late_s), east_mps * (t_s - meeting_s - late_s))
        for t_s in (now_s, now_s + _TIMEOUT_S)
    )
    return ScriptedVessel(230_000_000 + draws.randrange(1_000_000), "NORA", points, class_a=draws.random() < 0.5)


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Clear water, passing side, and deviations from the route."""
    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    vessel: ScriptedVessel = asked["vessel"]
    situation: str = asked["situation"]
    clear = [_between_hulls(row, vessel, asked) for row in track]
    nearest = track[min(range(len(track)), key=lambda i: clear[i])]
    early = between(track, asked["started_s"], asked["meeting_s"] - _STAND_S - 15.0)
    last = [row for row in track if row["north_m"] > asked["route_m"] - _LAST_M] or track[-1:]
    named = [event for event in read_events(folder) if event.name == _SITUATIONS[situation][3]]
    metrics = {
        "clear_water_m": min(clear),
        "bearing_at_closest_deg": _bearing_deg(nearest, vessel),
        "most_to_starboard_m": max(row["east_m"] for row in track),
        "most_to_port_m": -min(row["east_m"] for row in track),
        "ahead_at_crossing_m": _ahead_at_crossing(track, vessel),
        "off_route_before_last_moment_m": max((abs(row["east_m"]) for row in early), default=0.0),
        "off_route_at_end_m": max(abs(row["east_m"]) for row in last),
        "said": float(len(named)),
        "time_s": asked["finished_s"] - asked["started_s"],
    }
    back_m = _BACK_M + receiver_error_m(settings["gnss"])
    checks = [
        Check("clear water between the hulls", metrics["clear_water_m"], 10.0, "m", at_least=True),
        Check("back on the route at its end", metrics["off_route_at_end_m"], back_m, "m"),
        Check("announcements that name the situation", metrics["said"], 1.0, "", at_least=True),
    ]
    if situation == "head_on":
        checks.append(
            Check(
                "port to port: bearing of the other when it is closest", metrics["bearing_at_closest_deg"], -30.0, "deg"
            )
        )
    if situation == "crossing_starboard":
        checks.append(
            Check("not ahead of the other when its track is crossed", metrics["ahead_at_crossing_m"], 0.0, "m")
        )
    if situation == "crossing_port":
        checks.append(Check("no turn to port", metrics["most_to_port_m"], 3.0, "m"))
    if situation in ("crossing_port", "overtaken"):
        checks.append(Check("course kept until the last moment", metrics["off_route_before_last_moment_m"], 2.5, "m"))
    return metrics, checks


def _between_hulls(row: dict[str, float], vessel: ScriptedVessel, asked: dict[str, Any]) -> float:
    """Distance between the hulls at one row of the truth, in metres."""
    from shapely import Polygon

    there = vessel.at(row["t_s"])
    ours = _corners(row["north_m"], row["east_m"], row["yaw_rad"], asked["length_m"], asked["beam_m"])
    return float(
        Polygon(ours).distance(
            Polygon(_corners(there.north_m, there.east_m, there.course_rad, vessel.length_m, vessel.beam_m))
        )
    )


def _corners(
    north_m: float, east_m: float, yaw_rad: float, length_m: float, beam_m: float
) -> list[tuple[float, float]]:
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    around = ((0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5))
    return [
        (north_m + c * a * length_m - s * b * beam_m, east_m + s * a * length_m + c * b * beam_m) for a, b in around
    ]


def _bearing_deg(row: dict[str, float], vessel: ScriptedVessel) -> float:
    """Bearing of the other vessel from the boat's bow."""
    there = vessel.at(row["t_s"])
    return math.degrees(
        wrap_pi(math.atan2(there.east_m - row["east_m"], there.north_m - row["north_m"]) - row["yaw_rad"])
    )


def _ahead_at_crossing(track: Track, vessel: ScriptedVessel) -> float:
    """The largest distance by which the boat is ahead of the other vessel while it crosses its track; −∞ if it never
    crosses."""
    most, before = -math.inf, 0.0
    for row in track:
        there = vessel.at(row["t_s"])
        c, s = math.cos(there.course_rad), math.sin(there.course_rad)
        north, east = row["north_m"] - there.north_m, row["east_m"] - there.east_m
        across = c * east - s * north
        if across * before < 0.0:
            most = max(most, c * north + s * east)
        before = across
    return most


def plot(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `colreg.png` into the folder. Raises ImportError without matplotlib."""
    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    figure = new_figure(12.0, 7.0)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.4))
    _chart(figure.add_subplot(grid[:, 0]), track, asked)
    gaps, speeds, headings = (figure.add_subplot(grid[row, 1]) for row in range(3))
    times = [row["t_s"] - asked["started_s"] for row in track]
    gaps.plot(times, [_between_hulls(row, asked["vessel"], asked) for row in track])
    gaps.axhline(10.0, color="tab:red", label="to keep")
    gaps.set_ylabel("between the hulls, m")
    gaps.set_ylim(0.0, 150.0)
    speeds.plot(times, [row["surge_mps"] for row in track])
    speeds.set_ylabel("surge, m/s")
    headings.plot(times, [math.degrees(row["yaw_rad"]) for row in track])
    headings.set_ylabel("heading, °")
    headings.set_xlabel("time, s")
    legend(gaps)
    for axes in (gaps, speeds, headings):
        axes.grid(alpha=0.3)
    said = [event for event in read_events(folder) if event.name.startswith("traffic")]
    mark_times(figure, (gaps, speeds, headings), [(event.t_s - asked["started_s"], event.text) for event in said])
    set_title(figure, settings)
    figure.savefig(folder / "colreg.png", dpi=90)


def _chart(axes: Axes, track: Track, asked: dict[str, Any]) -> None:
    vessel: ScriptedVessel = asked["vessel"]
    axes.plot([0.0, 0.0], [0.0, asked["route_m"]], color="grey", linestyle=":", label="route")
    axes.plot([row["east_m"] for row in track], [row["north_m"] for row in track], label="boat")
    other = [vessel.at(row["t_s"]) for row in track]
    axes.plot([m.east_m for m in other], [m.north_m for m in other], color="tab:red", label="other vessel")
    for row in track[:: max(1, round(20.0 * len(track) / (track[-1]["t_s"] - track[0]["t_s"])))]:
        there = vessel.at(row["t_s"])
        ours = _corners(row["north_m"], row["east_m"], row["yaw_rad"], asked["length_m"], asked["beam_m"])
        theirs = _corners(there.north_m, there.east_m, there.course_rad, vessel.length_m, vessel.beam_m)
        axes.fill([e for _, e in ours], [n for n, _ in ours], color="tab:blue")
        axes.fill([e for _, e in theirs], [n for n, _ in theirs], color="tab:red")
        axes.plot([row["east_m"], there.east_m], [row["north_m"], there.north_m], color="grey", linewidth=0.3)
    axes.set_xlim(-120.0, 120.0)
    axes.set_ylim(-20.0, asked["route_m"] + 10.0)
    axes.set_aspect("equal")
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    axes.grid(alpha=0.3)
    legend(axes)


SCENARIO = Scenario(
    name="colreg",
    text="another vessel on a collision course never gives way: the boat keeps clear by the rules and returns",
    vessel="aboat",
    defaults={
        "situation": "head_on",
        "action": "alter",
        "wind": "2",
        "current": "",
        "gnss": "sbas",
        "waves": "",
        "speed": "",
        "onward": "",
    },
    by_vessel={"rescuerunner": {"gnss": "standalone"}},
    sail=sail,
    measure=measure,
    plot=plot,
)
