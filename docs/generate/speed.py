"""The page of speed: how it changed from commit to commit, and how costs grow; and its two pictures."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from docs.generate.markdown import page, table
from docs.generate.plot import COLOURS, GAP, HEIGHT, LEFT, SVG, TOP, WIDTH, round_numbers, tick_y
from docs.generate.source import ROOT

SPEEDS = ROOT / "docs" / "results" / "speed" / "commits.json"
GROWTH = ROOT / "docs" / "results" / "speed" / "growth.json"
BOUNDS = ROOT / "docs" / "results" / "speed" / "bounds.toml"

_STRAIGHT = 1.3  # the last stretch may cost so many times the mean of those before, for each further one
_FLAT = 0.1  # share of the least cost
_LEAD = (
    "Processor time depends on the machine and on what else it does. So each measurement stands beside one of a fixed "
    "loop of Python, timed at the same time: a tick's cost as a multiple of that loop's, a speed as work in its time."
)


def speed_page(speeds: Path = SPEEDS, growth: Path = GROWTH, bounds: Path = BOUNDS) -> str:
    """The page."""
    return page(
        "Speed and growth",
        _LEAD,
        *_bounds(bounds),
        "## From commit to commit",
        "`make bench ARGS=--keep` adds a commit. 1 is the oldest of the same arithmetic; more is faster.",
        "![Speed by commit](speed-trend.svg)",
        _trend_table(_commits(speeds)),
        "## How costs grow",
        "`make growth` measures it: medians of ticks without the plant, the least of three rounds. *For each further "
        f"one* is of the last stretch. A line is straight where that is at most {_STRAIGHT} times the mean of the "
        "stretches before, and flat where the whole growth is under a tenth. Dashed: a cost for each alone.",
        "![Cost against size](growth.svg)",
        _growth_table(_axes(growth)),
    )


def _commits(file: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = json.loads(file.read_text(encoding="utf-8"))["commits"] if file.is_file() else []
    return rows


def _axes(file: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = json.loads(file.read_text(encoding="utf-8"))["axes"] if file.is_file() else []
    return rows


def _bounds(file: Path) -> Iterator[str]:
    """What bounds the speed, and where a tick's instructions go; nothing without a file."""
    if not file.is_file():
        return
    found = tomllib.loads(file.read_text(encoding="utf-8"))
    yield "## What bounds it"
    yield found["text"]
    yield table(
        ["what", "before", "now", "aim", "what bounds it now"],
        [[row[key] for key in ("what", "before", "now", "aim", "bound")] for row in found["figure"]],
    )
    for shares in found["shares"]:
        yield shares["of"]
        yield table(["part", *shares["columns"]], shares["rows"])


# --- the trend -----------------------------------------------------------------------------------------------------


def relative(commits: Sequence[Mapping[str, Any]]) -> dict[tuple[str, str], list[tuple[str, float]]]:
    """By what and arithmetic: each commit, and its speed as a multiple of the oldest one's."""
    found: dict[tuple[str, str], list[tuple[str, float]]] = {}
    for row in commits:
        for what, speed in row["speeds"].items():
            found.setdefault((what, row["arithmetic"]), []).append((row["commit"], speed))
    return {key: [(commit, speed / rows[0][1]) for commit, speed in rows] for key, rows in found.items()}


def _trend_table(commits: Sequence[Mapping[str, Any]]) -> str:
    rows = []
    for (what, arithmetic), places in relative(commits).items():
        rows.append([what, arithmetic, ", ".join(f"{commit} {ratio:.2f}" for commit, ratio in places)])
    return table(["what", "arithmetic", "commits, oldest first"], rows)


def speed_trend(file: Path = SPEEDS) -> str:
    """speed-trend.svg: a panel for each arithmetic, a curve for each row."""
    commits = _commits(file)
    curves = relative(commits)
    kinds, names = list(dict.fromkeys(kind for _, kind in curves)), list(dict.fromkeys(what for what, _ in curves))
    shapes: list[str] = []
    for number, kind in enumerate(kinds):
        own = {names.index(what): places for (what, of), places in curves.items() if of == kind}
        order = [row["commit"] for row in commits if row["arithmetic"] == kind]
        shapes += _trend_panel(LEFT + number * (WIDTH + GAP), kind, own, order)
    shapes += _legend(names)
    height = TOP + HEIGHT + 60 + 22 * math.ceil(len(names) / 2)
    return SVG.format(
        label="Speed by commit, as a multiple of the oldest one's",
        width=LEFT + 2 * WIDTH + GAP + 20,
        height=height,
        shapes="\n".join(shapes),
    )


def _trend_panel(
    left: int, title: str, curves: Mapping[int, Sequence[tuple[str, float]]], commits: Sequence[str]
) -> Iterator[str]:
    most = 1.15 * max(ratio for places in curves.values() for _, ratio in places)
    step = WIDTH / max(1, len(commits) - 1)
    yield f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" class="frame"/>'
    yield f'<text x="{left}" y="{TOP - 10}" class="title">{escape(title)}</text>'
    yield from (tick_y(left, TOP + HEIGHT * (1.0 - y / most), y) for y in round_numbers(most))
    at_x = {commit: left + number * step for number, commit in enumerate(commits)}
    for commit, x in at_x.items():
        yield f'<text x="{x:.1f}" y="{TOP + HEIGHT + 17}" class="middle">{escape(commit)}</text>'
    for number, places in curves.items():
        yield _curve([(at_x[c], TOP + HEIGHT * (1.0 - ratio / most)) for c, ratio in places], number)


# --- growth --------------------------------------------------------------------------------------------------------


def further(points: Sequence[Sequence[float]]) -> tuple[float, str]:
    """(What each further one costs in the last stretch, "flat", "straight" or "steeper"). `points`: size and cost, from
    the smallest on."""
    (first, least), (before, middle), (last, most) = points[0][:2], points[-2][:2], points[-1][:2]
    each = (most - middle) / (last - before)
    if most - least < _FLAT * least:
        return each, "flat"
    earlier = (middle - least) / (before - first) if before > first else math.inf
    return each, "straight" if each <= _STRAIGHT * earlier else "steeper"


def _growth_table(axes: Sequence[Mapping[str, Any]]) -> str:
    rows = []
    for axis in axes:
        each, shape = further(axis["points"])
        costs = ", ".join(f"{size:g}: {cost:.3g} ({ratio:.3g})" for size, cost, ratio in axis["points"])
        where = f"{axis['commit']}, {axis['arithmetic']}"
        rows.append([axis["name"], axis["size_is"], axis["cost_is"], costs, f"{each:.2g}", shape, where])
    head = ["what", "of", "cost", "size: cost (multiple of the loop)", "for each further one", "line", "commit"]
    return table(head, rows)


def growth(file: Path = GROWTH) -> str:
    """growth.svg: a panel for each axis; both scales are logarithmic."""
    axes = _axes(file)
    shapes: list[str] = []
    for number, axis in enumerate(axes):
        down, right = divmod(number, 2)
        shapes += _growth_panel(LEFT + right * (WIDTH + GAP), TOP + down * (HEIGHT + 80), axis)
    return SVG.format(
        label="Cost against size, both logarithmic; the dashed line has the slope of a cost for each",
        width=LEFT + 2 * WIDTH + GAP + 20,
        height=TOP + math.ceil(len(axes) / 2) * (HEIGHT + 80),
        shapes="\n".join(shapes),
    )


def _growth_panel(left: int, top: int, axis: Mapping[str, Any]) -> Iterator[str]:
    sizes = [size for size, _, _ in axis["points"]]
    points = [(max(size, 1), cost) for size, cost, _ in axis["points"]]
    decades_x = math.log10(points[-1][0] / points[0][0])
    low, high = 0.5 * min(cost for _, cost in points), 2.0 * max(cost for _, cost in points)
    high = max(high, 10.0 * low)
    decades_y = math.log10(high / low)

    def place(size: float, cost: float) -> tuple[float, float]:
        return (
            left + WIDTH * math.log10(size / points[0][0]) / decades_x,
            top + HEIGHT * (1.0 - math.log10(min(max(cost, low), high) / low) / decades_y),
        )

    yield f'<rect x="{left}" y="{top}" width="{WIDTH}" height="{HEIGHT}" class="frame"/>'
    yield f'<text x="{left}" y="{top - 10}" class="title">{escape(axis["name"])}, {axis["cost_is"]}</text>'
    yield f'<text x="{left + WIDTH}" y="{top + HEIGHT + 34}" class="end">{axis["size_is"]}</text>'
    for size, (at, cost) in zip(sizes, points, strict=True):
        x, y = place(at, cost)
        yield f'<text x="{x:.1f}" y="{top + HEIGHT + 17}" class="middle">{size:g}</text>'
        yield f'<text x="{x:.1f}" y="{y - 8:.1f}" class="middle">{cost:.3g}</text>'
    (x0, y0), ends = place(*points[0]), min(points[-1][0], points[0][0] * high / points[0][1])
    x1, y1 = place(ends, points[0][1] * ends / points[0][0])
    dashed = 'stroke="#90a4ae" stroke-dasharray="5 4"'
    yield f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" {dashed}/>'
    yield _curve([place(*point) for point in points], 0)


def _curve(places: Sequence[tuple[float, float]], number: int) -> str:
    colour = COLOURS[number % len(COLOURS)]
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>' for x, y in places)
    return f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>{dots}'


def _legend(names: Sequence[str]) -> Iterator[str]:
    for number, name in enumerate(names):
        x, y = LEFT + (number % 2) * (WIDTH + GAP), TOP + HEIGHT + 56 + 22 * (number // 2)
        yield f'<circle cx="{x + 6}" cy="{y - 4}" r="5" fill="{COLOURS[number % len(COLOURS)]}"/>'
        yield f'<text x="{x + 18}" y="{y}" class="label">{escape(name.strip())}</text>'
