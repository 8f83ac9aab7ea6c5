"""The sections of a report: charts and tables of one subject each, as HTML."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from companion.analysis import report_facts as facts
from companion.analysis.report_data import WATCHED, Array, Recorded, numbered
from companion.analysis.svg_chart import COLOURS, Band, Frame, Series, bands, chart, stretches
from companion.core.readings import FixType
from companion.params.store import Parameters
from companion.params.table import table_of

Rows = Sequence[Sequence[str]]
_GOOD, _BAD, _GREY = "#8fd0b5", "#e0776e", "#c9c9c9"
_FIX_COLOURS = {1: _BAD, 2: "#e69f00", 3: "#f0e442", 4: "#bfe3a8", 5: "#8fd0b5", 6: "#009e73"}
_FIX_NAMES = {1: "none", 2: "2D", 3: "3D", 4: "DGPS", 5: "RTK float", 6: "RTK fixed"}


@dataclass(frozen=True, slots=True)
class LinkSeries:
    """Packets per second, and packets missing per second, (n,) each, of the system in `name`."""

    name: str
    t_s: Array
    packets: Array
    missing: Array


@dataclass(frozen=True, slots=True)
class Page:
    """What the sections are made of. `mission`: number, command, place, time reached; `links`: sender, packets,
    missing, share."""

    recorded: Recorded
    frame: Frame
    mission: Rows
    links: Rows
    link_series: Sequence[LinkSeries]


def table(header: Sequence[str] | None, rows: Rows) -> str:
    """An HTML table."""
    head = "" if header is None else "<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in header) + "</tr>"
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table>{head}{body}</table>"


def frame_of(recorded: Recorded) -> Frame:
    """The time axis of a log, with a mark for each warning or worse."""
    marks = [(event.t_s, event.text) for event in recorded.events if event.severity in WATCHED]
    return Frame(float(recorded.t_s[0]), float(recorded.t_s[-1]), marks)


def timeline(page: Page) -> str:
    """Modes, arming, failsafes, events."""
    recorded, t = page.recorded, page.recorded.t_s
    modes = [
        Band(a, b, COLOURS[mode % len(COLOURS)], recorded.mode_names[mode])
        for a, b, mode in stretches(t, recorded.modes)
    ]
    armed = [Band(a, b, _GOOD, "armed") for a, b, on in stretches(t, recorded.ticks["armed"]) if on]
    rows = [("mode", modes), ("armed", armed)]
    words, numbers = numbered(recorded.words["failsafes"])
    for name in facts.failsafe_times(recorded):
        lasting = np.array([name in word.split(";") for word in words], dtype=np.int64)[numbers]
        rows.append((facts.plain(name), [Band(a, b, _BAD, name) for a, b, on in stretches(t, lasting) if on]))
    thin = 0.002 * (page.frame.end_s - page.frame.begin_s)
    severe = [Band(at, at + thin, _BAD, text) for at, text in page.frame.marks]
    rows.append(("warnings", severe))
    keys = [(name, COLOURS[n % len(COLOURS)]) for n, name in enumerate(recorded.mode_names)]
    return bands(page.frame, "Modes and failsafes", rows, keys)


def errors(page: Page) -> str:
    """Errors by mode with percentiles, and against time."""
    recorded, ticks, t = page.recorded, page.recorded.ticks, page.recorded.t_s
    rows = [row.cells() for row in facts.errors_by_mode(recorded)]
    found = (
        table(("mode", "error", "median", "95 %", "largest", "RMS"), rows)
        if rows
        else _none("No setpoint, so no error.")
    )
    return found + "".join(
        (
            chart(
                page.frame,
                "Distance, m",
                [
                    Series("from the desired position", t, facts.position_errors(recorded)),
                    Series("across the track, to starboard +", t, ticks["cross_track_error_m"]),
                ],
            ),
            chart(
                page.frame,
                "Heading error, °",
                [Series("desired less estimated", t, _deg(facts.heading_errors(recorded)))],
            ),
            chart(
                page.frame,
                "Heading, °",
                [
                    Series("heading", t, _compass(ticks["yaw_rad"]), dots=True),
                    Series("desired", t, _compass(ticks["desired_yaw_rad"]), dots=True),
                ],
                compass=True,
            ),
            chart(
                page.frame,
                "Speed, m/s",
                [
                    Series("surge", t, ticks["surge_mps"]),
                    Series("surge desired", t, ticks["desired_surge_mps"], dashed=True),
                    Series("sway", t, ticks["sway_mps"]),
                    Series("sway desired", t, ticks["desired_sway_mps"], dashed=True),
                ],
            ),
            chart(
                page.frame,
                "Rate of turn, °/s",
                [
                    Series("rate of turn", t, _deg(ticks["yaw_rate_radps"])),
                    Series("desired", t, _deg(ticks["desired_yaw_rate_radps"]), dashed=True),
                ],
            ),
        )
    )


def thrusters(page: Page) -> str:
    """Use and health of each thruster, and the wrench."""
    recorded, ticks, t = page.recorded, page.recorded.ticks, page.recorded.t_s
    rows = facts.thruster_rows(recorded)
    header = ("thruster", "mean throttle", "at its limit", "turns of direction a minute", "condition")
    parts = [table(header, rows) if rows else _none("Never armed.")]
    percent = [Series(name, t, 100.0 * ticks[f"{name}_throttle"]) for name in recorded.thrusters]
    parts.append(chart(page.frame, "Throttle, %", percent, (-105.0, 105.0)))
    turning = [Series(name, t, _deg(ticks[f"{name}_azimuth_rad"]), dots=True) for name in recorded.thrusters]
    if any(np.any(np.isfinite(one.values)) for one in turning):
        parts.append(chart(page.frame, "Azimuth, ° from the bow", turning))
    for axis, unit in (("surge", "N"), ("sway", "N"), ("yaw", "Nm")):
        key = f"{axis}_{unit.lower()}"
        pair = [
            Series("achieved", t, ticks[f"achieved_{key}"]),
            Series("demanded", t, ticks[f"demanded_{key}"], dashed=True),
        ]
        parts.append(
            chart(page.frame, f"{'Moment' if axis == 'yaw' else f'Force in {axis}'}, {unit}", pair, height=100)
        )
    return "".join(parts)


def estimator(page: Page) -> str:
    """What the filter believes of itself, against the truth where there is one; devices."""
    recorded, ticks, t = page.recorded, page.recorded.ticks, page.recorded.t_s
    rows = facts.consistency_rows(recorded)
    parts = []
    if rows:
        parts.append(table(("estimate against the truth", "RMS", "largest", "within 1 σ", "within 2 σ"), rows))
    off = [Series("1 σ claimed by the filter", t, _where(ticks["position_accuracy_m"], ticks["position_valid"]))]
    turned = [
        Series("1 σ claimed by the filter", t, _deg(_where(ticks["heading_accuracy_rad"], ticks["heading_valid"])))
    ]
    if recorded.truth is not None:
        truth = recorded.truth
        north, east = (np.interp(t, truth["t_s"], truth[name]) for name in ("north_m", "east_m"))
        distance = np.hypot(ticks["north_m"] - north, ticks["east_m"] - east)
        yaw = np.interp(t, truth["t_s"], np.unwrap(truth["yaw_rad"]))
        off.append(Series("error against the truth", t, _where(distance, ticks["position_valid"])))
        angle = np.abs(facts.wrapped(ticks["yaw_rad"] - yaw))
        turned.append(Series("error against the truth", t, _deg(_where(angle, ticks["heading_valid"]))))
    parts += [chart(page.frame, "Position, m", off), chart(page.frame, "Heading, °", turned)]
    states = [("position", ticks["position_valid"]), ("heading", ticks["heading_valid"])]
    states += [(name, ticks[f"{name}_ok"]) for name in recorded.devices]
    lines = [
        (
            name,
            [
                Band(a, b, _GOOD if on else _BAD, f"{name}: {'well' if on else 'not well'}")
                for a, b, on in stretches(t, v)
            ],
        )
        for name, v in states
    ]
    parts.append(bands(page.frame, "Estimate and devices", lines, [("well", _GOOD), ("not well", _BAD)]))
    parts.append(
        chart(page.frame, "Load, % of the tick's period", [Series("computing", t, 100.0 * ticks["load"])], height=80)
    )
    return "".join(parts)


def gnss(page: Page) -> str:
    """Fix, satellites, corrections."""
    ticks, t = page.recorded.ticks, page.recorded.t_s
    fix = np.where(np.isfinite(ticks["fix"]), ticks["fix"], 0.0)
    if not np.any(fix):
        return _none("This log has no column for the fix.")
    share = [
        (_FIX_NAMES[int(kind)], f"{100.0 * float(np.mean(fix == kind)):.1f} %")
        for kind in FixType
        if np.any(fix == kind)
    ]
    row = [Band(a, b, _FIX_COLOURS.get(k, _GREY), _FIX_NAMES.get(k, "?")) for a, b, k in stretches(t, fix)]
    keys = [(_FIX_NAMES[int(kind)], _FIX_COLOURS[int(kind)]) for kind in FixType if np.any(fix == kind)]
    parts = [table(("fix", "share of the time"), share), bands(page.frame, "Fix", [("fix", row)], keys)]
    parts.append(chart(page.frame, "Satellites", [Series("used", t, ticks["satellites"])], height=80))
    parts.append(chart(page.frame, "Age of corrections, s", [Series("age", t, ticks["corrections_age_s"])], height=80))
    return "".join(parts)


def weather(page: Page) -> str:
    """Wind and current, as estimated and, in simulation, as they were."""
    ticks, t, truth = page.recorded.ticks, page.recorded.t_s, page.recorded.truth
    wind = [Series("measured", t, ticks["wind_speed_mps"])]
    wind_from = [Series("measured", t, _compass(ticks["wind_from_rad"]), dots=True)]
    speed, towards = _current(ticks)
    current, set_to = [Series("estimated", t, speed)], [Series("estimated", t, towards, dots=True)]
    if truth is not None:
        wind.append(Series("truth (simulation)", truth["t_s"], truth["wind_speed_mps"]))
        wind_from.append(Series("truth (simulation)", truth["t_s"], _compass(truth["wind_from_rad"]), dots=True))
        speed, towards = _current(truth)
        current.append(Series("truth (simulation)", truth["t_s"], speed))
        set_to.append(Series("truth (simulation)", truth["t_s"], towards, dots=True))
    return "".join(
        (
            chart(page.frame, "Wind, m/s", wind, height=90),
            chart(page.frame, "Wind from, °", wind_from, height=90, compass=True),
            chart(page.frame, "Current, m/s", current, height=90),
            chart(page.frame, "Current towards, °", set_to, height=90, compass=True),
        )
    )


def battery(page: Page) -> str:
    """Voltage, current, charge."""
    ticks, t = page.recorded.ticks, page.recorded.t_s
    return "".join(
        (
            chart(page.frame, "Voltage, V", [Series("voltage", t, ticks["battery_v"])], height=90),
            chart(page.frame, "Current, A", [Series("out of the battery", t, ticks["battery_a"])], height=90),
            chart(
                page.frame,
                "Charge left, %",
                [Series("charge", t, 100.0 * ticks["battery_remaining"])],
                (0.0, 100.0),
                90,
            ),
        )
    )


def links(page: Page) -> str:
    """Packets and gaps of each system."""
    if not page.links:
        return _none("No packets in this log.")
    parts = [table(("system", "packets", "missing", "share missing"), page.links)]
    for link in page.link_series:
        pair = [Series("packets a second", link.t_s, link.packets), Series("missing", link.t_s, link.missing)]
        parts.append(chart(page.frame, f"{link.name}, 1/s", pair, height=80))
    return "".join(parts)


def mission(page: Page) -> str:
    """Items and when they were reached."""
    return table(("item", "what", "where", "reached, s"), page.mission) if page.mission else _none("None was sailed.")


def events(page: Page) -> str:
    """All events."""
    rows = "".join(
        f"<tr class='{escape(event.severity)}'><td>{event.t_s:.1f}</td>"
        f"<td>{escape(event.severity.lower())}</td><td>{escape(event.text)}</td></tr>"
        for event in page.recorded.events
    )
    return f"<div class='long'><table><tr><th>s</th><th>severity</th><th>text</th></tr>{rows}</table></div>"


def settings(page: Page) -> str:
    """Parameters that differ from the defaults of this vessel's table."""
    config = page.recorded.log.config
    own = Parameters(table=table_of(config))
    rows = []
    for name, value in sorted(page.recorded.log.parameters.items()):
        spec = own.spec(name)
        if spec is None or spec.read_only or abs(value - own.defaults[name]) <= 1e-6 * max(1.0, abs(value)):
            continue
        shown, default = (_shown(number, spec.unit) for number in (value, own.defaults[name]))
        rows.append((name, shown, default, spec.text))
    return table(("parameter", "value", "default", "what it is"), rows) if rows else _none("None.")


SECTIONS: Mapping[str, Callable[[Page], str]] = {
    "Modes and failsafes": timeline,
    "Errors and speeds": errors,
    "Thrusters": thrusters,
    "Estimator and devices": estimator,
    "GNSS": gnss,
    "Wind and current": weather,
    "Battery": battery,
    "Links": links,
    "Mission": mission,
    "Events": events,
    "Settings that differ from the default": settings,
}


def _shown(value: float, unit: str) -> str:
    """A value with its unit, angles in degrees."""
    if unit.startswith("rad"):
        value, unit = float(f"{math.degrees(value):.4g}"), unit.replace("rad", "°", 1)
    return f"{value:.6g} {unit.replace('deg', '°').replace('^2', '²')}".strip()


def _none(text: str) -> str:
    return f"<p class='none'>{escape(text)}</p>"


def _deg(values: Array) -> Array:
    return np.degrees(values)


def _compass(values: Array) -> Array:
    return np.degrees(values) % 360.0


def _where(values: Array, valid: Array) -> Array:
    return np.where(valid > 0.0, values, np.nan)


def _current(columns: Mapping[str, Array]) -> tuple[Array, Array]:
    """Speed, m/s, and direction, °; NaN direction without any current."""
    north, east = columns["current_north_mps"], columns["current_east_mps"]
    speed = np.hypot(north, east)
    return speed, np.where(speed > 1e-6, _compass(np.arctan2(east, north)), np.nan)
