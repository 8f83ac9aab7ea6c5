"""What the feed tells of a boat besides its ticks: once at the start, and once a second what changes seldom."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from companion.config.vessel import as_dict
from companion.core.arming import ArmingFinding
from companion.core.estimate import NavState
from companion.fence.chart import chart_of
from companion.io.mavlink.services.shell import snapshot_of
from companion.io.mavlink.telemetry.arming_events import remedy_of
from companion.loop import Vessel
from companion.mission.plan import PlanKind
from companion.modes.parts.berth import BerthChoice
from companion.modes.table import DECLARATIONS
from companion.params.store import Parameters
from companion.record.feed import SOCKET, Feed
from companion.record.feed_schema import VERSION
from companion.supervisor.situation import Situation
from companion.supervisor.trial_duty import TrialDuty
from companion.supervisor.why import why

_MOST_PATH = 400  # points of a path
SHOWN = (
    "COM_DL_LOSS_T",
    "COM_RC_LOSS_T",
    "DP_ALARM_R",
    "DP_BW_SURGE",
    "DP_BW_SWAY",
    "DP_BW_YAW",
    "DP_NUDGE_MAX",
    "DP_NUDGE_YAW",
    "DP_WATCH_R",
    "FOLL_LOSS_T",
    "FOLL_MIN_DIST",
    "FS_POS_T",
    "WP_SPEED",
    "WP_STUCK_T",
)
"""Parameters that displays draw or let people trim; those that a boat has."""


def open_feed(vessel: Vessel, links: Sequence[str], state: Path) -> Feed:
    """The feed of a boat, with its socket in the folder `state`. Raises OSError where that cannot be made."""
    config = vessel.config
    return Feed(
        state / SOCKET,
        greeting(vessel, links),
        [thruster.name for thruster in config.thrusters],
        [*(sensor.name for sensor in config.sensors), *(bridge.name for bridge in config.actuators)],
        lambda now_s: look(vessel, now_s),
    )


def greeting(vessel: Vessel, links: Sequence[str]) -> dict[str, Any]:
    """What is known from the start."""
    return {
        "version": VERSION,
        "configuration": as_dict(vessel.config),
        "system": int(vessel.parameters["MAV_SYS_ID"]),
        "links": list(links),
        "period_s": vessel.period_s,
        "modes": [
            {"name": mode.value, "px4": row.px4, "text": row.text, "offered": row.selectable}
            for mode, row in DECLARATIONS.items()
        ],
    }


def look(vessel: Vessel, now_s: float) -> dict[str, Any]:
    """What changes seldom, as plain values that the control thread does not touch again."""
    supervisor, parameters, frame = vessel.supervisor, vessel.parameters, vessel.frame
    parts = supervisor.parts
    snapshot = snapshot_of(vessel, (), now_s)
    stations, refusals = supervisor.ground_stations, snapshot.refusals or {}
    nav = parts.nav
    return {
        "frame": {"lat_deg": frame.lat_deg, "lon_deg": frame.lon_deg},
        "parameters": parameters_shown(parameters),
        "sources": dict(vessel.sources),
        "words": list(why(snapshot)),
        "findings": [_finding(finding) for finding in snapshot.report.findings],
        "refusals": {mode.value: reason for mode, reason in refusals.items()},
        "control": {
            "system": stations.in_control,
            "takeover": stations.takeover,
            "operators": sorted(stations.operators),
        },
        "speed_mps": parts.cruise.speed_mps,
        "trial": _trial(parts.trial_duty),
        "timers": list(_timers(parts.situation(now_s))),
        "station": dict(zip(("distance_m", "bearing_rad"), supervisor.following.follow_position, strict=True)),
        "path": _thinned(parts.helm.mode.way_ahead()),
        **chart_of({kind: vessel.plans.items(kind) for kind in PlanKind}, frame, parts.chart.outline),
        "berth": _berth(vessel, nav),
    }


def parameters_shown(parameters: Parameters) -> dict[str, float]:
    """The values of `SHOWN`."""
    return {name: parameters[name] for name in SHOWN if parameters.spec(name) is not None}


def _trial(duty: TrialDuty) -> dict[str, Any]:
    """What a sea trial found, and which model counts from the next start on."""
    results = duty.results
    return {
        "identifying": duty.identifying,
        "proposal": None if results is None else results.proposal,
        "in_force": None if results is None else results.in_force,
    }


def _finding(finding: ArmingFinding) -> dict[str, Any]:
    modes = None if finding.modes is None else sorted(mode.value for mode in finding.modes)
    return {"text": finding.text, "remedy": remedy_of(finding), "blocks": finding.blocks, "modes": modes}


def _timers(situation: Situation) -> Iterator[Mapping[str, Any]]:
    """What falls silent, for how long it has been, and when a failsafe acts."""
    parameters, nav = situation.parameters, situation.nav
    yield _timer("ground station", situation.ground_station_age_s, parameters["COM_DL_LOSS_T"])
    yield _timer("sticks", situation.sticks_age_s, parameters["COM_RC_LOSS_T"])
    yield _timer("position", nav.position_age_s, parameters["FS_POS_T"])
    yield _timer("heading", nav.heading_age_s, parameters["FS_POS_T"])
    yield _timer("no headway", situation.mode.stuck_s(situation.now_s), parameters["WP_STUCK_T"])


def _timer(name: str, age_s: float | None, limit_s: float) -> dict[str, Any]:
    return {"name": name, "age_s": age_s, "limit_s": limit_s}


def _thinned(points: Sequence[tuple[float, float]]) -> list[list[float]]:
    """At most `_MOST_PATH` points of a line, its ends among them."""
    step = max(1, math.ceil(len(points) / _MOST_PATH))
    kept = [list(point) for point in points[::step]]
    return [*kept, list(points[-1])] if kept and points[-1] != tuple(kept[-1]) else kept


def _berth(vessel: Vessel, nav: NavState) -> dict[str, Any] | None:
    berth = BerthChoice(vessel.config, vessel.plans, lambda: vessel.frame).find(nav)
    if berth is None:
        return None
    north_m, east_m, yaw_rad = berth.pose(0.0)
    return {
        "north_m": berth.north_m,
        "east_m": berth.east_m,
        "boat": [north_m, east_m, yaw_rad],
        "standoff_m": berth.standoff_m,
    }
