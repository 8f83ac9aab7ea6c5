"""The figure of a route: track and waypoints, cross-track error, speed, heading."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sitl.scenarios.figure import finish_chart, legend, new_figure, set_title
from sitl.scenarios.measure import between, read_truth
from sitl.scenarios.route_measure import follow, line

_PATH, _SAILED = "tab:orange", "tab:blue"


def draw(folder: Path, asked: dict[str, Any], kind: str, settings: Mapping[str, str]) -> None:
    """Draw `route.png` into the folder. Raises ImportError without matplotlib."""
    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    path = line(asked["waypoints"], kind)
    sailed = follow(track, path)
    t = [row["t_s"] - asked["started_s"] for row in track]
    figure = new_figure(14.0, 8.0)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.1, 1.0))
    chart = figure.add_subplot(grid[:, 0])
    chart.plot([p[1] for p in path.points], [p[0] for p in path.points], color=_PATH, label=f"path, {kind}")
    chart.plot(
        [row["east_m"] for row in track],
        [row["north_m"] for row in track],
        color=_SAILED,
        linewidth=1.0,
        label="sailed",
    )
    for number, (north, east) in enumerate(asked["waypoints"]):
        chart.plot(east, north, "o", color="black", markersize=4)
        chart.annotate(
            "start" if number == 0 else str(number),
            (east, north),
            textcoords="offset points",
            xytext=(5, 5),
            fontsize=8,
        )
    finish_chart(chart)
    legend(chart)
    rows: tuple[tuple[str, list[tuple[Sequence[float], str, str]]], ...] = (
        ("cross-track error, m", [(sailed.error_m, _SAILED, "")]),
        ("speed over ground, m/s", [([math.hypot(row["surge_mps"], row["sway_mps"]) for row in track], _SAILED, "")]),
        ("heading, °", [
            ([math.degrees(yaw) for yaw in sailed.yaw_rad], _SAILED, "bow"),
            (_courses_deg(sailed.s_m, path.s_m, path.course_rad), _PATH, "path"),
        ]),
    )  # fmt: skip
    for i, (label, curves) in enumerate(rows):
        axes = figure.add_subplot(grid[i, 1])
        for values, color, name in curves:
            axes.plot(t, values, color=color, linewidth=0.9, label=name)
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
        if any(name for _, _, name in curves):
            legend(axes)
        if i < len(rows) - 1:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("time, s")
    set_title(figure, settings, asked["vessel"])
    figure.savefig(folder / "route.png", dpi=90)


def _courses_deg(at_m: Sequence[float], s_m: Sequence[float], course_rad: Sequence[float]) -> list[float]:
    import numpy as np

    return [math.degrees(value) for value in np.interp(at_m, s_m, course_rad)]
