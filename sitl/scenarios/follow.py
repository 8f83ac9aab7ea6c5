"""A lead boat sails a script; the follower keeps its follow position, inside the wake if that is astern."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sitl.leader_script import script
from sitl.scenarios.convoy import Convoy
from sitl.scenarios.follow_measure import WAKE_M, Chase, columns, modes, rms, share, variation_1ps
from sitl.scenarios.follow_plot import draw as draw
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, read_events
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number
from sitl.shared_sea import LeadBoatConfig

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SETTLE_S = 40.0  # after the leader's departure
NEAREST_M = 12.0  # FOLL_MIN_DIST
_MARGIN_M = 3.5  # FOLL_MARGIN
_KEPT = re.compile(r"but (\d+) m is kept")
# A leader that turns back past its follower displaces it. It can be back when it has turned half round, at this share
# of PATH_YAW_RATE, has made up what the leader has gone on meanwhile, by FOLL_CLOSE_V at most, and has settled.
_TURN_SHARE, _CLOSE_MPS, _SETTLES_S = 0.75, 4.0, 10.0
# share of the leader's top speed below which nothing is judged: a boat without way astern leaves the track there
MOVING_SHARE = 0.5
_AT_REST_MPS = 0.2
# A boat without way astern turns away from a leader that goes astern, and one that makes room for a leader that turns
# back past it may turn the other way round than that.
_TURNS_ASIDE, _BACKS_SHARE = 1.0, 0.02
MOST_VARIATION_1PS = 2.5
REST_SLACK_M, REST_MPS = 15.0, 1.5  # a jet boat drifts in its watch circle
# A jet that has drifted far sails back, now and then, at speed: judged are the median of the distance, and the speed
# near the leader, once that has rested for a while.
_LAST_S, _RESTS_S, _BESIDE_M = 30.0, 10.0, 5.0
REST_S = 3.0
_KNOWN_GAP_M, _TRUE_GAP_M = 2.0, 0.5
_LEAST_S, _AFTER_S = 120.0, 45.0

DEFAULTS = {
    "leader": "thesis@8.2",
    "gap": "20",
    "station": "",
    "kind": "module",
    "latency": "0.03",
    "loss": "",
    "law": "companion",
    "gains": "",
    "gnss": "standalone",
    "common": "",
    "base": "",
    "relative": "",
    "wind": "4",
    "waves": "",
    "current": "",
    "model_error": "",
    "plant": "",
    "plant_error": "",
    "time": "",
}


def follow_position_of(settings: Settings) -> tuple[float, float]:
    """(bearing in the leader's frame in rad, distance in m) of the setting `station=BEARING_DEG@M`; right astern at
    `gap` where it is empty. Raises ScenarioError."""
    text = settings.get("station", "")
    if not text:
        return math.pi, number(settings, "gap")
    bearing, at, distance = text.partition("@")
    try:
        return math.radians(float(bearing)), float(distance) if at else number(settings, "gap")
    except ValueError as error:
        raise ScenarioError(f"station={text}: write BEARING_DEG@M, as 180@20") from error


_WAYS = {"positions": 0.0, "difference": 1.0, "base": 2.0}


def relative_parameters(settings: Settings) -> dict[str, float]:
    """FOLL_REL of the setting `relative=positions|difference|base`, the best way to place the leader that may be used,
    and FOLL_COMMON of `common`; as they are where these are empty. Raises ScenarioError."""
    text = settings.get("relative", "")
    if text and text not in _WAYS:
        raise ScenarioError(f"relative={text}: one of {', '.join(_WAYS)}")
    common = {"FOLL_COMMON": number(settings, "common")} if settings.get("common") else {}
    return {**common, **({"FOLL_REL": _WAYS[text]} if text else {})}


def receivers(conditions: Conditions, settings: Settings) -> Conditions:
    """Both boats' receivers: `common` is the share of their slow errors that both have in common, `base=moving` makes
    the lead boat's the base of the follower's. Raises ScenarioError."""
    base = settings.get("base", "")
    if base not in ("", "moving"):
        raise ScenarioError(f"base={base}: moving, or nothing")
    common = number(settings, "common") if settings.get("common") else conditions.gnss_common
    return replace(conditions, gnss_common=common, moving_base=bool(base))


def thesis_parameters(settings: Settings) -> dict[str, float]:
    """Parameters of the thesis's law and AHRS, whose boat learned no rates, and doubted no thruster and no
    sensor; the setting `gains=KP/KD` is for its nozzle. Raises ScenarioError."""
    text = settings.get("gains", "")
    if settings.get("law") != "thesis":
        if text:
            raise ScenarioError(f"gains={text}: only with law=thesis")
        return {}
    own = {"AHRS_LAW": 1.0, "THR_LEARN_AZ": 0.0, "THR_WATCH": 0.0, "NAV_INTEG": 0.0}
    if not text:
        return own
    kp, _, kd = text.partition("/")
    try:
        return {**own, "FOLT_KP": float(kp), "FOLT_KD": float(kd)}
    except ValueError as error:
        raise ScenarioError(f"gains={text}: write KP/KD, as 1.2/1.5") from error


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The follower at home; the lead boat at rest so that home is the follow position, heading north."""
    bearing, distance_m = follow_position_of(settings)
    leader = LeadBoatConfig(
        "leader",
        settings["leader"],
        (-distance_m * math.cos(bearing), -distance_m * math.sin(bearing), 0.0),
        None,
        settings["gnss"],
    )
    station = {"FLW_TGT_DST": distance_m, "FLW_TGT_FA": math.degrees(math.remainder(bearing, math.tau))}
    own = {
        "DP_LAW": 0.0,
        "WP_LAW": 0.0,
        **thesis_parameters(settings),
        **relative_parameters(settings),
    }  # the setting `law` is about following alone
    return replace(
        receivers(conditions, settings),
        lead_boats=(leader,),
        start=(0.0, 0.0, 0.0),
        parameters={**conditions.parameters, **own, **station},
    )


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Follow the lead boat through its script."""
    convoy = Convoy((gcs.rig,), settings)
    convoy.follow()
    convoy.sail(REST_S)
    asked = begun(convoy)
    convoy.sail(duration_s(settings))
    return {**asked, **agility(convoy)}


def duration_s(settings: Settings) -> float:
    """The setting `time`; where it is empty, long enough for the whole script."""
    return number(settings, "time") or max(_LEAST_S, script(settings["leader"])[-1].at_s + _AFTER_S)


def begun(convoy: Convoy) -> dict[str, Any]:
    """Let the leader depart. Returns what `measure` needs."""
    config = convoy.ground_stations[0].rig.config
    convoy.boat.depart(convoy.now_s)
    jet = config.thrusters[0] if config.thrusters[0].kind == "jet" else None
    return {
        "vessel": config.name,
        "from_s": convoy.now_s,
        "nozzle": jet.name if jet is not None else "",
        "full_rad": jet.azimuth_max_rad if jet is not None else math.nan,
        "length_m": config.length_m,
        "beam_m": config.beam_m,
        "nearest_m": NEAREST_M,
    }


def agility(convoy: Convoy) -> dict[str, Any]:
    """What `measure` needs of the parameters; asked for once the sail is over, since asking takes time."""
    ground_station = convoy.ground_stations[0]
    return {
        "turns_radps": math.radians(ground_station.parameter("PATH_YAW_RATE")),
        "most_mps": ground_station.parameter("MPC_XY_VEL_MAX"),
    }


def kept_m(folder: Path, settings: Settings) -> float:
    """The distance of the follow position that the boat keeps: as asked for, or the longer one that it has told."""
    told = [match for row in read_events(folder) if (match := _KEPT.search(row.text)) is not None]
    return max(follow_position_of(settings)[1], float(told[-1].group(1)) if told else 0.0)


def rejoining_s(asked: dict[str, Any], leader_mps: float) -> float:
    """In which a boat is back astern of a leader that has turned back past it; infinite for a leader as fast as it."""
    turning_s = math.pi / (_TURN_SHARE * asked["turns_radps"])
    closing_mps = min(_CLOSE_MPS, asked["most_mps"] - leader_mps)
    return turning_s + turning_s * leader_mps / closing_mps + _SETTLES_S if closing_mps > 0.0 else math.inf


def astern_of(settings: Settings) -> bool:
    """Whether the follow position is right astern, where the follower tracks the leader's path."""
    return abs(math.cos(follow_position_of(settings)[0]) + 1.0) < 1e-6


def figures(folder: Path, chase: Chase, asked: dict[str, Any], settings: Settings) -> dict[str, float]:
    """Metrics from 40 s after the leader's departure; for a follow position astern until the leader stops or goes
    astern."""
    judged = chase.t >= asked["from_s"] + SETTLE_S
    metrics = (
        _astern(chase, judged, kept_m(folder, settings), asked)
        if astern_of(settings)
        else _elsewhere(chase, judged, settings)
    )
    metrics |= {
        "nearest_m": float(chase.distance.min()),
        "circles": chase.circles(),
        "swing_after_bends_deg": math.degrees(chase.swing_after_bends()),
        "leader_astern_share": share(chase.leader_surge < 0.0),
        "following_share": following_share(folder, asked["from_s"]),
    }
    if asked["nozzle"]:
        nozzle = asked["nozzle"]
        metrics["nozzle_variation_1ps"] = variation_1ps(
            folder, f"{nozzle}_azimuth_rad", asked["full_rad"], asked["from_s"] + SETTLE_S
        )
        metrics["throttle_variation_1ps"] = variation_1ps(folder, f"{nozzle}_throttle", 1.0, asked["from_s"] + SETTLE_S)
        metrics |= _before_bends(folder, chase, judged, asked)
    return metrics


def _before_bends(folder: Path, chase: Chase, judged: NDArray[np.bool_], asked: dict[str, Any]) -> dict[str, float]:
    """Throttle, nozzle as a share of its range (95 % of the time below) and distance to the leader before its first
    turn, and the largest distance after."""
    import numpy as np

    begin_s = chase.bends[0].begin_s if chase.bends else math.inf
    at, later = judged & (chase.t < begin_s), judged & (chase.t >= begin_s)
    ticks = columns(folder / "ticks.csv", "t_s", f"{asked['nozzle']}_throttle", f"{asked['nozzle']}_azimuth_rad")
    same = np.isin(ticks["t_s"], chase.t[at])
    if not same.any():
        return {}
    return {
        "throttle_before_bends": float(ticks[f"{asked['nozzle']}_throttle"][same].mean()),
        "nozzle_95_before_bends": float(
            np.quantile(np.abs(ticks[f"{asked['nozzle']}_azimuth_rad"][same]) / asked["full_rad"], 0.95)
        ),
        "distance_before_bends_m": float(chase.distance[at].mean()),
        "distance_after_bends_max_m": float(chase.distance[later].max()) if later.any() else math.nan,
    }


def _astern(chase: Chase, judged: NDArray[np.bool_], gap_m: float, asked: dict[str, Any]) -> dict[str, float]:
    least_m = NEAREST_M + _MARGIN_M
    leader_mps = float(chase.leader_speed.max())
    moving = judged & (chase.t < chase.ahead_until_s) & (chase.leader_speed > MOVING_SHARE * leader_mps)
    allowed_s = rejoining_s(asked, leader_mps)
    last_s = float(chase.t[moving].max()) if moving.any() else 0.0
    rejoins = chase.rejoins(gap_m, least_m)
    nexts_s = [*(begin_s for begin_s, _, _ in rejoins), math.inf][1:]
    late: list[float] = []
    for (begin_s, end_s, back_s), next_s in zip(rejoins, nexts_s, strict=False):  # none, and no next
        moving &= ~((chase.t >= begin_s) & (chase.t <= end_s + min(back_s, allowed_s)))
        if end_s + allowed_s <= min(last_s, next_s):
            late.append(back_s - allowed_s)
    straight, bend = moving & chase.on_straight, moving & chase.in_bend
    off, known_off = chase.off_m[moving], chase.known_off_m[moving]
    error, known = chase.gap_m - gap_m, chase.known_gap_m - gap_m
    return {
        "gap_rms_m": rms(error[moving]),
        "receivers_gap_rms_m": rms(
            (chase.receivers_gap_m - chase.gap_m)[moving]
        ),  # of a follower without control errors, by positions
        "in_wake_share": share(abs(off) <= WAKE_M),
        "off_rms_m": rms(off),
        "off_max_m": float(abs(off).max()) if len(off) else math.nan,
        "gap_straight_rms_m": rms(error[straight]),
        "gap_bend_rms_m": rms(error[bend]),
        "gap_bend_max_m": float(abs(error[bend]).max()) if bend.any() else math.nan,
        "recovery_max_s": max(chase.recovery_s(gap_m, least_m), default=math.nan),
        "rejoined_late_s": max(late, default=math.nan),
        "turned_back": float(len(rejoins)),
        "receivers_in_wake_share": share(
            abs(chase.receivers_off_m[moving] - off) <= WAKE_M
        ),  # the share of a follower without control errors
        "known_in_wake_share": share(abs(known_off) <= WAKE_M),
        "known_off_rms_m": rms(known_off),
        "known_gap_straight_rms_m": rms(known[straight]),
        "known_gap_bend_rms_m": rms(known[bend]),
        "speed_straight_rms_mps": rms((chase.speed - chase.leader_speed)[straight]),
        "swing_straight_rms_deg": math.degrees(rms(chase.swing[straight])),
    }


def _elsewhere(chase: Chase, judged: NDArray[np.bool_], settings: Settings) -> dict[str, float]:
    error = chase.position_error(*follow_position_of(settings))
    straight = judged & chase.on_straight
    return {
        "station_straight_rms_m": rms(error[straight]),
        "station_rms_m": rms(error[judged]),
        "station_max_m": float(error[judged].max()),
    }


def following_share(folder: Path, from_s: float) -> float:
    """Share of the ticks in Follow."""
    words = [mode for t_s, mode in modes(folder) if t_s >= from_s]
    return sum(mode == "Follow" for mode in words) / len(words)


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Metrics of following, and what must hold."""
    import numpy as np

    chase = Chase(folder, asked["from_s"])
    metrics = figures(folder, chase, asked, settings)
    if chase.leader_speed[-1] < _AT_REST_MPS:
        rests = chase.t >= chase.t[chase.leader_speed >= _AT_REST_MPS].max(initial=chase.t[0]) + _RESTS_S
        slow = rests & (chase.speed <= 0.5 * REST_MPS)
        lies = chase.t >= chase.t[slow].min(initial=chase.t[-1])  # before, it sails to its follow position
        beside = lies & (chase.distance <= follow_position_of(settings)[1] + _BESIDE_M)
        metrics |= {
            "final_distance_m": float(np.median(chase.distance[chase.t >= chase.t[-1] - _LAST_S])),
            "beside_mps": float(chase.speed[beside].max(initial=0.0)) if slow.any() else float(chase.speed[-1]),
        }
    return metrics, () if settings["law"] == "thesis" else checks(metrics, asked, settings)


def checks(metrics: dict[str, float], asked: dict[str, Any], settings: Settings) -> list[Check]:
    """What must hold of every run.

    Track and gap are judged as the boat knows them, since no law can see the receivers' errors; with a moving base as
    they truly are.
    `tests/scenarios/test_follow.py` judges the truth over many seeds.
    """
    turns_aside = _TURNS_ASIDE * (
        (metrics["leader_astern_share"] > _BACKS_SHARE) + (metrics.get("turned_back", 0.0) > 0.0)
    )
    found = [
        Check("distance from the leader", metrics["nearest_m"], NEAREST_M, "m", at_least=True),
        Check(
            "whole turns that the leader did not make",
            metrics["circles"],
            turns_aside,
            "",
        ),
        Check("in Follow all the time", metrics["following_share"], 1.0, "", at_least=True),
    ]
    if asked["nozzle"]:
        found.append(
            Check(
                "no limit cycle: nozzle's variation a second", metrics["nozzle_variation_1ps"], MOST_VARIATION_1PS, ""
            )
        )
    if astern_of(settings):
        found += _astern_checks(metrics, settings)
    if "final_distance_m" in metrics:
        found += [
            Check(
                "distance from the leader at rest",
                metrics["final_distance_m"],
                follow_position_of(settings)[1] + REST_SLACK_M,
                "m",
            ),
            Check("speed beside the leader at rest", metrics["beside_mps"], REST_MPS, "m/s"),
        ]
    return found


def _astern_checks(metrics: dict[str, float], settings: Settings) -> list[Check]:
    by, known, share_is, straight_m = (
        ("truly", "", "in_wake_share", _TRUE_GAP_M)
        if settings.get("base")
        else ("as known", "known_", "known_in_wake_share", _KNOWN_GAP_M)
    )
    found = [
        Check(
            f"share of the time within 4 m of the leader's track, {by}",
            metrics[share_is],
            0.98,
            "",
            at_least=True,
        ),
        Check(f"gap on straights, RMS, {by}", metrics[f"{known}gap_straight_rms_m"], straight_m, "m"),
    ]
    if not math.isnan(metrics["gap_bend_max_m"]):
        found.append(Check(f"gap in bends, RMS, {by}", metrics[f"{known}gap_bend_rms_m"], 5.0, "m"))
    if not math.isnan(metrics["recovery_max_s"]):
        found.append(Check("gap recovered after a bend", metrics["recovery_max_s"], 10.0, "s"))
    if not math.isnan(metrics["rejoined_late_s"]):
        found.append(
            Check(
                "later in its place than it can be, after a leader that turned back",
                metrics["rejoined_late_s"],
                0.0,
                "s",
            )
        )
    return found


SCENARIO = Scenario(
    name="follow",
    text="follow a lead boat through its script (straight, thesis, slalom, uturn, stop, reverse, lively)",
    vessel="rescuerunner",
    defaults=DEFAULTS,
    by_vessel={"revolt": {"leader": "straight@0.7", "gnss": "sbas", "wind": "2"}},
    sail=sail,
    measure=measure,
    plot=draw,
    prepare=prepare,
    lasts_s=180.0,
)
