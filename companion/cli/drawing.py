"""A boat from above, as its file describes it: an SVG, and a rough drawing of characters for the terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from html import escape

from companion.config.devices import SensorConfig, ThrusterConfig
from companion.config.rudder import RudderConfig
from companion.config.vessel import VesselConfig

_MARGIN = 0.35  # of the length, for arrows and names
_PIXELS = 560.0
_LABEL, _LINE = 150.0, 14.0  # pixels that the label of a sensor takes
_COLUMNS = 58
_ASPECT = 0.5  # width of a character over its height
_ARROWS = "↑↗→↘↓↙←↖"

Outline = list[tuple[float, float]]
Placed = Callable[[float, float], tuple[float, float]]
"""From metres ahead and to starboard to the picture."""


def outlines(config: VesselConfig) -> list[Outline]:
    """The hulls as closed lines of (x ahead, y to starboard) in m."""
    length_m, beam_m, hull = config.length_m, config.beam_m, config.hull
    if hull.form == "catamaran" and hull.hull_beam_m is not None:
        spacing_m = hull.hull_spacing_m or beam_m - hull.hull_beam_m
        return [_one(length_m, hull.hull_beam_m, side * 0.5 * spacing_m) for side in (-1.0, 1.0)]
    return [_one(length_m, beam_m, 0.0, square=hull.form == "barge")]


def _one(length_m: float, beam_m: float, y_m: float, square: bool = False) -> Outline:
    half, b = 0.5 * length_m, 0.5 * beam_m
    if square:
        return [(half, y_m - b), (half, y_m + b), (-half, y_m + b), (-half, y_m - b)]
    bow = [(half - 0.35 * length_m * (1.0 - math.cos(a)), y_m + b * math.sin(a)) for a in _angles()]
    return [*bow, (-half, y_m + 0.85 * b), (-half, y_m - 0.85 * b)]


def _angles() -> Iterator[float]:
    return (math.radians(angle) for angle in range(-90, 91, 15))


def svg(config: VesselConfig) -> str:
    """The drawing as the text of an SVG file. Bow up; measures in m."""
    length_m, beam_m = config.length_m, config.beam_m
    half_x, half_y = (0.5 + _MARGIN) * length_m, 0.5 * beam_m + 0.6 * length_m
    scale = _PIXELS / (2.0 * half_x)
    width, height = 2.0 * half_y * scale, _PIXELS

    def at(x_m: float, y_m: float) -> tuple[float, float]:
        return (y_m + half_y) * scale, (half_x - x_m) * scale

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" '
        f'font-size="12" width="{width:.0f}" height="{height:.0f}">',
        f"<title>{escape(config.title)} from above</title>",
        '<rect width="100%" height="100%" fill="#eef5fa"/>',
    ]
    for line in outlines(config):
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in (at(*point) for point in line))
        parts.append(f'<polygon points="{points}" fill="#ffffff" stroke="#33475b" stroke-width="2"/>')
    centre = at(0.0, 0.0)
    parts.append(f'<circle cx="{centre[0]:.1f}" cy="{centre[1]:.1f}" r="3" fill="#33475b"/>')
    most_n = max(thruster.max_n for thruster in config.thrusters)
    for thruster in config.thrusters:
        parts += _thruster(thruster, at, 0.28 * length_m * thruster.max_n / most_n)
    labels: list[tuple[float, float]] = []
    for sensor in config.sensors:
        parts += _sensor(sensor, at, labels)
    text = f"{config.title}: {length_m:g} × {beam_m:g} m"
    parts += [f'<text x="10" y="20" font-size="15">{escape(text)}</text>', "</svg>"]
    return "\n".join(parts) + "\n"


def _thruster(thruster: ThrusterConfig, at: Placed, arrow_m: float) -> Iterator[str]:
    x, y = at(thruster.x_m, thruster.y_m)
    c, s = math.cos(thruster.azimuth_rad), math.sin(thruster.azimuth_rad)
    tip = at(thruster.x_m + arrow_m * c, thruster.y_m + arrow_m * s)
    yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="7" fill="#d9480f"/>'
    yield f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{tip[0]:.1f}" y2="{tip[1]:.1f}" stroke="#d9480f" stroke-width="3"/>'
    yield f'<circle cx="{tip[0]:.1f}" cy="{tip[1]:.1f}" r="4" fill="#d9480f"/>'
    side = "end" if thruster.y_m < 0.0 else "start"
    label = f"{thruster.name} ({thruster.kind}) {thruster.max_n:g} / {thruster.min_n:g} N"
    shift = -12.0 if thruster.y_m < 0.0 else 12.0
    yield f'<text x="{x + shift:.1f}" y="{y + 16.0:.1f}" text-anchor="{side}">{escape(label)}</text>'
    if thruster.rudder is not None:
        yield from _rudder(thruster.rudder, thruster.y_m, at)


def _rudder(rudder: RudderConfig, y_m: float, at: Placed) -> Iterator[str]:
    """The blade from above, amidships, with its measures."""
    (x0, y0), (x1, y1) = at(rudder.x_m, y_m), at(rudder.x_m - rudder.chord_m, y_m)
    ends = f'x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
    yield f'<line {ends} stroke="#5f3dc4" stroke-width="6" stroke-linecap="round"/>'
    label = f"rudder {rudder.span_m:g} × {rudder.chord_m:g} m"
    side, shift = ("end", -12.0) if y_m < 0.0 else ("start", 12.0)
    place_at = f'x="{x1 + shift:.1f}" y="{y1 + 16.0:.1f}" text-anchor="{side}"'
    yield f'<text {place_at} fill="#5f3dc4">{escape(label)}</text>'


def _sensor(sensor: SensorConfig, at: Placed, labels: list[tuple[float, float]]) -> Iterator[str]:
    """`labels`: where those before have theirs; its own goes above them, and is added."""
    x, y = at(sensor.x_m, sensor.y_m)
    zero = at(0.0, 0.0)
    ends = f'x1="{zero[0]:.1f}" y1="{zero[1]:.1f}" x2="{x:.1f}" y2="{y:.1f}"'
    yield f'<line {ends} stroke="#1864ab" stroke-dasharray="4"/>'
    yield f'<rect x="{x - 5:.1f}" y="{y - 5:.1f}" width="10" height="10" fill="#1864ab"/>'
    label = f"{sensor.name} {sensor.x_m:g}, {sensor.y_m:g}, {sensor.z_m:g} m"
    above = y - 7.0
    while any(abs(x - column) < _LABEL and abs(above - line) < _LINE for column, line in labels):
        above -= _LINE
    labels.append((x, above))
    yield f'<text x="{x + 9:.1f}" y="{above:.1f}" fill="#1864ab">{escape(label)}</text>'


def place(x_m: float, y_m: float) -> str:
    """`0.54 m astern, 0.35 m to port`."""
    along = f"{abs(x_m):g} m {'astern' if x_m < 0.0 else 'ahead'}"
    return f"{along}, {abs(y_m):g} m to {'port' if y_m < 0.0 else 'starboard'}"


def characters(config: VesselConfig) -> str:
    """The drawing in characters, bow up, with a list of what the signs mean."""
    half_x, half_y = 0.58 * config.length_m, 0.58 * max(config.beam_m, 0.3 * config.length_m)
    columns = _COLUMNS if half_y > half_x else max(24, round(_COLUMNS * half_y / half_x))
    rows = max(9, round(columns * half_x / half_y * _ASPECT))
    grid = [[" "] * columns for _ in range(rows)]

    def put(x_m: float, y_m: float, sign: str) -> tuple[int, int]:
        row = min(rows - 1, max(0, round((half_x - x_m) / (2.0 * half_x) * (rows - 1))))
        column = min(columns - 1, max(0, round((y_m + half_y) / (2.0 * half_y) * (columns - 1))))
        grid[row][column] = sign
        return row, column

    for line in outlines(config):
        for (x0, y0), (x1, y1) in zip(line, [*line[1:], line[0]], strict=True):
            for step in range(41):
                put(x0 + step / 40.0 * (x1 - x0), y0 + step / 40.0 * (y1 - y0), "·")
    marks = [(put(0.0, 0.0, "+"), "+  middle of the boat")]
    for sensor, sign in zip(config.sensors, "abcdefghijklmnop", strict=False):
        depth = f"{abs(sensor.z_m):g} m {'down' if sensor.z_m > 0.0 else 'up'}"
        text = f"{sign}  {sensor.name}: {place(sensor.x_m, sensor.y_m)}, {depth}"
        marks.append((put(sensor.x_m, sensor.y_m, sign), text))
    legend = []
    for thruster in config.thrusters:
        sign = _ARROWS[round(thruster.azimuth_rad / (math.pi / 4.0)) % 8]
        put(thruster.x_m, thruster.y_m, sign)
        if thruster.rudder is not None:
            put(thruster.rudder.x_m, thruster.y_m, "|")
        legend += _lines(sign, thruster)
    drawing = "\n".join("".join(row).rstrip() for row in grid)
    return f"{drawing}\n\n" + "\n".join([*(_seen(grid, *mark) for mark in marks), *legend])


def _seen(grid: list[list[str]], cell: tuple[int, int], text: str) -> str:
    """A line of the list of signs, with the sign that hides its own, if there is one."""
    shown = grid[cell[0]][cell[1]]
    return text if shown == text[0] else f"{text} (at the place of {shown})"


def _lines(sign: str, thruster: ThrusterConfig) -> list[str]:
    """The lines of a thruster in the list of signs."""
    rudder = thruster.rudder
    turns = "" if not thruster.turns else ", turns" if rudder is None else ", rudder behind it"
    lines = [
        f"{sign}  {thruster.name}: {place(thruster.x_m, thruster.y_m)}; "
        f"{thruster.max_n:g} N ahead, {abs(thruster.min_n):g} N astern{turns}"
    ]
    if rudder is not None:
        blade = f"{rudder.span_m:g} m high, {rudder.chord_m:g} m wide"
        lines.append(f"|  rudder of {thruster.name}: {place(rudder.x_m, thruster.y_m)}; {blade}")
    return lines
