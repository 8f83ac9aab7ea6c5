"""Behind a lead boat under way the link is cut, or a receiver loses its fix.

Short outages change nothing. A long one leads to the fallback, and back to Follow after it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sitl.leader_radio import KINDS
from sitl.scenarios import follow
from sitl.scenarios.convoy import Convoy
from sitl.scenarios.follow_measure import Chase, modes
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check
from sitl.scenarios.scenario import Scenario, Settings, number

_SHORT_S, _SHORT_EVERY_S, _SHORT_COUNT = 0.4, 2.0, 10
_RUN_UP_S, _END_S = 25.0, 5.0
_FALLBACK_S, _INTERVALS = 1.0, 3.0  # limit for a 20 Hz module; three intervals for slower ones
_RETURN_S, _RETURN_SLACK_S = 3.0, 1.5  # FOLL_BACK_T of good data, and the time until they are good


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Follow through ten short outages, then one long outage of each kind in `losses`."""
    convoy = Convoy((gcs.rig,), settings)
    convoy.follow()
    convoy.sail(follow.REST_S)
    asked = follow.begun(convoy)
    convoy.sail(_RUN_UP_S)
    short_from_s = convoy.now_s
    what = tuple(settings["losses"].split(","))
    for _ in range(_SHORT_COUNT):
        convoy.lose(what[0], _SHORT_S)
        convoy.sail(_SHORT_EVERY_S - _SHORT_S)
    short_to_s = convoy.now_s
    outages = []
    for each in what:
        begin_s = convoy.now_s
        convoy.lose(each, number(settings, "outage"))
        outages.append((each, begin_s, convoy.now_s))
        convoy.sail(number(settings, "back"))
    marks = [(begin_s, f"{each} lost") for each, begin_s, _ in outages] + [(end_s, "good") for _, _, end_s in outages]
    return {
        **asked,
        "short": (short_from_s, short_to_s),
        "outages": outages,
        "marks": [(short_from_s, "short"), *marks],
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """When the boat left Follow and returned, and how close it came to the leader."""
    chase = Chase(folder, asked["from_s"])
    in_modes = modes(folder)
    from_s, to_s = asked["short"]
    end = chase.t > chase.t[-1] - _END_S
    gap_m = follow.follow_position_of(settings)[1]
    metrics = {
        "away_in_short_ones": float(sum(mode != "Follow" for t_s, mode in in_modes if from_s <= t_s <= to_s)),
        "nearest_m": float(chase.distance.min()),
        "circles": chase.circles(),
        "known_gap_error_at_end_m": float(abs(chase.known_gap_m[end] - gap_m).max()),
        "known_off_at_end_m": float(abs(chase.known_off_m[end]).max()),
    }
    interval_s = 1.0 / KINDS[settings["kind"]].rate_hz
    limit_s = max(_FALLBACK_S, _INTERVALS * interval_s + 0.2)
    checks = [
        Check("ticks out of Follow in outages of 0.4 s", metrics["away_in_short_ones"], 0.0, ""),
        Check("distance from the leader", metrics["nearest_m"], follow.NEAREST_M, "m", at_least=True),
        Check("no circles", metrics["circles"], 0.0, ""),
        Check("off the leader's track at the end, as known", metrics["known_off_at_end_m"], 4.0, "m"),
        Check("gap error at the end, as known", metrics["known_gap_error_at_end_m"], 3.0, "m"),
    ]
    for each, begin_s, end_s in asked["outages"]:
        left_s = _first(in_modes, begin_s, False) - begin_s
        back_s = _first(in_modes, max(end_s, begin_s + left_s), True) - end_s
        metrics |= {f"{each}_lost_fallback_s": left_s, f"{each}_lost_back_s": back_s}
        checks += [
            Check(f"{each} lost: fallback", left_s, limit_s, "s"),
            Check(f"{each} lost: back in Follow", back_s, _RETURN_S + _RETURN_SLACK_S + 2.0 * interval_s, "s"),
            Check(
                f"{each} lost: not back before data was good long enough", back_s, _RETURN_S - 0.1, "s", at_least=True
            ),
        ]
    return metrics, () if settings["law"] == "thesis" else checks


def _first(in_modes: list[tuple[float, str]], from_s: float, following: bool) -> float:
    """When the vessel was first in Follow, or first not; infinite if never."""
    return next((t_s for t_s, mode in in_modes if t_s >= from_s and (mode == "Follow") == following), math.inf)


_DEFAULTS = {**follow.DEFAULTS, "leader": "straight@8.2", "outage": "5", "back": "45"}
SCENARIO = Scenario(
    name="link_loss",
    text="behind a lead boat the link, then the follower's own receiver, fails for 0.4 s many times and for 5 s",
    vessel="rescuerunner",
    defaults={**_DEFAULTS, "losses": "link,own"},
    sail=sail,
    measure=measure,
    plot=follow.draw,
    prepare=follow.prepare,
    lasts_s=150.0,
)
LEADER_GNSS_LOSS = Scenario(
    name="leader_gnss_loss",
    text="behind a lead boat under way, whose receiver loses its fix",
    vessel="rescuerunner",
    defaults={**_DEFAULTS, "losses": "leader"},
    sail=sail,
    measure=measure,
    plot=follow.draw,
    prepare=follow.prepare,
    lasts_s=100.0,
)
