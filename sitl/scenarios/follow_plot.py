"""The figure of a run behind a lead boat: tracks with the borders of the wake, and the time plots of the RescueRunner
thesis."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sitl.lead_boat import LENGTH_M
from sitl.scenarios.figure import draw_hull, finish_chart, finish_panels, legend, mark_times, new_figure, set_title
from sitl.scenarios.follow_measure import WAKE_M, Chase, columns, modes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from sitl.scenarios.scenario import Settings

_LEADER, _COLORS, _BORDER, _OTHER = "tab:orange", ("tab:blue", "tab:green"), "0.55", "tab:red"
_EVERY_S = 10.0
_AROUND_M = 80.0


def draw(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `follow.png` into the folder. Raises ImportError without matplotlib."""
    folders = [folder, *(folder / name for name in asked.get("others", ()))]
    chases = [Chase(each, asked.get("plot_from_s", asked["from_s"] - 5.0)) for each in folders]
    figure = new_figure(17.0, 10.0)
    rows = 5 if asked["nozzle"] else 4
    grid = figure.add_gridspec(rows, 2, width_ratios=(1.0, 1.1))
    _chart(figure.add_subplot(grid[: rows - 2, 0]), chases, asked)
    _around_leader(figure.add_subplot(grid[rows - 2 :, 0]), chases, asked)
    right: list[Axes] = [figure.add_subplot(grid[row, 1]) for row in range(rows)]
    for each, chase, color in zip(folders, chases, _COLORS, strict=False):
        _against_time(right, each, chase, asked, color, len(chases) == 1)
    mark_times(figure, right, [(t_s - asked["from_s"], text) for t_s, text in asked.get("marks", ())])
    for axes in right:
        if axes.lines:
            legend(axes)
    label = "time since the leader departed, s; grey: not in Follow, yellow: the leader turns"
    finish_panels(right, chases[0].t - asked["from_s"], label)
    set_title(figure, settings, asked["vessel"])
    figure.savefig(folder / "follow.png", dpi=80)


def _chart(axes: Axes, chases: list[Chase], asked: dict[str, Any]) -> None:
    import numpy as np

    first = chases[0]
    axes.plot(first.leader_east, first.leader_north, color=_LEADER, linewidth=1.0, label="leader")
    course = np.unwrap(np.arctan2(np.gradient(first.leader_east), np.gradient(first.leader_north)))
    moving = first.leader_speed > 0.5
    for side in (-WAKE_M, WAKE_M):
        border = np.where(moving, side, np.nan)
        axes.plot(
            first.leader_east + border * np.cos(course),
            first.leader_north - border * np.sin(course),
            color=_BORDER,
            linewidth=0.6,
            linestyle="--",
        )
    step = max(1, round(_EVERY_S / (first.t[1] - first.t[0])))
    for chase, color in zip(chases, _COLORS, strict=False):
        axes.plot(chase.east, chase.north, color=color, linewidth=0.9, label="follower")
        for i in range(0, len(chase.t), step):
            draw_hull(axes, chase.north[i], chase.east[i], chase.yaw[i], asked, color, 0.9)
            axes.plot(
                [chase.east[i], chase.leader_east[i]],
                [chase.north[i], chase.leader_north[i]],
                color="black",
                linewidth=0.25,
            )
    finish_chart(axes, "east, m; thin lines join the boats every 10 s", "north, m")
    legend(axes)


def _around_leader(axes: Axes, chases: list[Chase], asked: dict[str, Any]) -> None:
    """Tracks in the leader's frame within 80 m: where a follower keeps, and that the keep-out circle stays empty."""
    import numpy as np

    for chase, color in zip(chases, _COLORS, strict=False):
        north, east = chase.north - chase.leader_north, chase.east - chase.leader_east
        c, s = np.cos(chase.leader_yaw), np.sin(chase.leader_yaw)
        near = np.where(chase.distance < _AROUND_M, 1.0, np.nan)
        axes.plot((c * east - s * north) * near, (c * north + s * east) * near, color=color, linewidth=0.7)
    draw_hull(axes, 0.0, 0.0, 0.0, {"length_m": LENGTH_M, "beam_m": 0.3 * LENGTH_M}, _LEADER, 1.0)
    around = np.linspace(0.0, math.tau, 90)
    axes.plot(asked["nearest_m"] * np.cos(around), asked["nearest_m"] * np.sin(around), color=_OTHER, linewidth=0.6)
    finish_chart(axes, "to starboard of the leader, m", "ahead of it, m")


def _against_time(
    right: list[Axes], folder: Path, chase: Chase, asked: dict[str, Any], color: str, shade: bool
) -> None:
    import numpy as np

    t = chase.t - asked["from_s"]
    ahead = np.where(chase.t < chase.ahead_until_s, 1.0, np.nan)
    right[0].plot(t, chase.gap_m * ahead, color=color, linewidth=0.9, label="gap along the track, m")
    right[0].plot(t, chase.distance, color=color, linewidth=0.6, linestyle=":", label="distance, m")
    right[0].axhline(asked["nearest_m"], color=_OTHER, linewidth=0.6)
    right[1].plot(t, np.clip(chase.off_m * ahead, -15.0, 15.0), color=color, linewidth=0.9, label="off the track, m")
    right[1].plot(
        t,
        np.clip(chase.known_off_m * ahead, -15.0, 15.0),
        color=color,
        linewidth=0.5,
        alpha=0.6,
        label="as the receivers know it",
    )
    for border in (-WAKE_M, WAKE_M):
        right[1].axhline(border, color=_BORDER, linewidth=0.6, linestyle="--")
    if color == _COLORS[0]:
        right[2].plot(t, np.degrees(chase.leader_yaw), color=_LEADER, linewidth=0.9, label="leader's heading, °")
        right[3].plot(t, chase.leader_speed, color=_LEADER, linewidth=0.9, label="leader's speed, m/s")
    right[2].plot(
        t,
        np.degrees(chase.yaw + math.tau * round((chase.leader_yaw[0] - chase.yaw[0]) / math.tau)),
        color=color,
        linewidth=0.9,
        label="follower's",
    )
    right[3].plot(t, chase.speed, color=color, linewidth=0.9, label="follower's")
    if asked["nozzle"]:
        names = ("t_s", f"{asked['nozzle']}_throttle", f"{asked['nozzle']}_azimuth_rad")
        ticks = columns(folder / "ticks.csv", *names)
        when = ticks["t_s"] - asked["from_s"]
        right[4].plot(
            when, ticks[names[2]] / asked["full_rad"], color=color, linewidth=0.6, label="nozzle, of its full angle"
        )
        right[4].plot(when, ticks[names[1]], color=_OTHER, linewidth=0.9, label="throttle")
        right[4].set_ylim(-1.05, 1.05)
    if shade:
        _shade(right, folder, chase, asked["from_s"])


def _shade(right: list[Axes], folder: Path, chase: Chase, from_s: float) -> None:
    """Shade the times in which the leader turned, and in which the follower was not in Follow."""
    for bend in chase.bends:
        for axes in right:
            axes.axvspan(bend.begin_s - from_s, bend.end_s - from_s, color="gold", alpha=0.25, linewidth=0.0)
    since: float | None = None
    words = modes(folder)
    for t_s, mode in [*words, (words[-1][0], "Follow")]:
        if mode != "Follow" and since is None:
            since = t_s
        elif mode == "Follow" and since is not None:
            for axes in right:
                axes.axvspan(since - from_s, t_s - from_s, color="0.5", alpha=0.3, linewidth=0.0)
            since = None
