"""The 4-corner box of dynamic positioning (ReVolt thesis 9.1).

Each degree of freedom moves alone, then all together, and back to the start.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.config.vessel import VesselConfig
from companion.core.geodesy import LocalFrame
from sitl.scenarios import positioning_plot
from sitl.scenarios.boat import heading_error_deg, sideways
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, receiver_error_m
from sitl.scenarios.positioning import PositioningLog, ThrusterFigures, errors, figures, read
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings

SETTLE_S = 30.0
_TURN_LEG, _COUPLED_LEG = 2, 3
# poses after each move, in sides of the box and degrees of heading
_CORNERS = ((1.0, 0.0, 0.0), (1.0, -1.0, 0.0), (1.0, -1.0, -45.0), (0.0, -1.0, -45.0), (0.0, 0.0, 0.0))


def thrusters_of(config: VesselConfig) -> list[ThrusterFigures]:
    """What the figures need of the vessel's thrusters."""
    return [ThrusterFigures(t.name, max(t.max_n, -t.min_n), t.x_m, t.y_m) for t in config.thrusters]


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Go to each corner at a fixed time, so that all runs are equally long."""
    config = gcs.rig.config
    side_m, leg_s = _positive(settings, "box"), _positive(settings, "leg")
    frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
    gcs.hold_at_home(SETTLE_S)
    from_s = gcs.rig.now_s
    corners = [(north * side_m, east * side_m, math.radians(heading)) for north, east, heading in _CORNERS]
    for north_m, east_m, yaw_rad in corners:
        gcs.reposition(*frame.to_geodetic(north_m, east_m), yaw_rad)
        gcs.sail(leg_s)
    return {
        "from_s": from_s,
        "to_s": gcs.rig.now_s,
        "leg_s": leg_s,
        "thrusters": thrusters_of(config),
        "corners": corners,
        "vessel": config.name,
        "length_m": config.length_m,
        "beam_m": config.beam_m,
        "heading_error_deg": heading_error_deg(config, gcs.rig.conditions),
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """The thesis's figures, the legs in which the errors were largest, and the distance from the start at the end."""
    sailed = read(folder, asked["from_s"], asked["to_s"])
    metrics = figures(sailed, asked["thrusters"]) | by_leg(sailed, asked["from_s"], asked["leg_s"])
    metrics["thrust_share_max"] = max(
        abs(row[f"{thruster.name}_throttle"]) for row in sailed.ticks for thruster in asked["thrusters"]
    )
    last_north, last_east, _ = asked["corners"][-1]
    end = sailed.truth[-1]
    metrics["end_off_m"] = math.hypot(end["north_m"] - last_north, end["east_m"] - last_east)
    return metrics, _checks(metrics, asked["vessel"], settings, asked["heading_error_deg"])


def by_leg(sailed: PositioningLog, from_s: float, leg_s: float) -> dict[str, float]:
    """The leg, from 1, with the largest error of each kind; the largest errors in the fourth, point 4 to 5 of the
    thesis, astern and to port at once; and the pivot point of the turn on the spot in the third, in m ahead of the
    centre of gravity (-v/r by least squares)."""
    legs: list[list[tuple[float, float, float]]] = [[] for _ in _CORNERS]
    turn_vr = turn_rr = 0.0
    for truth, tick, error in zip(sailed.truth, sailed.ticks, errors(sailed), strict=True):
        leg = min(int((tick["t_s"] - from_s) / leg_s), len(legs) - 1)
        legs[leg].append(error)
        if leg == _TURN_LEG:
            turn_vr += truth["sway_mps"] * truth["yaw_rate_radps"]
            turn_rr += truth["yaw_rate_radps"] ** 2
    found: dict[str, float] = {"pivot_m": -turn_vr / turn_rr if turn_rr else math.nan}
    for axis, name in enumerate(("north", "east", "heading")):
        most = [max((abs(error[axis]) for error in leg), default=0.0) for leg in legs]
        found[f"{name}_worst_leg"] = float(1 + most.index(max(most)))
        found[f"{name}_leg4_{'deg' if name == 'heading' else 'm'}"] = (
            math.degrees(most[_COUPLED_LEG]) if name == "heading" else most[_COUPLED_LEG]
        )
    return found


def _checks(metrics: dict[str, float], vessel: str, settings: Settings, compass_deg: float) -> list[Check]:
    """What must hold, beside the slow errors of receiver and compass. With the thesis's law on ReVolt only the arrival
    counts; the rest is for comparison."""
    slow_m = receiver_error_m(settings["gnss"])
    arrived = Check("back at the start", metrics["end_off_m"], 0.5 + slow_m, "m")
    thesis = settings["law"] == "thesis"
    if thesis and vessel != "cybership2":
        return [arrived]
    north_m, east_m, heading_deg = (0.05, 0.10, 1.0) if vessel == "cybership2" else (0.15, 0.20, 3.0)
    if vessel != "cybership2" and abs(float(settings["model_error"] or 0.0)) > 0.2 + 1e-9:
        north_m, east_m, heading_deg = 0.3, 0.3, 5.0
    checks = [
        arrived,
        Check("largest north error", metrics["north_max_m"], north_m + slow_m, "m"),
        Check("largest east error", metrics["east_max_m"], east_m + slow_m, "m"),
        Check("largest heading error", metrics["heading_max_deg"], heading_deg + compass_deg, "deg"),
    ]
    still = not (settings["wind"] or settings["current"])
    if vessel == "cybership2" and not thesis and still:  # a stream's share of the heading error adds up all the time
        checks.append(Check("IAE", metrics["iae"], 0.5, ""))
    return checks


def _positive(settings: Settings, key: str) -> float:
    try:
        value = float(settings[key])
    except ValueError as error:
        raise ScenarioError(f"{key}={settings[key]}: not a number") from error
    if not 0.0 < value < 1000.0:
        raise ScenarioError(f"{key}={settings[key]}: must be above 0 and below 1000")
    return value


SCENARIO = Scenario(
    name="four_corner",
    text="the thesis's 4-corner box of dynamic positioning, with its IAE and IADC",
    vessel="revolt",
    defaults={
        "law": "companion", "feedforward": "", "allocation": "constrained", "bow": "fixed", "box": "5", "leg": "60",
        "wind": "2", "current": "", "push": "", "gnss": "rtk", "waves": "", "model_error": "", "plant": "",
    },
    by_vessel={
        "cybership2": {"box": "2", "leg": "45", "gnss": "basin", "wind": "", "push": "1.5@0", "feedforward": "on"}
    },
    needs=(sideways,),
    sail=sail,
    measure=measure,
    plot=positioning_plot.draw,
)  # fmt: skip
