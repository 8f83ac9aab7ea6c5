"""energy-curve.svg: accuracy of Hold against mean power and variation of thrust, from the table `endurance`."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from docs.generate.source import ROOT

FILE = ROOT / "docs" / "results" / "endurance.json"

_W, _H, _LEFT, _TOP, _GAP = 330, 250, 56, 44, 84
_COLOURS = ("#3f51b5", "#00897b", "#8e24aa", "#ef6c00")
_CIRCLE = re.compile(r", DP_ECON (?:off|(?P<metres>[\d.]+) m)$")
_RIVAL = ("ArduRover, ÅBOAT, heading not held", 0.54, 1.5)  # RMS in m, power in %; its variation is not published
_PANELS = (("power_percent", "mean power, % of full"), ("variation_percent_ps", "thrust variation, % a second"))


@dataclass(frozen=True, slots=True)
class Point:
    """Means of one row's runs. `metres`: the radius of the circle."""

    metres: float
    rms_m: float
    value: float


def energy_curve(file: Path = FILE) -> str:
    """The SVG; without curves where the table is not measured yet."""
    rows = json.loads(file.read_text(encoding="utf-8"))["rows"] if file.is_file() else []
    panels = []
    for number, (metric, title) in enumerate(_PANELS):
        rival = _RIVAL if number == 0 else None
        panels.append(_panel(_LEFT + number * (_W + _GAP), title, curves(rows, metric), rival))
    legend = _legend(list(curves(rows, _PANELS[0][0])))
    return _SVG.format(width=_LEFT + 2 * _W + _GAP + 20, height=_TOP + _H + 130, shapes="\n".join([*panels, *legend]))


def curves(rows: Sequence[Mapping[str, Any]], metric: str) -> dict[str, list[Point]]:
    """The points of each curve by its label, from the smallest circle on."""
    found: dict[str, list[Point]] = {}
    for row in rows:
        match = _CIRCLE.search(row["label"])
        if match is not None:
            point = Point(float(match["metres"] or 0.0), _mean(row, "position_rms_m"), _mean(row, metric))
            found.setdefault(row["label"][: match.start()], []).append(point)
    return {label: sorted(points, key=lambda point: point.metres) for label, points in found.items()}


def _mean(row: Mapping[str, Any], metric: str) -> float:
    values = [run["metrics"][metric] for run in row["runs"]]
    return float(sum(values) / len(values))


def _panel(left: int, title: str, found: Mapping[str, Sequence[Point]], rival: tuple[str, float, float] | None) -> str:
    points = [(point.rms_m, point.value) for curve in found.values() for point in curve]
    points += [rival[1:]] if rival else []
    most_x = max((x for x, _ in points), default=1.0) * 1.12
    most_y = max((y for _, y in points), default=1.0) * 1.12

    def place(x: float, y: float) -> tuple[float, float]:
        return left + _W * x / most_x, _TOP + _H * (1.0 - y / most_y)

    shapes = [
        f'<rect x="{left}" y="{_TOP}" width="{_W}" height="{_H}" class="frame"/>',
        f'<text x="{left}" y="{_TOP - 10}" class="title">{escape(title)}</text>',
        f'<text x="{left + _W}" y="{_TOP + _H + 34}" class="end">position RMS, m</text>',
        *(_tick_x(*place(x, 0.0), x) for x in _round(most_x)),
        *(_tick_y(*place(0.0, y), y) for y in _round(most_y)),
    ]
    for colour, curve in zip(_COLOURS, found.values(), strict=False):
        at = [place(point.rms_m, point.value) for point in curve]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
        shapes.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        for number, ((x, y), point) in enumerate(zip(at, curve, strict=True)):
            beside = -7 if number % 2 == 0 else 17  # above and below in turn: small circles lie close together
            shapes.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>')
            shapes.append(f'<text x="{x + 6:.1f}" y="{y + beside:.1f}" class="label">{point.metres:g}</text>')
    if rival:
        x, y = place(*rival[1:])
        shapes.append(f'<path d="M {x:.1f} {y - 6:.1f} l 6 6 l -6 6 l -6 -6 z" fill="#c62828"/>')
    return "\n".join(shapes)


def _round(most: float) -> list[float]:
    """Three to six round numbers up to `most`."""
    step = next(s * 10.0**e for e in range(-3, 3) for s in (1.0, 2.0, 5.0) if most / (s * 10.0**e) <= 6.0)
    return [step * i for i in range(int(most / step) + 1)]


def _tick_x(x: float, y: float, value: float) -> str:
    return f'<text x="{x:.1f}" y="{y + 17:.1f}" class="middle">{value:g}</text>'


def _tick_y(x: float, y: float, value: float) -> str:
    return (
        f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{x + _W:.1f}" y2="{y:.1f}" class="grid"/>'
        f'<text x="{x - 7:.1f}" y="{y + 4:.1f}" class="end">{value:g}</text>'
    )


def _legend(labels: Sequence[str]) -> list[str]:
    shapes, y = [], _TOP + _H + 60
    entries = [*zip(_COLOURS, labels, strict=False), ("#c62828", f"{_RIVAL[0]} (published point)")]
    for i, (colour, label) in enumerate(entries):
        x, row_y = _LEFT + (i % 2) * (_W + _GAP), y + 22 * (i // 2)
        shapes.append(f'<circle cx="{x + 6}" cy="{row_y - 4}" r="5" fill="{colour}"/>')
        shapes.append(f'<text x="{x + 18}" y="{row_y}" class="label">{escape(label)}</text>')
    return shapes


_SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" aria-label="Accuracy of
Hold against power and against variation of thrust; the numbers at the points are DP_ECON in m">
<style>
.frame {{ fill: none; stroke: #90a4ae; }}
.grid {{ stroke: #eceff1; }}
.title {{ font: bold 14px sans-serif; fill: #37474f; }}
.label {{ font: 12px sans-serif; fill: #37474f; }}
.middle {{ font: 12px sans-serif; fill: #37474f; text-anchor: middle; }}
.end {{ font: 12px sans-serif; fill: #37474f; text-anchor: end; }}
</style>
<rect width="{width}" height="{height}" fill="#ffffff"/>
{shapes}
</svg>
"""
