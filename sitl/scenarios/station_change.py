"""The crew asks for one follow position after another under way; the follower finds its way around the lead boat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sitl.leader_script import script
from sitl.scenarios import follow
from sitl.scenarios.convoy import Convoy
from sitl.scenarios.follow_measure import Chase, rms
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check
from sitl.scenarios.scenario import Scenario, Settings, number

_RUN_UP_S, _JUDGED_S = 35.0, 15.0
_LEAST_EACH_S, _EACH_WAY_M = 60.0, 130.0
_MOST_M = 5.0
_NEAR_M = 5.0


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Follow, and set each follow position of `stations` for `each` seconds; unless given, long enough for a boat as
    fast as its leader leaves it time for."""
    each_s = number(settings, "each") or _each_s(settings["leader"])
    convoy = Convoy((gcs.rig,), settings)
    convoy.follow()
    convoy.sail(follow.REST_S)
    asked = follow.begun(convoy)
    convoy.sail(_RUN_UP_S)
    changes = []
    for text in settings["stations"].split(","):
        bearing, distance_m = follow.follow_position_of({**settings, "station": text})
        changes.append((convoy.now_s, bearing, distance_m))
        convoy.ground_stations[0].set_parameter("FLW_TGT_DST", distance_m)
        convoy.ground_stations[0].set_parameter("FLW_TGT_FA", math.degrees(math.remainder(bearing, math.tau)))
        convoy.sail(each_s)
    marks = [(t_s, f"{math.degrees(bearing):.0f}° {distance_m:.0f} m") for t_s, bearing, distance_m in changes]
    return {**asked, "changes": changes, "to_s": convoy.now_s, "marks": marks}


def _each_s(leader: str) -> float:
    """Seconds for one follow position: the way round the leader takes longer behind a slow one, which only a boat that
    is slow as well follows."""
    return max(_LEAST_EACH_S, _EACH_WAY_M / max(order.speed_mps for order in script(leader)))


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """How well each follow position was kept, and how close the boat came to the leader."""
    chase = Chase(folder, asked["from_s"])
    metrics = {
        "nearest_m": float(chase.distance.min()),
        "circles": chase.circles(),
        "following_share": follow.following_share(folder, asked["from_s"]),
    }
    checks = [
        Check("keep-out: distance from the leader", metrics["nearest_m"], follow.NEAREST_M, "m", at_least=True),
        Check("no circles", metrics["circles"], 0.0, ""),
        Check("in Follow all the time", metrics["following_share"], 1.0, "", at_least=True),
    ]
    ends = [*(t_s for t_s, _, _ in asked["changes"][1:]), asked["to_s"]]
    for i, ((t_s, bearing, distance_m), end_s) in enumerate(zip(asked["changes"], ends, strict=True), 1):
        error = chase.position_error(bearing, distance_m, known=True)
        settled = rms(error[(chase.t > end_s - _JUDGED_S) & (chase.t <= end_s)])
        there = [float(t) for t, e in zip(chase.t, error, strict=True) if t_s <= t <= end_s and e <= _NEAR_M]
        metrics |= {f"station_{i}_known_rms_m": settled, f"station_{i}_in_s": there[0] - t_s if there else math.inf}
        checks.append(
            Check(
                f"station {i}: {math.degrees(bearing):.0f}° at {distance_m:g} m, RMS of the last 15 s, as known",
                settled,
                _MOST_M,
                "m",
            )
        )
    return metrics, () if settings["law"] == "thesis" else checks


SCENARIO = Scenario(
    name="station_change",
    text="under way from astern to abeam, ahead and back astern, never through the lead boat's keep-out circle",
    vessel="rescuerunner",
    defaults={**follow.DEFAULTS, "leader": "straight@8.2", "stations": "90@25,0@30,180@20", "each": ""},
    sail=sail,
    measure=measure,
    plot=follow.draw,
    prepare=follow.prepare,
    lasts_s=220.0,
)
