"""Towards a fence at top speed with the wind behind: the boat stops inside it, whatever steers it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.top_speed import top_speed_mps
from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from sitl.scenarios.boat import fast_mps, holds_by_drifting, stopping_room_m
from sitl.scenarios.figure import finish_chart, legend, new_figure, set_title
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, Track, between, read_truth
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MANUAL, _FORCES, _HEADING, _HOLD, _MISSION = 0x00010000, 0x00020000, 0x00070000, 0x03040000, 0x04040000
_BY_STICK = {"manual": _MANUAL, "forces": _FORCES, "heading": _HEADING}
_BEHIND_M, _BESIDE_M = 40.0, 100.0
_LATE_M, _LATE_ROOMS = 15.0, 1.5  # from the boat to a line that it is told late: at least, and in times what it needs
_TIMEOUT_S = 400.0
_REST_MPS = 0.1
_SWING_SHARE = 0.75  # of DP_SPEED_AHEAD
_DRIFTS_S = 120.0  # from half the way on: a boat that sails back in its watch circle may never be at rest
_LAST_S = 10.0
_HELM, _HELM_RATE_S = 1.0, 3.0  # share of the yaw stick for each rad, and for each rad/s


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The bow at the line, wherever it lies at home: Heading keeps the heading that the boat has."""
    return replace(conditions, start=(0.0, 0.0, 0.0))


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail north, towards a line at `line` metres.

    `by` says what steers: sticks in a mode (manual, forces, heading), a mission that ends near the line, or "late": a
    mission across which the fence is uploaded `late` metres ahead of the boat, else as far as the boat needs. The line
    then lies further off by what that is more than usual.
    """
    by, line_m = settings["by"], number(settings, "line")
    if by not in (*_BY_STICK, "mission", "late"):
        raise ScenarioError(f"by={by}: one of {', '.join((*_BY_STICK, 'mission', 'late'))}")
    gcs.ready()
    needs_m = stopping_room_m(gcs.rig.config, min(top_speed_mps(gcs.rig.config), gcs.parameter("MPC_XY_VEL_MAX")))
    late_m = number(settings, "late") or max(_LATE_M, _LATE_ROOMS * needs_m)
    if by == "late" and not settings["late"]:
        line_m += late_m - _LATE_M
    if by != "late":
        gcs.upload(_fence(gcs, line_m), mavlink.MAV_MISSION_TYPE_FENCE)
    if by in _BY_STICK:
        push: Callable[[], None] = lambda: _full_ahead(gcs, steered=by != "heading")  # noqa: E731
        push()
        gcs.set_mode(_BY_STICK[by])
    else:
        push = lambda: None  # noqa: E731
        home = LocalFrame(gcs.rig.config.home.lat_deg, gcs.rig.config.home.lon_deg)
        kept_m = 0.5 * gcs.rig.config.length_m + gcs.parameter("FENCE_MARGIN") + 0.1
        end_m = line_m - kept_m if by == "mission" else line_m + 40.0
        gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *home.to_geodetic(end_m, 0.0))])
        gcs.set_mode(_MISSION)
        gcs.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1.0, 25.0, -1.0)
    gcs.arm()
    gcs.send(mavlink.MAVLink_manual_control_message(1, 0, 0, 0, 0, 0))
    gcs.step()
    from_s = gcs.rig.now_s
    if by == "late":
        _until(gcs, "near the line", lambda: gcs.rig.world.truth.north_m > line_m - late_m, push)
        gcs.upload(_fence(gcs, line_m), mavlink.MAV_MISSION_TYPE_FENCE)
    return {
        "from_s": from_s,
        "line_m": line_m,
        "beyond_m": max(0.0, needs_m - late_m) if by == "late" else 0.0,
        "needs_m": needs_m,
        **_stopped(gcs, line_m, settings, push),
    }


def _stopped(gcs: GroundStation, line_m: float, settings: Settings, push: Callable[[], None]) -> dict[str, Any]:
    """Sail on until the boat has stopped, and `stay` seconds more. Returns what the stop is judged by."""
    _until(gcs, "half the way", lambda: gcs.rig.world.truth.north_m > 0.5 * line_m or _is_holding(gcs), push)
    drifts = holds_by_drifting(gcs.rig.config)
    rests_s = gcs.rig.now_s + (_DRIFTS_S if drifts else math.inf)
    _until(gcs, "at rest", lambda: abs(gcs.rig.world.truth.surge_mps) < _REST_MPS or gcs.rig.now_s >= rests_s, push)
    end_s = gcs.rig.now_s + number(settings, "stay")
    _until(gcs, "a while more", lambda: gcs.rig.now_s >= end_s, push)
    last, ahead_mps = gcs.last["FENCE_STATUS"], gcs.parameter("DP_SPEED_AHEAD")
    swings_mps = 0.0 if gcs.rig.config.limits.sway_n > 0.0 else _SWING_SHARE * ahead_mps
    return {
        "length_m": gcs.rig.config.length_m,
        "beam_m": gcs.rig.config.beam_m,
        "drifts": drifts,
        "rest_mps": max(_REST_MPS, swings_mps),  # without sideways thrust it turns its bow with the weather
        "fast_mps": fast_mps(gcs.rig.config, number(settings, "fast")),
        "breaches": last.breach_count + last.breach_status,
    }


def _is_holding(gcs: GroundStation) -> bool:
    """Whether the fence has changed the mode to Hold: a fast boat needs more than half the way for its stop."""
    return int(gcs.last["HEARTBEAT"].custom_mode) == _HOLD


def _full_ahead(gcs: GroundStation, steered: bool) -> None:
    """Push the stick full ahead. `steered`: also steer north with the yaw stick."""
    truth = gcs.rig.world.truth
    helm = -_HELM * wrap_pi(truth.yaw_rad) - _HELM_RATE_S * truth.yaw_rate_radps if steered else 0.0
    gcs.send(mavlink.MAVLink_manual_control_message(1, 1000, 0, 0, round(1000.0 * min(1.0, max(-1.0, helm))), 0))


def _until(gcs: GroundStation, what: str, condition: Callable[[], bool], push: Callable[[], None]) -> None:
    """Sail until `condition()`, with the stick held."""

    def go_on() -> bool:
        push()
        return condition()

    gcs.wait(what, go_on, _TIMEOUT_S)


def _fence(gcs: GroundStation, line_m: float) -> list[Item]:
    """A rectangle around home. Its northern side is the line."""
    home = LocalFrame(gcs.rig.config.home.lat_deg, gcs.rig.config.home.lon_deg)
    corners = ((line_m, -_BESIDE_M), (line_m, _BESIDE_M), (-_BEHIND_M, _BESIDE_M), (-_BEHIND_M, -_BESIDE_M))
    command, frame = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, mavlink.MAV_FRAME_GLOBAL
    return [Item(command, *home.to_geodetic(*corner), params=(4.0, 0.0, 0.0, 0.0), frame=frame) for corner in corners]


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """How close the hull comes to the line, and that it stands at the end."""
    track = between(read_truth(folder), asked["from_s"])
    last = between(track, track[-1]["t_s"] - _LAST_S)
    line_m, half_m, beyond_m = asked["line_m"], 0.5 * asked["length_m"], asked["beyond_m"]
    but = f", but for {beyond_m:.1f} m: told so late, it needs {asked['needs_m']:.0f} m" if beyond_m > 0.0 else ""
    metrics = {
        "top_speed_mps": max(row["surge_mps"] for row in track),
        "middle_short_of_line_m": line_m - max(row["north_m"] for row in track),
        "hull_short_of_line_m": line_m - max(row["north_m"] + _reach_m(row, asked) for row in track),
        "speed_at_end_mps": abs(sum(row["surge_mps"] for row in last) / len(last)),  # waves move a boat to and fro
        "breaches": float(asked["breaches"]),
        "needs_m": asked["needs_m"],
    }
    checks = (
        Check("top speed", metrics["top_speed_mps"], asked["fast_mps"], "m/s", at_least=True),
        Check(
            f"the boat's middle stays short of the line{but}",
            metrics["middle_short_of_line_m"],
            min(0.0, half_m - beyond_m),
            "m",
            at_least=True,
        ),
        Check(
            f"the hull stays short of the line{but}",
            metrics["hull_short_of_line_m"],
            0.0 - beyond_m,
            "m",
            at_least=True,
        ),
        *_at_rest(metrics, asked),
        Check("breaches reported", metrics["breaches"], 0.0 if beyond_m <= half_m else 2.0, ""),
    )
    return metrics, checks


def _reach_m(row: dict[str, float], asked: dict[str, Any]) -> float:
    """How far north of its middle the hull reaches."""
    length_m, beam_m = float(asked["length_m"]), float(asked["beam_m"])
    return 0.5 * (length_m * abs(math.cos(row["yaw_rad"])) + beam_m * abs(math.sin(row["yaw_rad"])))


def _at_rest(metrics: dict[str, float], asked: dict[str, Any]) -> Sequence[Check]:
    """It stands at the end; a boat that drifts in Hold need not."""
    return (
        () if asked["drifts"] else (Check("speed at the end", metrics["speed_at_end_mps"], asked["rest_mps"], "m/s"),)
    )


def plot(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `fence.png` into the folder. Raises ImportError without matplotlib."""
    track = between(read_truth(folder), asked["from_s"])
    figure = new_figure(11.0, 6.0)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.6))
    _chart(figure.add_subplot(grid[:, 0]), track, asked)
    over_way, over_time = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    to_line = [asked["line_m"] - row["north_m"] for row in track]
    over_way.plot(to_line, [row["surge_mps"] for row in track])
    over_way.invert_xaxis()
    over_way.axvline(0.0, color="tab:red", label="fence")
    over_way.axvline(0.5 * asked["length_m"], color="tab:red", linestyle=":", label="bow at the fence")
    over_way.set_xlabel("middle of the boat to the fence, m")
    over_time.plot([row["t_s"] - asked["from_s"] for row in track], to_line)
    over_time.axhline(0.0, color="tab:red")
    over_time.set_xlabel("time, s")
    over_time.set_ylabel("to the fence, m")
    over_way.set_ylabel("surge, m/s")
    legend(over_way)
    for axes in (over_way, over_time):
        axes.grid(alpha=0.3)
    set_title(figure, settings)
    figure.savefig(folder / "fence.png", dpi=90)


def _chart(axes: Axes, track: Track, asked: dict[str, Any]) -> None:
    axes.plot([row["east_m"] for row in track], [row["north_m"] for row in track])
    axes.axhline(asked["line_m"], color="tab:red")
    finish_chart(axes)


SCENARIO = Scenario(
    name="fence_stop",
    text="at top speed towards a fence, the wind behind: it stops inside",
    vessel="revolt",
    defaults={
        "wind": "5@180",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "by": "heading",
        "line": "60",
        "late": "",
        "stay": "60",
        "fast": "0.9",
    },
    sail=sail,
    measure=measure,
    prepare=prepare,
    plot=plot,
    lasts_s=130.0,
)
