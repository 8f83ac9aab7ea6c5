"""wave-curve.svg: Hold against the height of waves on the beam, from the table `waves`, and the static balance."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from docs.generate.plot import COLOURS, GAP, HEIGHT, LEFT, SVG, TOP, WIDTH, round_numbers, tick_x, tick_y
from docs.generate.source import ROOT
from docs.generate.wave_balance import FROM_BEAM, static_height_m

FILE = ROOT / "docs" / "results" / "waves.json"

_LABEL = "Error and thrust of Hold against the height of waves on the beam, with drift and without"
_ROW = re.compile(r"^(?P<boat>.*), (?P<metres>[\d.]+) m(?P<off>, no drift)?$")
_VESSEL = re.compile(r"--vessel (\S+)")
_PANELS = (("slow_rms_m", "slow position RMS, m"), ("thrust_percent", "thrust, % of full"))
_HIGHEST_M = 1.9  # a static balance above it lies beyond what is looked at

Points = dict[tuple[str, bool], list[tuple[float, float]]]  # of a boat, with drift or without


def wave_curve(file: Path = FILE) -> str:
    """The SVG; without curves where the table is not measured yet."""
    rows = json.loads(file.read_text(encoding="utf-8"))["rows"] if file.is_file() else []
    boats = vessels(rows)
    panels = [
        _panel(LEFT + number * (WIDTH + GAP), title, points(rows, metric), list(boats))
        for number, (metric, title) in enumerate(_PANELS)
    ]
    legend = _legend(boats)
    return SVG.format(
        label=_LABEL,
        width=LEFT + 2 * WIDTH + GAP + 20,
        height=TOP + HEIGHT + 130,
        shapes="\n".join([*panels, *legend]),
    )


def vessels(rows: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Each boat's label and its file."""
    found = {}
    for row in rows:
        match, vessel = _ROW.match(row["label"]), _VESSEL.search(row["command"])
        if match is not None and vessel is not None:
            found[match["boat"]] = vessel[1]
    return found


def points(rows: Sequence[Mapping[str, Any]], metric: str) -> Points:
    """Height and mean of a metric, of each boat with and without drift, from the lowest sea on."""
    found: Points = {}
    for row in rows:
        match = _ROW.match(row["label"])
        if match is not None:
            values = [run["metrics"][metric] for run in row["runs"]]
            place = float(match["metres"]), sum(values) / len(values)
            found.setdefault((match["boat"], match["off"] is None), []).append(place)
    return {key: sorted(places) for key, places in found.items()}


def _panel(left: int, title: str, found: Points, boats: Sequence[str]) -> str:
    places = [place for curve in found.values() for place in curve]
    most_x = max((x for x, _ in places), default=1.0) * 1.12
    most_y = max((y for _, y in places), default=1.0) * 1.12
    shapes = [
        f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" class="frame"/>',
        f'<text x="{left}" y="{TOP - 10}" class="title">{escape(title)}</text>',
        f'<text x="{left + WIDTH}" y="{TOP + HEIGHT + 34}" class="end">significant height, m</text>',
        *(tick_x(left + WIDTH * x / most_x, TOP + HEIGHT, x) for x in round_numbers(most_x)),
        *(tick_y(left, TOP + HEIGHT * (1.0 - y / most_y), y) for y in round_numbers(most_y)),
    ]
    for (boat, drifts), curve in found.items():
        colour = COLOURS[boats.index(boat) % len(COLOURS)]
        at = [(left + WIDTH * x / most_x, TOP + HEIGHT * (1.0 - y / most_y)) for x, y in curve]
        if drifts:
            line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
            shapes.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        fill = colour if drifts else "#ffffff"
        shapes += [
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{fill}" stroke="{colour}" stroke-width="2"/>' for x, y in at
        ]
    return "\n".join(shapes)


def _legend(boats: Mapping[str, str]) -> list[str]:
    shapes = []
    texts = []
    for boat, vessel in boats.items():
        static_m = static_height_m(vessel, FROM_BEAM)
        static = f"up to {static_m:.2f} m" if static_m < _HIGHEST_M else f"beyond {_HIGHEST_M:g} m"
        texts.append(f"{boat}: thrusters balance the mean drift {static}")
    for number, text in enumerate(texts):
        y = TOP + HEIGHT + 60 + 22 * number
        shapes.append(f'<circle cx="{LEFT + 6}" cy="{y - 4}" r="5" fill="{COLOURS[number % len(COLOURS)]}"/>')
        shapes.append(f'<text x="{LEFT + 18}" y="{y}" class="label">{escape(text)}; open circles: no drift</text>')
    return shapes
