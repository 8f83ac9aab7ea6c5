"""The figure of dynamic positioning, as in the thesis: track with hulls, pose, wrench, thrusters, metrics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sitl.scenarios.figure import draw_hull, finish_chart, finish_panels, legend, new_figure, set_title
from sitl.scenarios.positioning import PositioningLog, ThrusterFigures, energy, iadc, iae, read

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from sitl.scenarios.scenario import Settings

_REAL, _DESIRED, _OTHER = "tab:blue", "tab:orange", "tab:green"
_OUTLINES = 24


def draw(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `positioning.png` into the folder. Raises ImportError without matplotlib."""
    sailed = read(folder, asked["from_s"], asked["to_s"])
    figure = new_figure(15.0, 11.0)
    grid = figure.add_gridspec(6, 2, width_ratios=(1.0, 1.2))
    _track(figure.add_subplot(grid[:4, 0]), sailed, asked)
    _metrics(figure.add_subplot(grid[4:, 0]), sailed, asked["thrusters"])
    right: list[Axes] = [figure.add_subplot(grid[row, 1]) for row in range(6)]
    t = [row["t_s"] - asked["from_s"] for row in sailed.ticks]
    _pose(right[:3], t, sailed)
    _wrench(right[3], t, sailed)
    _thrusters(right[4], right[5], t, sailed, asked["thrusters"])
    finish_panels(right, t)
    for axes in right[:-1]:
        axes.tick_params(labelbottom=False)
    set_title(figure, settings, asked["vessel"])
    figure.savefig(folder / "positioning.png", dpi=90)


def _track(axes: Axes, sailed: PositioningLog, asked: dict[str, Any]) -> None:
    ticks, truth = sailed.ticks, sailed.truth
    axes.plot(
        [row["desired_east_m"] for row in ticks],
        [row["desired_north_m"] for row in ticks],
        color=_DESIRED,
        label="desired",
    )
    axes.plot([row["east_m"] for row in truth], [row["north_m"] for row in truth], color=_REAL, label="sailed")
    for row in truth[:: max(1, len(truth) // _OUTLINES)]:
        draw_hull(axes, row["north_m"], row["east_m"], row["yaw_rad"], asked, _REAL, 0.35)
    for north_m, east_m, yaw_rad in asked["corners"]:
        draw_hull(axes, north_m, east_m, yaw_rad, asked, "black", 0.8)
    finish_chart(axes)
    legend(axes)


def _pose(axes: Sequence[Axes], t: list[float], sailed: PositioningLog) -> None:
    for each, column, label, scale in zip(
        axes,
        ("north_m", "east_m", "yaw_rad"),
        ("north, m", "east, m", "heading, °"),
        (1.0, 1.0, math.degrees(1.0)),
        strict=True,
    ):
        each.plot(t, [scale * row[f"desired_{column}"] for row in sailed.ticks], color=_DESIRED, label="desired")
        each.plot(t, [scale * row[column] for row in sailed.truth], color=_REAL, label="true")
        each.set_ylabel(label)
    legend(axes[0])


def _wrench(axes: Axes, t: list[float], sailed: PositioningLog) -> None:
    for column, label, color in (
        ("surge_n", "surge, N", _REAL),
        ("sway_n", "sway, N", _DESIRED),
        ("yaw_nm", "yaw, Nm", _OTHER),
    ):
        axes.plot(t, [row[f"demanded_{column}"] for row in sailed.ticks], color=color, alpha=0.4, linewidth=0.7)
        axes.plot(t, [row[f"achieved_{column}"] for row in sailed.ticks], color=color, linewidth=0.9, label=label)
    axes.set_ylabel("wrench")
    legend(axes)


def _thrusters(
    force: Axes, azimuth: Axes, t: list[float], sailed: PositioningLog, thrusters: Sequence[ThrusterFigures]
) -> None:
    for thruster in thrusters:
        force.plot(
            t, [100.0 * row[f"{thruster.name}_throttle"] for row in sailed.ticks], linewidth=0.9, label=thruster.name
        )
        angles = [math.degrees(row[f"{thruster.name}_azimuth_rad"]) for row in sailed.ticks]
        if not all(map(math.isnan, angles)):
            azimuth.plot(t, angles, ".", markersize=1.5, label=thruster.name)
    force.set_ylabel("throttle, %")
    legend(force)
    azimuth.set_ylabel("azimuth, °")


def _metrics(axes: Axes, sailed: PositioningLog, thrusters: Sequence[ThrusterFigures]) -> None:
    t = [row["t_s"] - sailed.ticks[0]["t_s"] for row in sailed.ticks]
    axes.plot(t, iae(sailed), color=_REAL, label="IAE")
    axes.plot(t, energy(sailed, thrusters), color=_OTHER, label="energy, s of full power")
    axes.set_xlabel("time, s")
    axes.grid(alpha=0.3)
    legend(axes)
    other = axes.twinx()
    other.plot(t, iadc(sailed, thrusters), color=_DESIRED, label="IADC")
    other.set_ylabel("IADC")
    legend(other, right=True)
