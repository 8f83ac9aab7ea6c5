"""The routes of the ÅBOAT thesis in wind and current: every waypoint reached, no circling, near the path."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios import route_plot
from sitl.scenarios.boat import motor
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, Point, between, closest, read_truth, receiver_error_m, rms
from sitl.scenarios.rig import Conditions
from sitl.scenarios.route_measure import follow, line, most_turn_rad, percentile, reached_rows
from sitl.scenarios.routes import ROUTES, transects
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings

RADIUS_M = 5.0  # as in the thesis; a boat whose own radius is larger turns there
_MISSION = 0x04040000
_SLOWEST_MPS = 0.4  # mean over the whole route; a slower boat circles or is stuck
_GAINS = ("WPT_KP_YAW", "WPT_KI_YAW", "WPT_KD_YAW")
_TURN_M = 15.0  # at each end of a survey's line, where the boat turns
# cross-track error RMS and 95 %
_LIMITS_M = {"rtk": (0.5, 1.0), "sbas": (1.0, 1.8), "standalone": (4.0, 8.0)}


def path_of(settings: Settings) -> str:
    """The curve of the setting `path`; where it is empty, the one that the thesis used on that route."""
    return settings["path"] or (ROUTES[settings["route"]].path if settings.get("route") in ROUTES else "linear")


def _sail(gcs: GroundStation, waypoints: Sequence[Point]) -> dict[str, Any]:
    """Upload, arm, and sail until the last waypoint is announced or the time is over."""
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    items = [
        Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*point), params=(0.0, 0.0, 0.0, math.nan))
        for point in waypoints
    ]
    gcs.ready()
    gcs.upload(items)
    truth = gcs.rig.world.truth
    begin = (truth.north_m, truth.east_m)
    gcs.set_mode(_MISSION)
    gcs.arm()
    started_s = gcs.rig.now_s
    length_m = sum(math.dist(a, b) for a, b in zip([begin, *waypoints], waypoints, strict=False))
    end_s = started_s + 60.0 + length_m / _SLOWEST_MPS
    while len(items) - 1 not in gcs.reached and gcs.rig.now_s < end_s:
        gcs.step()
    return {
        "waypoints": [begin, *waypoints],
        "started_s": started_s,
        "finished_s": gcs.rig.now_s,
        "announced": len(set(gcs.reached)),
        "vessel": gcs.rig.config.name,
        "config": gcs.rig.config,
        "radius_m": _radius_m(gcs),
    }


def _radius_m(gcs: GroundStation) -> float:
    """How near a waypoint must be passed: where a boat turns earlier, by its own radius, as its receiver knows it."""
    own_m = gcs.rig.config.parameters.get("NAV_ACC_RAD", 0.0)
    return max(RADIUS_M, own_m + receiver_error_m(gcs.rig.conditions.gnss) if own_m > RADIUS_M else 0.0)


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail one of the thesis's routes."""
    if settings["route"] not in ROUTES:
        raise ScenarioError(f"route={settings['route']}: one of {', '.join(ROUTES)}")
    return _sail(gcs, ROUTES[settings["route"]].points)


def sail_survey(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail a survey's lines."""
    try:
        count = int(settings["transects"])
    except ValueError as error:
        raise ScenarioError(f"transects={settings['transects']}: not a whole number") from error
    if not 1 <= count <= 100:
        raise ScenarioError(f"transects={count}: must be 1 to 100")
    return _sail(gcs, transects(count, 100.0, 12.0))


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Cross-track errors and turns over the whole route."""
    metrics = _figures(folder, asked, path_of(settings))
    return metrics, _checks(metrics, asked, settings)


def _figures(folder: Path, asked: dict[str, Any], kind: str) -> dict[str, float]:
    """The metrics of a route along the curve of that kind."""
    from sitl.evaluate.figures import regular, route_metrics, thrust  # which imports the scenarios

    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    waypoints = asked["waypoints"]
    path = line(waypoints, kind)
    sailed = follow(track, path)
    rows = reached_rows(track, waypoints[1:], asked["radius_m"])
    errors = [abs(error) for error in sailed.error_m]
    done = len(rows) == len(waypoints) - 1 and asked["announced"] == len(waypoints) - 1
    power, variation = thrust(regular(track), asked["config"])
    return {
        "waypoints_reached": float(min(len(rows), asked["announced"])),
        "completed": float(done),
        "cross_track_rms_m": rms(errors),
        "cross_track_95_m": percentile(errors, 0.95),
        "cross_track_max_m": max(errors),
        "most_turn_deg": math.degrees(most_turn_rad(sailed, path, rows)),
        "turned_deg": math.degrees(sum(abs(b - a) for a, b in itertools.pairwise(sailed.yaw_rad))),
        "time_s": asked["finished_s"] - asked["started_s"],
        "miss_max_m": max((closest(track, point) for point in waypoints[1:-1]), default=0.0),
        "power_percent": power.value,
        "variation_percent_ps": variation.value,
        **(route_metrics(track, asked["config"], waypoints) if kind == "linear" else {}),
    }


def measure_survey(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Cross-track errors on the lines alone, without their ends."""
    metrics = _figures(folder, asked, "linear")
    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    path = line(asked["waypoints"], "linear")
    sailed = follow(track, path)
    lines = list(zip(path.waypoint_s_m[1::2], path.waypoint_s_m[2::2], strict=True))
    errors = [
        abs(error)
        for error, s in zip(sailed.error_m, sailed.s_m, strict=True)
        if any(begin + _TURN_M <= s <= end - _TURN_M for begin, end in lines)
    ]
    metrics |= {
        "cross_track_rms_m": rms(errors),
        "cross_track_95_m": percentile(errors, 0.95),
        "cross_track_max_m": max(errors),
    }
    return metrics, _checks(metrics, asked, settings)


def _checks(metrics: dict[str, float], asked: dict[str, Any], settings: Settings) -> list[Check]:
    """What must hold. The thesis's law is for comparison, so only its first waypoint counts."""
    if settings["law"] == "thesis":
        return [Check("a waypoint was reached", metrics["waypoints_reached"], 1.0, "", at_least=True)]
    rms_m, most_m = _LIMITS_M.get(settings["gnss"], (0.5, 1.0))
    return [
        Check(
            "waypoints reached and announced",
            metrics["waypoints_reached"],
            float(len(asked["waypoints"]) - 1),
            "",
            at_least=True,
        ),
        Check("turn between two waypoints beyond the path's", metrics["most_turn_deg"], 359.0, "deg"),
        Check("cross-track error RMS", metrics["cross_track_rms_m"], rms_m, "m"),
        Check("cross-track error, 95 %", metrics["cross_track_95_m"], most_m, "m"),
    ]


_DEFAULTS = {
    "law": "companion", "control": "pid", "path": "", "wind": "6", "current": "0.3", "gnss": "rtk", "waves": "",
    "model_error": "", "plant": "", "gains": "", "magnetometer": "", "ahrs": "companion",
}  # fmt: skip


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The thesis's boat doubted no sensor and no thruster; the setting `gains=KP/KI/KD` is for its heading. Raises
    ScenarioError."""
    text = settings["gains"]
    if settings["law"] != "thesis":
        if text:
            raise ScenarioError(f"gains={text}: only with law=thesis")
        return conditions
    own = {"NAV_INTEG": 0.0, "THR_WATCH": 0.0}
    if text:
        try:
            own |= dict(zip(_GAINS, map(float, text.split("/")), strict=True))
        except ValueError as error:
            raise ScenarioError(f"gains={text}: write KP/KI/KD, as 350/40/430") from error
    return replace(conditions, parameters={**conditions.parameters, **own})


SCENARIO = Scenario(
    name="route",
    text="a route of the ÅBOAT thesis in wind and current: all waypoints, no circling, near the path",
    vessel="aboat",
    defaults={"route": "3", **_DEFAULTS},
    needs=(motor,),
    sail=sail,
    measure=measure,
    prepare=prepare,
    plot=lambda folder, asked, settings: route_plot.draw(folder, asked, path_of(settings), dict(settings)),
)

SURVEY = Scenario(
    name="survey",
    text="straight survey lines of 100 m, 12 m apart, in wind and current",
    vessel="aboat",
    defaults={"transects": "20", **_DEFAULTS},
    needs=(motor,),
    sail=sail_survey,
    measure=measure_survey,
    prepare=prepare,
    plot=lambda folder, asked, settings: route_plot.draw(folder, asked, "linear", dict(settings)),
    lasts_s=2200.0,
)
