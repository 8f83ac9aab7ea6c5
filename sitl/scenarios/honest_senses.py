"""Honest sensors on a bad day: none of them may be found to lie.

Drawn by the seed: holding, going from point to point or sailing a mission; wind with gusts, current, a sea or a swell,
the grade of the receiver, a wrong model of the hull; and RTK lost and regained, receivers and inertial sensors silent
for a while, outliers.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.lying_senses import found_s
from sitl.scenarios.measure import Check
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, Settings, number

_HOLD, _MISSION = 0x03040000, 0x04040000
_FIRST_FAULT_S = 90.0


@dataclass(frozen=True, slots=True)
class _Day:
    """What a vessel meets at most: wind and current in m/s, and how far it goes, in m."""

    wind_mps: float
    current_mps: float
    reach_m: float
    gnss: tuple[str, ...] = ("rtk", "rtk", "sbas", "standalone")


_DAYS = {
    "revolt": _Day(5.0, 0.3, 20.0),
    "cybership2": _Day(0.0, 0.0, 5.0, ("basin",)),
    "aboat": _Day(7.0, 0.3, 80.0),
    "rescuerunner": _Day(8.0, 1.0, 400.0),
}
_GUSTS = ("", "", "/davenport", "/npd")  # of a spectrum; the first ones: of 15 % and 10 s
_PERIODS = (2.8, 8.0)  # of the sea's peak over √height, s/√m: the shortest do not yet break
_ANY_DAY = _Day(3.0, 0.2, 50.0)


def _random(seed: int, what: str) -> random.Random:
    return random.Random(f"{seed}/honest {what}")


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The day of this seed."""
    draw, day = _random(conditions.seed, "day"), _DAYS.get(conditions.vessel, _ANY_DAY)
    weather = _random(conditions.seed, "weather")
    basin = day.wind_mps == 0.0
    return replace(
        conditions,
        wind=None if basin else f"{draw.uniform(0.0, day.wind_mps):.1f}" + weather.choice(_GUSTS),
        current=None if basin or draw.random() < 0.4 else f"{draw.uniform(0.0, day.current_mps):.2f}",
        waves=None if basin or draw.random() < 0.5 else _sea(draw.uniform(0.02, 0.4), weather),
        gnss=draw.choice(day.gnss),
        model_error=0.0 if draw.random() < 0.3 else round(draw.uniform(-0.3, 0.3), 2),
        faults=tuple(_faults(draw, number(settings, "duration"), conditions.vessel)),
    )


def _sea(height_m: float, weather: random.Random) -> str:
    """Waves of that height: as the wind raises them, or of any direction and from steep seas to swell."""
    if weather.random() < 0.5:
        return f"{height_m:.2f}"
    from_deg, period_s = weather.uniform(0.0, 360.0), weather.uniform(*_PERIODS) * math.sqrt(height_m)
    return f"{height_m:.2f}@{from_deg:.0f}/{period_s:.2f}"


def _faults(draw: random.Random, duration_s: float, vessel: str) -> list[str]:
    """Honest troubles: what is lost says that it is."""
    faults = []
    at_s = _FIRST_FAULT_S
    while at_s < duration_s - 30.0 and draw.random() < 0.8:
        at_s += draw.uniform(10.0, 90.0)
        name, longest_s = draw.choice(
            (
                ("rtk_lost", 60.0), ("rtk_lost", 20.0), ("gnss_lost", 4.5), ("gnss_lost", 40.0), ("gnss_wild", 20.0),
                ("imu_lost", 10.0), ("heading_lost", 20.0),
            )
        )  # fmt: skip
        lasts_s = draw.uniform(0.3, longest_s)
        if vessel != "cybership2" or name not in ("rtk_lost",):
            faults.append(f"{name}@{at_s:.1f}+{lasts_s:.1f}")
        at_s += lasts_s
    return faults


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold, go to one point after the other, or sail a mission there. A go-to that the boat refuses for the moment, its
    heading being lost, is asked for again."""
    rig = gcs.rig
    day, draw = _DAYS.get(rig.conditions.vessel, _ANY_DAY), _random(rig.conditions.seed, "sail")
    frame = LocalFrame(rig.config.home.lat_deg, rig.config.home.lon_deg)
    gcs.ready()
    gcs.set_parameter("FS_POS_T", 60.0)  # no failsafe ends the run
    kind = draw.choice(("hold", "points", "mission"))
    places = [(draw.uniform(-1.0, 1.0) * day.reach_m, draw.uniform(-1.0, 1.0) * day.reach_m) for _ in range(60)]
    if kind == "mission":
        gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*place)) for place in places])
    gcs.set_mode(_MISSION if kind == "mission" else _HOLD)
    gcs.arm()
    if kind != "mission":
        gcs.reposition(rig.config.home.lat_deg, rig.config.home.lon_deg, rig.config.home.yaw_rad)
    end_s = rig.now_s + number(settings, "duration")
    asked: tuple[float, float, float] | None = None  # a go-to that was refused for the moment
    while rig.now_s < end_s:
        gcs.sail(min(draw.uniform(20.0, 60.0), end_s - rig.now_s + 0.1))
        if kind == "points" and _holds(gcs):
            if asked is None:
                asked = (*frame.to_geodetic(*places.pop()), draw.uniform(-math.pi, math.pi))
                places = places or [(0.0, 0.0)]
            asked = None if gcs.offer_reposition(*asked) else asked
    return {"hours": rig.now_s / 3600.0}


def _holds(gcs: GroundStation) -> bool:
    heartbeat = gcs.last.get("HEARTBEAT")
    return heartbeat is not None and heartbeat.custom_mode == _HOLD and bool(heartbeat.base_mode & 128)


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """The number of sensors that were found to lie."""
    metrics = {"false_alarms": float(len(found_s(folder))), "hours": asked["hours"]}
    return metrics, [Check("sensors found to lie", metrics["false_alarms"], 0.0, "")]


SCENARIO = Scenario(
    name="honest_senses",
    text="good sensors with large ordinary errors, drawn by the seed: none may be found to lie",
    vessel="revolt",
    defaults={"duration": "600"},
    sail=sail,
    measure=measure,
    prepare=prepare,
    lasts_s=600.0,
)
