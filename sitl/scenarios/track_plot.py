"""The figure of a run along a path: track with hulls, cross-track error, speed and heading, thrusters."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sitl.scenarios.figure import draw_hull, finish_chart, finish_panels, legend, new_figure, set_title
from sitl.scenarios.measure import along_path, read_events, sampled_path
from sitl.scenarios.positioning import PositioningLog, read

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from sitl.scenarios.scenario import Settings

_TRUE, _DESIRED, _OTHER = "tab:blue", "tab:orange", "tab:green"
_OUTLINES = 60


def draw(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `track.png` into the folder. Raises ImportError without matplotlib."""
    sailed = read(folder, asked["started_s"], asked["finished_s"])
    path = sampled_path([asked["start"], *asked["corners"]], settings["path"])
    figure = new_figure(15.0, 9.0)
    grid = figure.add_gridspec(4, 2, width_ratios=(1.2, 1.0))
    _chart(figure.add_subplot(grid[:, 0]), sailed, path, asked)
    right: list[Axes] = [figure.add_subplot(grid[row, 1]) for row in range(4)]
    t = [row["t_s"] - asked["started_s"] for row in sailed.ticks]
    _against_time(right, t, sailed, [distance for _, distance in along_path(sailed.truth, path)])
    for reached_s in _reached_s(folder, asked):
        right[0].axvline(reached_s - asked["started_s"], color="black", alpha=0.3, linewidth=0.7)
    finish_panels(right, t)
    for axes in right:
        legend(axes)
    set_title(figure, settings, asked["vessel"])
    figure.savefig(folder / "track.png", dpi=80)


def _reached_s(folder: Path, asked: dict[str, Any]) -> list[float]:
    """Times at which waypoints were reached."""
    return [
        event.t_s
        for event in read_events(folder)
        if event.name == "item_reached" and asked["started_s"] <= event.t_s <= asked["finished_s"]
    ]


def _chart(axes: Axes, sailed: PositioningLog, path: list[tuple[float, float]], asked: dict[str, Any]) -> None:
    truth = sailed.truth
    axes.plot([e for _, e in path], [n for n, _ in path], color=_DESIRED, linewidth=0.8, label="path")
    axes.plot(
        [row["east_m"] for row in truth], [row["north_m"] for row in truth], color=_TRUE, linewidth=0.9, label="sailed"
    )
    for row in truth[:: max(1, len(truth) // _OUTLINES)]:
        draw_hull(axes, row["north_m"], row["east_m"], row["yaw_rad"], asked, _TRUE, 0.6)
    for north_m, east_m in asked["corners"]:
        around = [2.0 * math.pi * k / 40 for k in range(41)]
        radius_m = asked["radius_m"]
        axes.plot(
            [east_m + radius_m * math.sin(a) for a in around],
            [north_m + radius_m * math.cos(a) for a in around],
            color="black",
            linewidth=0.6,
        )
    last = truth[-1]
    if math.hypot(last["current_north_mps"], last["current_east_mps"]) > 0.0:
        axes.quiver(
            0.5,
            0.5,
            last["current_east_mps"],
            last["current_north_mps"],
            transform=axes.transAxes,
            color=_OTHER,
            scale=5.0,
            label="current",
        )
    finish_chart(axes)
    legend(axes)


def _against_time(right: list[Axes], t: list[float], sailed: PositioningLog, errors: list[float]) -> None:
    right[0].plot(t, errors, color=_TRUE, label="distance from the path, m")
    for column, label, color in (("surge_mps", "surge, m/s", _TRUE), ("sway_mps", "sway, m/s", _OTHER)):
        right[1].plot(t, [row[column] for row in sailed.ticks], color=color, linewidth=0.8, label=label)
        right[1].plot(t, [row[f"desired_{column}"] for row in sailed.ticks], color=color, linewidth=0.8, linestyle=":")
    right[2].plot(
        t,
        [math.degrees(row["desired_yaw_rad"]) for row in sailed.ticks],
        ".",
        color=_DESIRED,
        markersize=1.0,
        label="desired heading, °",
    )
    right[2].plot(
        t,
        [math.degrees(math.remainder(row["yaw_rad"], 2.0 * math.pi)) for row in sailed.truth],
        ".",
        color=_TRUE,
        markersize=1.0,
        label="true",
    )
    for column, label, color in (
        ("surge_n", "surge, N", _TRUE),
        ("sway_n", "sway, N", _OTHER),
        ("yaw_nm", "yaw, Nm", _DESIRED),
    ):
        right[3].plot(t, [row[f"achieved_{column}"] for row in sailed.ticks], color=color, linewidth=0.8, label=label)
        right[3].plot(t, [row[f"demanded_{column}"] for row in sailed.ticks], color=color, linewidth=0.6, alpha=0.4)
