"""The pictures of a report, each as SVG text."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from companion.analysis.report_data import Array, Recorded

_WIDTH_IN = 12.0
_OUTLINES = 50
_COLOURS = (
    "tab:blue",
    "tab:orange",
    "tab:green",
    "tab:red",
    "tab:purple",
    "tab:brown",
    "tab:pink",
    "tab:olive",
    "tab:cyan",
)
_WATCHED = ("WARNING", "ERROR", "CRITICAL", "ALERT", "EMERGENCY")


@dataclass(frozen=True, slots=True)
class Chart:
    """What the track shows besides the boat: (number, north, east) of waypoints; outlines of zones, and whether to stay
    inside."""

    waypoints: Sequence[tuple[int, float, float]] = ()
    zones: Sequence[tuple[Sequence[tuple[float, float]], bool]] = ()


@dataclass(frozen=True, slots=True)
class LinkSeries:
    """Packets per second, and packets missing per second, (n,) each, of the system in `name`."""

    name: str
    t_s: Array
    packets: Array
    missing: Array


@dataclass(frozen=True, slots=True)
class Pictures:
    """SVG texts by title, in the order of the page."""

    by_title: Mapping[str, str] = field(default_factory=dict)


def draw(recorded: Recorded, chart: Chart, links: Sequence[LinkSeries]) -> Pictures:
    """All pictures. Raises ImportError without matplotlib."""
    pages: list[tuple[str, float, Callable[[Any], None]]] = [
        ("Track", 8.5, lambda figure: _track(figure, recorded, chart)),
        ("Errors and speeds", 9.0, lambda figure: _errors(figure, recorded)),
        ("Wrench, demanded and achieved", 7.0, lambda figure: _wrench(figure, recorded)),
        ("Thrusters", 1.2 + 2.2 * len(recorded.thrusters), lambda figure: _thrusters(figure, recorded)),
        ("Estimator and devices", 7.0, lambda figure: _health(figure, recorded)),
    ]
    if links:
        pages.append(("Links", 1.2 + 1.7 * len(links), lambda figure: _links(figure, recorded, links)))
    return Pictures({title: _svg(height_in, paint) for title, height_in, paint in pages})


def _svg(height_in: float, paint: Callable[[Any], None]) -> str:
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with rc_context({"svg.hashsalt": "usv", "svg.fonttype": "path", "path.simplify": True}):
        figure = Figure(figsize=(_WIDTH_IN, height_in), layout="constrained")
        FigureCanvasSVG(figure)
        paint(figure)
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :]


# --- the chart -----------------------------------------------------------------------------------------------------


def _track(figure: Any, recorded: Recorded, chart: Chart) -> None:
    axes = figure.subplots()
    ticks = recorded.ticks
    valid = ticks["position_valid"] > 0.0
    north, east = np.where(valid, ticks["north_m"], np.nan), np.where(valid, ticks["east_m"], np.nan)
    if recorded.truth is not None:
        truth = recorded.truth
        axes.plot(
            recorded.thinned(truth["east_m"]),
            recorded.thinned(truth["north_m"]),
            color="black",
            linewidth=0.6,
            alpha=0.6,
            label="truth (simulation)",
        )
    for number, name in enumerate(recorded.mode_names):
        here = recorded.modes == number
        axes.plot(
            recorded.thinned(np.where(here, east, np.nan)), recorded.thinned(np.where(here, north, np.nan)),
            color=_COLOURS[number % len(_COLOURS)], linewidth=1.4, label=name,
        )  # fmt: skip
    _hulls(axes, recorded, north, east)
    for corners, inside in chart.zones:
        ring = [*corners, corners[0]]
        axes.plot(
            [e for _, e in ring],
            [n for n, _ in ring],
            color="tab:olive" if inside else "tab:red",
            linewidth=1.2,
            linestyle="-." if inside else "-",
        )
    for number, place_north, place_east in chart.waypoints:
        axes.plot(place_east, place_north, "k+", markersize=7)
        axes.annotate(
            str(number), (place_east, place_north), textcoords="offset points", xytext=(4, 4), fontsize="x-small"
        )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    axes.grid(alpha=0.3)
    axes.legend(loc="best", fontsize=8)


def _hulls(axes: Any, recorded: Recorded, north: Array, east: Array) -> None:
    """Outlines of the hull along the track; the pointed bow shows the heading."""
    length, beam = recorded.log.config.length_m, recorded.log.config.beam_m
    shape = np.array([(0.5, 0.0), (0.25, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.25, -0.5), (0.5, 0.0)]) * (length, beam)
    moved = np.hypot(np.diff(north, prepend=north[:1]), np.diff(east, prepend=east[:1]))
    way = np.cumsum(np.nan_to_num(moved))
    steps = np.linspace(0.0, way[-1], _OUTLINES) if way[-1] > length else np.array([0.0, way[-1]])
    for i in sorted({int(np.searchsorted(way, step)) for step in steps}):
        i = min(i, len(north) - 1)
        yaw = recorded.ticks["yaw_rad"][i]
        c, s = math.cos(yaw), math.sin(yaw)
        axes.plot(east[i] + shape @ (s, c), north[i] + shape @ (c, -s), color="0.35", linewidth=0.6)


# --- against time --------------------------------------------------------------------------------------------------


def _rows(figure: Any, recorded: Recorded, count: int) -> list[Any]:
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for panel in axes:
        panel.grid(alpha=0.3)
        for event in recorded.events:
            if event.severity in _WATCHED:
                panel.axvline(event.t_s, color="tab:red", alpha=0.25, linewidth=0.7)
    axes[-1].set_xlim(recorded.t_s[0], recorded.t_s[-1])
    axes[-1].set_xlabel("time, s; a red line is a warning or worse")
    return list(axes)


def _line(panel: Any, recorded: Recorded, values: Array, label: str, **style: Any) -> None:
    panel.plot(recorded.thinned(recorded.t_s), recorded.thinned(values), label=label, linewidth=0.9, **style)


def _wrapped(angle: Array) -> Array:
    return (angle + math.pi) % math.tau - math.pi


def _errors(figure: Any, recorded: Recorded) -> None:
    ticks = recorded.ticks
    away, off, speed, turn = _rows(figure, recorded, 4)
    distance = np.hypot(ticks["desired_north_m"] - ticks["north_m"], ticks["desired_east_m"] - ticks["east_m"])
    _line(away, recorded, distance, "from the desired position")
    _line(away, recorded, ticks["cross_track_error_m"], "cross-track, to starboard +")
    away.set_ylabel("distance, m")
    _line(off, recorded, np.degrees(_wrapped(ticks["desired_yaw_rad"] - ticks["yaw_rad"])), "heading error")
    off.set_ylabel("heading error, °")
    _line(speed, recorded, ticks["surge_mps"], "surge")
    _line(speed, recorded, ticks["desired_surge_mps"], "surge desired", linestyle="--")
    _line(speed, recorded, ticks["sway_mps"], "sway")
    speed.set_ylabel("speed, m/s")
    _line(turn, recorded, np.degrees(ticks["yaw_rate_radps"]), "yaw rate")
    _line(turn, recorded, np.degrees(ticks["desired_yaw_rate_radps"]), "yaw rate desired", linestyle="--")
    turn.set_ylabel("yaw rate, °/s")
    for panel in (away, off, speed, turn):
        panel.legend(loc="upper right", fontsize=8)


def _wrench(figure: Any, recorded: Recorded) -> None:
    for panel, (axis, unit) in zip(
        _rows(figure, recorded, 3), (("surge_n", "N"), ("sway_n", "N"), ("yaw_nm", "Nm")), strict=True
    ):
        _line(panel, recorded, recorded.ticks[f"demanded_{axis}"], "demanded")
        _line(panel, recorded, recorded.ticks[f"achieved_{axis}"], "achieved", linestyle="--")
        panel.set_ylabel(f"{axis.partition('_')[0]}, {unit}")
        panel.legend(loc="upper right", fontsize=8)


def _thrusters(figure: Any, recorded: Recorded) -> None:
    for panel, name in zip(_rows(figure, recorded, len(recorded.thrusters)), recorded.thrusters, strict=True):
        _line(panel, recorded, recorded.ticks[f"{name}_throttle"], "throttle")
        panel.set_ylim(-1.05, 1.05)
        panel.set_ylabel(name)
        azimuth = recorded.ticks[f"{name}_azimuth_rad"]
        if np.any(np.isfinite(azimuth)):
            right = panel.twinx()
            _line(right, recorded, np.degrees(azimuth), "azimuth, °", color="tab:orange", alpha=0.7)
            right.set_ylim(-190.0, 190.0)
            right.legend(loc="lower right", fontsize=8)
        panel.legend(loc="upper right", fontsize=8)


def _health(figure: Any, recorded: Recorded) -> None:
    ticks = recorded.ticks
    position, heading, bars, load = _rows(figure, recorded, 4)
    _line(
        position, recorded, np.where(ticks["position_valid"] > 0.0, ticks["position_accuracy_m"], np.nan), "while valid"
    )
    position.set_ylabel("position 1 σ, m")
    _line(
        heading,
        recorded,
        np.degrees(np.where(ticks["heading_valid"] > 0.0, ticks["heading_accuracy_rad"], np.nan)),
        "while valid",
    )
    heading.set_ylabel("heading 1 σ, °")
    names = ["position", "heading", *recorded.devices]
    series = [ticks["position_valid"], ticks["heading_valid"], *(ticks[f"{name}_ok"] for name in recorded.devices)]
    for row, values in enumerate(series):
        for begin, end, well in _stretches(recorded.t_s, values > 0.0):
            bars.barh(row, end - begin, left=begin, height=0.7, color="tab:green" if well else "tab:red")
    bars.set_yticks(range(len(names)), names, fontsize=8)
    bars.invert_yaxis()
    _line(load, recorded, 100.0 * ticks["load"], "share of the tick's period")
    load.set_ylabel("load, %")
    for panel in (position, heading, load):
        panel.legend(loc="upper right", fontsize=8)


def _stretches(t_s: Array, well: Any) -> list[tuple[float, float, bool]]:
    """(begin, end, state) of each stretch of time with the same state."""
    borders = np.flatnonzero(np.diff(well.astype(np.int8))) + 1
    edges = [0, *borders.tolist(), len(t_s) - 1]
    return [(float(t_s[a]), float(t_s[b]), bool(well[a])) for a, b in itertools.pairwise(edges) if b > a]


def _links(figure: Any, recorded: Recorded, links: Sequence[LinkSeries]) -> None:
    for panel, link in zip(_rows(figure, recorded, len(links)), links, strict=True):
        panel.plot(link.t_s, link.packets, label="packets a second", linewidth=0.9)
        panel.plot(link.t_s, link.missing, label="missing, by their numbers", linewidth=0.9, color="tab:red")
        panel.set_ylabel(link.name, fontsize=8)
        panel.legend(loc="upper right", fontsize=8)
