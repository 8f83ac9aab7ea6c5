"""energy-curve.svg: accuracy of Hold against mean power and variation of thrust, from the table `endurance`."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from docs.generate.plot import COLOURS, GAP, HEIGHT, LEFT, SVG, TOP, WIDTH, round_numbers, tick_x, tick_y
from docs.generate.source import ROOT

FILE = ROOT / "docs" / "results" / "endurance.json"

_CIRCLE = re.compile(r", DP_ECON (?:off|(?P<metres>[\d.]+) m)$")
_LABEL = "Accuracy of Hold against power and against variation of thrust; the numbers at the points are DP_ECON in m"
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
        panels.append(_panel(LEFT + number * (WIDTH + GAP), title, curves(rows, metric), rival))
    legend = _legend(list(curves(rows, _PANELS[0][0])))
    return SVG.format(
        label=_LABEL,
        width=LEFT + 2 * WIDTH + GAP + 20,
        height=TOP + HEIGHT + 130,
        shapes="\n".join([*panels, *legend]),
    )


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
        return left + WIDTH * x / most_x, TOP + HEIGHT * (1.0 - y / most_y)

    shapes = [
        f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" class="frame"/>',
        f'<text x="{left}" y="{TOP - 10}" class="title">{escape(title)}</text>',
        f'<text x="{left + WIDTH}" y="{TOP + HEIGHT + 34}" class="end">position RMS, m</text>',
        *(tick_x(*place(x, 0.0), x) for x in round_numbers(most_x)),
        *(tick_y(*place(0.0, y), y) for y in round_numbers(most_y)),
    ]
    for colour, curve in zip(COLOURS, found.values(), strict=False):
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


def _legend(labels: Sequence[str]) -> list[str]:
    shapes, y = [], TOP + HEIGHT + 60
    entries = [*zip(COLOURS, labels, strict=False), ("#c62828", f"{_RIVAL[0]} (published point)")]
    for i, (colour, label) in enumerate(entries):
        x, row_y = LEFT + (i % 2) * (WIDTH + GAP), y + 22 * (i // 2)
        shapes.append(f'<circle cx="{x + 6}" cy="{row_y - 4}" r="5" fill="{colour}"/>')
        shapes.append(f'<text x="{x + 18}" y="{row_y}" class="label">{escape(label)}</text>')
    return shapes
