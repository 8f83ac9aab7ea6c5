"""What the scenarios' figures share: how a figure is made, a chart of the water, panels against time, the title."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# round a hull, in shares of its length and beam from the middle
_MOST_COLUMNS = 5
_CLOSE_S = 8.0  # marks nearer than this share a number
_ON_WHITE = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
_OUTLINE = ((0.5, 0.0), (0.3, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.3, -0.5), (0.5, 0.0))


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure that needs no display. Raises ImportError without matplotlib."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def set_title(figure: Figure, settings: Mapping[str, str], vessel: str = "") -> None:
    """The vessel, if given, and the scenario's settings that are not empty."""
    words = ", ".join(f"{key} {value}" for key, value in settings.items() if value)
    figure.suptitle(f"{vessel}: {words}" if vessel else words, fontsize=10)


def finish_chart(axes: Axes, east: str = "east, m", north: str = "north, m") -> None:
    """Equal scales, labels and a grid, for axes on which east and north were drawn."""
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(east)
    axes.set_ylabel(north)
    axes.grid(alpha=0.3)


def finish_panels(panels: Sequence[Axes], t_s: Sequence[float], label: str = "time, s") -> None:
    """The same span of time, a grid, and the label of the time below the last panel alone."""
    for axes in panels:
        axes.set_xlim(t_s[0], t_s[-1])
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel(label)


def legend(axes: Axes, right: bool = False) -> None:
    """The legend above the axes, so that it lies over no data; none where nothing has a label. `right`: at the right
    end, for a second scale."""
    handles, _ = axes.get_legend_handles_labels()
    if not handles:
        return
    axes.legend(
        loc="lower right" if right else "lower left",
        bbox_to_anchor=(1.0 if right else 0.0, 1.0),
        ncols=max(1, min(len(handles), _MOST_COLUMNS)),
        fontsize=8,
        frameon=False,
        borderaxespad=0.2,
        handlelength=1.4,
        columnspacing=1.2,
    )


def mark_times(figure: Figure, panels: Sequence[Axes], marks: Sequence[tuple[float, str]]) -> None:
    """A line at each time, with a number at the foot of the first panel; the texts stand below the figure, so that
    none lies over another."""
    shown: list[tuple[float, str]] = []
    for number, (t_s, _) in enumerate(marks, start=1):
        for axes in panels:
            axes.axvline(t_s, color="black", alpha=0.4, linewidth=0.7)
        if shown and abs(t_s - shown[-1][0]) < _CLOSE_S:
            shown[-1] = shown[-1][0], f"{shown[-1][1]}, {number}"
        else:
            shown.append((t_s, str(number)))
    for t_s, text in shown:
        panels[0].annotate(
            text,
            (t_s, 0.02),
            xycoords=("data", "axes fraction"),
            xytext=(2, 0),
            textcoords="offset points",
            fontsize=8,
            bbox=_ON_WHITE,
            zorder=5,
        )
    if marks:
        lines = [f"{number}: {text}" for number, (_, text) in enumerate(marks, start=1)]
        figure.supxlabel("\n".join(lines), x=0.01, ha="left", fontsize=8)


def draw_hull(
    axes: Axes, north_m: float, east_m: float, yaw_rad: float, boat: Mapping[str, Any], color: str, alpha: float
) -> None:
    """The outline of a hull at its place; `boat` holds its `length_m` and `beam_m`."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    hull = [(x * boat["length_m"], y * boat["beam_m"]) for x, y in _OUTLINE]
    axes.plot(
        [east_m + s * x + c * y for x, y in hull],
        [north_m + c * x - s * y for x, y in hull],
        color=color,
        alpha=alpha,
        linewidth=0.8,
    )
