"""Charts against time as SVG in HTML: a legend above each, so that nothing lies over the data; every chart of a page
has the same time axis. `report.js` zooms them; without it, and in print, they are whole.

The lines stand in a nested SVG whose view box is the data: seconds to the right, values upwards.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.analysis.report_data import Array

WIDTH, LEFT, RIGHT, BOTTOM = 1000, 112, 8, 22
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195", "#555555")  # Okabe and Ito's
_MOST_POINTS = 1600
_TOP = 6
_MARGIN = 0.06
_LAST = 30  # a time so near the right end would stand over it
_STEPS = (1.0, 2.0, 5.0, 10.0)
_TIME_STEPS = (1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400)


@dataclass(frozen=True, slots=True)
class Series:
    """One line: (n,) each; NaN is a gap. `dots`: points instead of a line."""

    name: str
    t_s: Array
    values: Array
    dashed: bool = False
    dots: bool = False


@dataclass(frozen=True, slots=True)
class Band:
    """A stretch of time in one state."""

    begin_s: float
    end_s: float
    colour: str
    text: str


@dataclass(frozen=True, slots=True)
class Frame:
    """The time axis of a page, and the times to mark: (t_s, text)."""

    begin_s: float
    end_s: float
    marks: Sequence[tuple[float, str]] = ()


def chart(
    frame: Frame,
    label: str,
    series: Sequence[Series],
    limits: tuple[float, float] | None = None,
    height: int = 130,
    compass: bool = False,
) -> str:
    """A figure with the lines of `series`. `label`: what is drawn, with its unit. `compass`: directions in degrees,
    drawn around their middle and not torn apart at north. Returns a note where there is nothing."""
    drawn = [one for one in series if np.any(np.isfinite(one.values))]
    if not drawn:
        return f"<p class='none'>{escape(label)}: not in this log.</p>"
    if compass:
        series = drawn = _around_middle(drawn)
    low, high = limits or _limits(drawn)
    ticks = nice_steps(low, high, 4)
    inner = []
    for one in drawn:
        colour = COLOURS[series.index(one) % len(COLOURS)]
        inner.append(_path(one, colour, low, high, compass))
    keys = "".join(
        f"<span><i style='background:{COLOURS[n % len(COLOURS)]}' class='{'dash' if one.dashed else ''}'></i>"
        f"{escape(one.name)}</span>"
        for n, one in enumerate(series)
        if one in drawn
    )
    marks = "".join(
        f"<line class='mark' x1='{t:.2f}' x2='{t:.2f}' y1='{-high:.5g}' y2='{-low:.5g}'>"
        f"<title>{escape(text)}</title></line>"
        for t, text in frame.marks
    )
    plot = _plot(frame, low, high, marks + "".join(inner), height)
    axis = "".join(_value_tick(tick, low, high, height, compass) for tick in ticks)
    return _figure(label, keys, f"{axis}{plot}{_time_axis(frame, height)}", height)


def bands(frame: Frame, label: str, rows: Sequence[tuple[str, Sequence[Band]]], keys: Sequence[tuple[str, str]]) -> str:
    """A figure with one row of coloured stretches for each of `rows`. `keys`: (text, colour) of the legend."""
    step, count = 20, len(rows)
    height = step * count + 8
    names, inner = [], []
    for at, (name, row) in enumerate(rows):
        y = at * step
        names.append(
            f"<text x='{LEFT - 6}' y='{_TOP + y + 15}' text-anchor='end' class='tick'>{escape(_short(name))}</text>"
        )
        inner += [
            f"<rect x='{band.begin_s:.2f}' width='{max(band.end_s - band.begin_s, 0.0):.2f}' y='{y + 3}' "
            f"height='{step - 6}' fill='{band.colour}'><title>{escape(band.text)}</title></rect>"
            for band in row
        ]
    legend = "".join(f"<span><i style='background:{colour}'></i>{escape(text)}</span>" for text, colour in keys)
    plot = _plot(frame, -float(height), 0.0, "".join(inner), height)
    return _figure(label, legend, f"{''.join(names)}{plot}{_time_axis(frame, height)}", height)


def stretches(t_s: Array, numbers: NDArray[Any]) -> list[tuple[float, float, int]]:
    """(begin, end, number) of each stretch of time with the same number; NaN counts as 0."""
    state = np.nan_to_num(numbers).astype(np.int64)
    borders = (np.flatnonzero(np.diff(state)) + 1).tolist()
    edges = [0, *borders, len(t_s) - 1]
    return [(float(t_s[a]), float(t_s[b]), int(state[a])) for a, b in itertools.pairwise(edges) if b > a]


def nice_steps(low: float, high: float, count: int) -> list[float]:
    """Round numbers from `low` to `high`, about `count` of them."""
    size = (high - low) / max(1, count)
    scale = 10.0 ** math.floor(math.log10(size)) if size > 0.0 else 1.0
    step = scale * next((s for s in _STEPS if s * scale >= size), 10.0)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def thinned(t_s: Array, values: Array) -> tuple[Array, Array]:
    """As many samples as a chart can show: of each group the least and the largest, in their order."""
    count = len(values)
    if count <= _MOST_POINTS:
        return t_s, values
    size = math.ceil(2 * count / _MOST_POINTS)
    groups = count // size
    block = values[: groups * size].reshape(groups, size)
    gap = ~np.isfinite(block).any(axis=1)
    low = np.argmin(np.where(np.isfinite(block), block, np.inf), axis=1)
    high = np.argmax(np.where(np.isfinite(block), block, -np.inf), axis=1)
    base = np.arange(groups) * size
    keep = np.sort(np.stack([base + low, base + high], axis=1), axis=1).ravel()
    out = values[keep].copy()
    out[np.repeat(gap, 2)] = np.nan
    rest = np.arange(groups * size, count)
    return np.concatenate([t_s[keep], t_s[rest]]), np.concatenate([out, values[rest]])


def path_data(x: Array, y: Array, digits: int = 5) -> str:
    """The `d` of a path; a gap where a value is not finite."""
    parts, pen = [], "M"
    for a, b in zip(x.tolist(), y.tolist(), strict=True):
        if math.isfinite(a) and math.isfinite(b):
            parts.append(f"{pen}{a:.{digits + 2}g},{b:.{digits}g}")
            pen = "L"
        else:
            pen = "M"
    return "".join(parts)


def _around_middle(series: Sequence[Series]) -> list[Series]:
    """Directions in degrees, within half a turn of their circular mean."""
    every = np.radians(np.concatenate([one.values[np.isfinite(one.values)] for one in series]))
    middle = math.degrees(math.atan2(float(np.mean(np.sin(every))), float(np.mean(np.cos(every)))))
    return [replace(one, values=(one.values - middle + 180.0) % 360.0 - 180.0 + middle) for one in series]


def _path(one: Series, colour: str, low: float, high: float, compass: bool) -> str:
    turn = " data-turn='360'" if compass else ""
    name = f"data-name='{escape(one.name)}'{turn}"
    t, values = thinned(one.t_s, np.where(np.isfinite(one.values), np.clip(one.values, low, high), np.nan))
    if one.dots:
        dots = "".join(
            f"M{a:.2f},{-b:.5g}h0" for a, b in zip(t.tolist(), values.tolist(), strict=True) if math.isfinite(b)
        )
        return f"<path class='dots' {name} stroke='{colour}' d='{dots}'/>"
    dash = " stroke-dasharray='5 4'" if one.dashed else ""
    return f"<path {name} stroke='{colour}'{dash} d='{path_data(t, -values)}'/>"


def _limits(series: Sequence[Series]) -> tuple[float, float]:
    values = np.concatenate([one.values[np.isfinite(one.values)] for one in series])
    low, high = float(np.min(values)), float(np.max(values))
    if high - low < 1e-9 * max(1.0, abs(high)):
        around = max(1.0, 0.05 * abs(high))
        low, high = (low - around if low else low), high + around
    margin = _MARGIN * (high - low)
    return low - margin if low < 0.0 or low > 0.3 * high else 0.0, high + margin


def _plot(frame: Frame, low: float, high: float, inner: str, height: int) -> str:
    width = WIDTH - LEFT - RIGHT
    box = f"{frame.begin_s:.3f} {-high:.6g} {max(frame.end_s - frame.begin_s, 1e-3):.3f} {high - low:.6g}"
    return (
        f"<svg class='plot' x='{LEFT}' y='{_TOP}' width='{width}' height='{height}' viewBox='{box}' "
        f"preserveAspectRatio='none'>{inner}</svg>"
        f"<rect class='frame' x='{LEFT}' y='{_TOP}' width='{width}' height='{height}'/>"
    )


def _value_tick(value: float, low: float, high: float, height: int, compass: bool) -> str:
    shown = round(value, 6) % 360.0 if compass else value
    y = _TOP + (high - value) / (high - low) * height
    return (
        f"<line class='grid' x1='{LEFT}' x2='{WIDTH - RIGHT}' y1='{y:.1f}' y2='{y:.1f}'/>"
        f"<text class='tick' x='{LEFT - 6}' y='{y + 4:.1f}' text-anchor='end'>{shown:.4g}</text>"
    )


def _time_axis(frame: Frame, height: int) -> str:
    span = max(frame.end_s - frame.begin_s, 1e-3)
    step = next((s for s in _TIME_STEPS if span / s <= 10.0), _TIME_STEPS[-1])
    first = math.ceil(frame.begin_s / step)
    parts = []
    for k in range(first, math.floor(frame.end_s / step) + 1):
        x = LEFT + (k * step - frame.begin_s) / span * (WIDTH - LEFT - RIGHT)
        anchor = "end" if x > WIDTH - _LAST else "middle"
        parts.append(
            f"<text class='tick' x='{x:.1f}' y='{_TOP + height + 15}' text-anchor='{anchor}'>{clock(k * step)}</text>"
        )
    return f"<g class='times'>{''.join(parts)}</g>"


def clock(t_s: float) -> str:
    """Seconds as people read them: `45`, `2:05`, `1:02:05`."""
    sign, whole = ("−" if t_s < 0 else ""), abs(round(t_s))
    if whole < 60:
        return f"{sign}{whole}"
    minutes, seconds = divmod(whole, 60)
    if minutes < 60:
        return f"{sign}{minutes}:{seconds:02d}"
    return f"{sign}{minutes // 60}:{minutes % 60:02d}:{seconds:02d}"


def _short(name: str) -> str:
    return name if len(name) <= 16 else name[:15] + "…"


def _figure(label: str, keys: str, inner: str, height: int) -> str:
    total = height + _TOP + BOTTOM
    return (
        f"<figure><figcaption><b>{escape(label)}</b>{keys}</figcaption>"
        f"<svg class='chart' viewBox='0 0 {WIDTH} {total}' role='img' aria-label='{escape(label)}'>{inner}</svg>"
        "</figure>"
    )
