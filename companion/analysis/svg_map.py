"""The track as an SVG chart: the same scale both ways, north up; `report.js` moves and zooms it.

Coordinates are metres: x east, y south of home.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from companion.analysis.report_data import Array, Recorded
from companion.analysis.svg_chart import COLOURS, nice_steps, path_data, stretches

_WIDTH, _HEIGHT = 620, 560
_OUTLINES = 40
_APART = 1.3  # lengths, between two outlines
_MOST_POINTS = 4000
_LABEL_PX = 12.0
_LEAST_M = 0.2  # across the view
_HULL = np.array([(0.5, 0.0), (0.25, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.25, -0.5), (0.5, 0.0)])
_ZONE_KEYS = ((True, ("stay inside", "#8a8a00")), (False, ("keep out", "#d0342c")))
_TRUTH, _DESIRED = "#111111", "#999999"


@dataclass(frozen=True, slots=True)
class Chart:
    """What the track shows besides the boat: (number, north, east) of waypoints; outlines of zones, and whether to stay
    inside; (name, track) of other boats, columns north and east."""

    waypoints: Sequence[tuple[int, float, float]] = ()
    zones: Sequence[tuple[Sequence[tuple[float, float]], bool]] = ()
    others: Sequence[tuple[str, Array]] = ()


@dataclass(slots=True)
class _Labels:
    """Places labels so that none lies over another. `scale`: metres a pixel."""

    scale: float
    taken: list[tuple[float, float, float, float]]

    def place(self, text: str, x: float, y: float, klass: str) -> str:
        """A label beside a point, hidden where it would cover another until one zooms in."""
        width, height = 0.62 * _LABEL_PX * len(text) * self.scale, 1.1 * _LABEL_PX * self.scale
        off = 5.0 * self.scale
        for dx, dy in ((off, -off), (off, off + height), (-off - width, -off), (-off - width, off + height)):
            box = (x + dx, y + dy - height, x + dx + width, y + dy)
            if all(
                box[2] < other[0] or box[0] > other[2] or box[3] < other[1] or box[1] > other[3] for other in self.taken
            ):
                self.taken.append(box)
                return self._text(text, x, y, dx / self.scale, dy / self.scale, klass)
        return self._text(text, x, y, 5.0, -5.0, f"{klass} hidden")

    def _text(self, text: str, x: float, y: float, dx_px: float, dy_px: float, klass: str) -> str:
        return (
            f"<text class='{klass}' data-x='{x:.3f}' data-y='{y:.3f}' data-dx='{dx_px:.0f}' data-dy='{dy_px:.0f}' "
            f"font-size='{_LABEL_PX * self.scale:.4g}' x='{x + dx_px * self.scale:.3f}' "
            f"y='{y + dy_px * self.scale:.3f}'>{escape(text)}</text>"
        )


def track_map(recorded: Recorded, chart: Chart) -> str:
    """A figure with the track by mode, the plan, start and end."""
    ticks = recorded.ticks
    valid = (ticks["position_valid"] > 0.0) & np.isfinite(ticks["north_m"]) & np.isfinite(ticks["east_m"])
    if not np.any(valid):
        return "<p class='none'>No valid position, so there is no track.</p>"
    x, y = np.where(valid, ticks["east_m"], np.nan), -np.where(valid, ticks["north_m"], np.nan)
    box, scale = _box(x, y, chart, recorded.log.config.length_m)
    parts = [_grid(box, scale), _zones(chart)]
    keys = [(name, COLOURS[n % len(COLOURS)]) for n, name in enumerate(recorded.mode_names)]
    desired_x, desired_y = ticks["desired_east_m"], -ticks["desired_north_m"]
    if np.any(np.isfinite(desired_x)):
        parts.append(_line(desired_x, desired_y, _DESIRED, 1.0, dashed=True))
        keys.append(("desired", _DESIRED))
    if recorded.truth is not None:
        parts.append(_line(recorded.truth["east_m"], -recorded.truth["north_m"], _TRUTH, 0.7))
        keys.append(("truth (simulation)", _TRUTH))
    for n, (name, track) in enumerate(chart.others):
        colour = COLOURS[-2 - n % 3]
        parts.append(_line(track[:, 1], -track[:, 0], colour, 1.4))
        keys.append((name, colour))
    for begin, end, mode in _mode_parts(recorded):
        parts.append(_line(x[begin:end], y[begin:end], COLOURS[mode % len(COLOURS)], 2.0))
    if box[2] > 1.5 * recorded.log.config.length_m:
        parts.append(_hulls(recorded, x, y))
    parts.append(_places(chart, x, y, scale))
    keys += [key for inside, key in _ZONE_KEYS if any(zone[1] is inside for zone in chart.zones)]
    legend = "".join(f"<span><i style='background:{colour}'></i>{escape(name)}</span>" for name, colour in keys)
    view = " ".join(f"{value:.4f}" for value in box)
    return (
        f"<figure class='map'><figcaption>{legend}</figcaption>"
        f"<svg class='track' viewBox='{view}' width='{_WIDTH}' height='{_HEIGHT}' role='img' aria-label='track'>"
        f"{''.join(parts)}</svg><div class='scale' data-width='{_WIDTH}'>{_scale_text(box, scale)}</div></figure>"
    )


def _box(x: Array, y: Array, chart: Chart, length_m: float) -> tuple[tuple[float, float, float, float], float]:
    """(x, y, width, height) of the view in metres, and metres a pixel. Hulls are in it, but for a boat that stays where
    it is: its wandering would be too small to see."""
    xs = np.concatenate([x[np.isfinite(x)], [east for _, _, east in chart.waypoints]])
    ys = np.concatenate([y[np.isfinite(y)], [-north for _, north, _ in chart.waypoints]])
    for _, track in chart.others:
        xs, ys = np.concatenate([xs, track[:, 1]]), np.concatenate([ys, -track[:, 0]])
    west, east, top, bottom = (float(f(v)) for v, f in ((xs, np.min), (xs, np.max), (ys, np.min), (ys, np.max)))
    if max(east - west, bottom - top) > length_m:
        west, east, top, bottom = west - length_m / 2, east + length_m / 2, top - length_m / 2, bottom + length_m / 2
    scale = max((east - west) / (0.84 * _WIDTH), (bottom - top) / (0.84 * _HEIGHT), _LEAST_M / _WIDTH)
    width, height = scale * _WIDTH, scale * _HEIGHT
    return (0.5 * (west + east) - 0.5 * width, 0.5 * (top + bottom) - 0.5 * height, width, height), scale


def _grid(box: tuple[float, float, float, float], scale: float) -> str:
    left, top, width, height = box
    step = nice_steps(0.0, width, 6)[1]
    parts = [f"<g class='net' data-step='{step:g}'>"]
    for k in range(math.ceil(left / step), math.floor((left + width) / step) + 1):
        parts.append(f"<line x1='{k * step:g}' x2='{k * step:g}' y1='{top:.3f}' y2='{top + height:.3f}'/>")
    for k in range(math.ceil(top / step), math.floor((top + height) / step) + 1):
        parts.append(f"<line y1='{k * step:g}' y2='{k * step:g}' x1='{left:.3f}' x2='{left + width:.3f}'/>")
    return "".join([*parts, "</g>"])


def _scale_text(box: tuple[float, float, float, float], scale: float) -> str:
    step = nice_steps(0.0, box[2], 6)[1]
    pixels = step / scale
    return f"<i style='width:{100.0 * pixels / _WIDTH:.1f}%'></i><span>{step:g} m, north is up</span>"


def _zones(chart: Chart) -> str:
    parts = []
    for corners, inside in chart.zones:
        points = " ".join(f"{east:.2f},{-north:.2f}" for north, east in corners)
        parts.append(f"<polygon class='{'inside' if inside else 'outside'}' points='{points}'/>")
    return "".join(parts)


def _line(x: Array, y: Array, colour: str, width: float, dashed: bool = False) -> str:
    step = max(1, math.ceil(len(x) / _MOST_POINTS))
    dash = " stroke-dasharray='4 4'" if dashed else ""
    data = path_data(x[::step], y[::step], 6)
    return f"<path class='line' stroke='{colour}' stroke-width='{width}'{dash} d='{data}'/>"


def _mode_parts(recorded: Recorded) -> list[tuple[int, int, int]]:
    index = np.arange(len(recorded.modes), dtype=np.float64)
    return [(int(a), int(b) + 1, mode) for a, b, mode in stretches(index, recorded.modes)]


def _hulls(recorded: Recorded, x: Array, y: Array) -> str:
    """Outlines of the hull along the track; the pointed bow shows the heading."""
    length, beam = recorded.log.config.length_m, recorded.log.config.beam_m
    way = np.cumsum(np.nan_to_num(np.hypot(np.diff(x, prepend=x[:1]), np.diff(y, prepend=y[:1]))))
    count = max(2, min(_OUTLINES, int(way[-1] / (_APART * length))))
    steps = np.linspace(0.0, way[-1], count) if way[-1] > length else np.array([0.0, way[-1]])
    parts = []
    for i in sorted({min(int(np.searchsorted(way, step)), len(x) - 1) for step in steps}):
        yaw = recorded.ticks["yaw_rad"][i]
        if not (math.isfinite(x[i]) and math.isfinite(yaw)):
            continue
        c, s = math.cos(yaw), math.sin(yaw)
        hull = _HULL * (length, beam)
        parts.append(path_data(x[i] + hull @ (s, c), y[i] - hull @ (c, -s), 6) + "Z")
    return f"<path class='hulls' d='{''.join(parts)}'/>"


def _places(chart: Chart, x: Array, y: Array, scale: float) -> str:
    """Waypoints with their numbers, start and end. Marks are lines of no length, so that they keep their size."""
    known = np.flatnonzero(np.isfinite(x))
    first, last = known[0], known[-1]
    labels = _Labels(scale, [])
    parts = [
        f"<path class='start' d='M{x[first]:.3f},{y[first]:.3f}h0'/>",
        f"<path class='end' d='M{x[last]:.3f},{y[last]:.3f}h0'/>",
    ]
    apart = math.hypot(x[last] - x[first], y[last] - y[first]) > 20.0 * scale
    parts.append(labels.place("start" if apart else "start, end", float(x[first]), float(y[first]), "name"))
    if apart:
        parts.append(labels.place("end", float(x[last]), float(y[last]), "name"))
    at: dict[tuple[float, float], list[int]] = {}
    for number, north, east in chart.waypoints:
        at.setdefault((round(east, 2), round(-north, 2)), []).append(number)
    for (east, south), numbers in at.items():
        parts.append(f"<path class='waypoint' d='M{east:g},{south:g}h0'/>")
        parts.append(labels.place(", ".join(map(str, numbers)), east, south, "number"))
    return "".join(parts)
