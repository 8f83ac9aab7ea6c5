"""Station keeping in gusts and a current; and with a thruster that fails and recovers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.config.dimensions.limits import largest
from companion.core.angles import wrap_pi
from sitl.faults import known
from sitl.scenarios import positioning_plot
from sitl.scenarios.boat import heading_error_deg, sideways
from sitl.scenarios.four_corner import SETTLE_S, thrusters_of
from sitl.scenarios.ground_station import BACK_S, GroundStation
from sitl.scenarios.measure import Check, between, distance_to, read_events, receiver_error_m, rms
from sitl.scenarios.positioning import figures, read
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

_DIES_S, _DEAD_S, _RECOVERY_S = 60.0, 120.0, 60.0
_LEAST_SHARE = 0.05  # of the limit of a sound boat: less force counts as none
_HEADING_DEG, _RECOVERED_DEG = 1.0, 1.5  # beside the slow error of the compass


def _asked(gcs: GroundStation, from_s: float, **more: float | bool) -> dict[str, Any]:
    config = gcs.rig.config
    return {
        "from_s": from_s, "to_s": gcs.rig.now_s, "yaw_rad": config.home.yaw_rad, "thrusters": thrusters_of(config),
        "corners": [(0.0, 0.0, config.home.yaw_rad)], "vessel": config.name, "length_m": config.length_m,
        "beam_m": config.beam_m, "heading_error_deg": heading_error_deg(config, gcs.rig.conditions), **more,
    }  # fmt: skip


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold at home. A command sets the point, so that the metrics include errors of the estimate."""
    gcs.hold_at_home(SETTLE_S, BACK_S)
    from_s = gcs.rig.now_s
    gcs.sail(number(settings, "time"))
    return _asked(gcs, from_s)


def sail_with_failure(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold at home; a thruster fails after one minute for two: the first one is dead, unless `thruster` and `failure`
    differ."""
    config = gcs.rig.config
    name = settings["thruster"] or config.thrusters[0].name
    fault = f"thruster_{name}_{settings['failure']}"
    if fault not in known(config):
        names = ", ".join(
            name.removeprefix("thruster_") for name in sorted(known(config)) if name.startswith("thruster_")
        )
        raise ScenarioError(
            f"thruster={settings['thruster']} failure={settings['failure']}: no such fault; there is {names}"
        )
    gcs.hold_at_home(SETTLE_S, BACK_S)
    from_s = gcs.rig.now_s
    gcs.sail(_DIES_S)
    gcs.rig.world.add_fault(fault, _DEAD_S)
    gcs.sail(_DEAD_S + _RECOVERY_S + _DIES_S)
    recovered_s = from_s + _DIES_S + _DEAD_S + _RECOVERY_S
    left = [thruster for thruster in config.thrusters if thruster.name != name]
    return _asked(
        gcs,
        from_s,
        recovered_s=recovered_s,
        alarm_m=gcs.parameter("DP_ALARM_R"),
        holds_sideways=largest(left, 1) > _LEAST_SHARE * config.limits.sway_n,
        goes_ahead=largest(left, 0, free=(1,)) > _LEAST_SHARE * config.limits.surge_n,
    )


def _off(folder: Path, asked: dict[str, Any], from_s: float) -> dict[str, float]:
    """Position and heading errors from what the command asked for, and the thesis's figures."""
    sailed = read(folder, asked["from_s"], asked["to_s"])
    track = between(sailed.truth, from_s, asked["to_s"])
    distances = [distance_to(row, 0.0, 0.0) for row in track]
    headings = [math.degrees(wrap_pi(row["yaw_rad"] - asked["yaw_rad"])) for row in track]
    common = {
        key: value
        for key, value in figures(sailed, asked["thrusters"]).items()
        if key in ("iae", "iadc", "energy_full_power_s")
    }
    return {
        "position_rms_m": rms(distances),
        "position_max_m": max(distances),
        "heading_rms_deg": rms(headings),
        "heading_max_deg": max(map(abs, headings)),
        **common,
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Position and heading errors of the whole time."""
    metrics = _off(folder, asked, asked["from_s"])
    limit_m = 0.05 + receiver_error_m(settings["gnss"])
    return metrics, (
        Check("position RMS", metrics["position_rms_m"], limit_m, "m"),
        Check("heading RMS", metrics["heading_rms_deg"], _HEADING_DEG + asked["heading_error_deg"], "deg"),
    )


def measure_with_failure(
    folder: Path, asked: dict[str, Any], settings: Settings
) -> tuple[dict[str, float], Sequence[Check]]:
    """Errors of the whole time, and those after the recovery. A boat whose remaining thrusters cannot push it sideways
    without turning it turns its bow to the weather, inside its alarm circle, and takes its heading back. One without a
    thruster to go ahead says so, and drifts."""
    metrics = _off(folder, asked, asked["from_s"])
    after = _off(folder, asked, asked["recovered_s"])
    metrics["recovered_rms_m"] = after["position_rms_m"]
    metrics["recovered_heading_rms_deg"] = after["heading_rms_deg"]
    slow_m = receiver_error_m(settings["gnss"])
    most_deg = _RECOVERED_DEG + asked["heading_error_deg"]
    most_m = 1.0 + slow_m if asked["holds_sideways"] else asked["alarm_m"]
    if asked["goes_ahead"]:
        failed = Check("largest distance, one thruster failed for 120 s", metrics["position_max_m"], most_m, "m")
    else:
        said = float(any(event.name == "thrust_lost" for event in read_events(folder)))
        failed = Check("said that no thruster is left that goes ahead", said, 1.0, "", at_least=True)
    return metrics, (
        failed,
        Check("position RMS a minute after its return", metrics["recovered_rms_m"], 0.1 + slow_m, "m"),
        Check("heading RMS a minute after its return", metrics["recovered_heading_rms_deg"], most_deg, "deg"),
    )


_DEFAULTS = {
    "law": "companion", "feedforward": "", "allocation": "constrained", "bow": "fixed", "wind": "3",
    "current": "0.1", "push": "", "gnss": "rtk", "waves": "", "model_error": "", "windage_error": "", "plant": "",
}  # fmt: skip

SCENARIO = Scenario(
    name="station_keeping",
    text="station keeping with heading, in gusts and a current",
    vessel="revolt",
    defaults={**_DEFAULTS, "time": "600"},
    by_vessel={"cybership2": {"gnss": "basin", "wind": "", "current": "", "push": "1.5@0", "feedforward": "on"}},
    needs=(sideways,),
    sail=sail,
    measure=measure,
    plot=positioning_plot.draw,
    lasts_s=630.0,
)
THRUSTER_FAILURE = Scenario(
    name="thruster_failure",
    text="station keeping while one thruster has failed for two minutes",
    vessel="revolt",
    defaults={**_DEFAULTS, "thruster": "", "failure": "dead"},
    needs=(sideways,),
    sail=sail_with_failure,
    measure=measure_with_failure,
    plot=positioning_plot.draw,
)
