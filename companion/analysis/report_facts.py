"""What a log tells of its run in figures: the verdict lines of a report, errors by mode, use of the thrusters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from companion.analysis.report_data import WATCHED, Array, Recorded
from companion.analysis.svg_chart import clock

_LONGEST_STEP_S = 5.0  # a longer one is a boat that stood still in a stopped process
_LATE_SHARE = 1.5  # of the period, between two ticks
_AT_LIMIT = 0.97
_LASTING_S = 1.0  # a mode whose errors say something
_POSITION_MODES = ("Hold", "Dock", "Circle", "Offboard")


class Level(Enum):
    """How a verdict line looks."""

    GOOD = "good"
    NOTE = "note"
    BAD = "bad"


@dataclass(frozen=True, slots=True)
class Verdict:
    """One line of the first screen."""

    level: Level
    subject: str
    text: str


@dataclass(frozen=True, slots=True)
class ModeErrors:
    """Errors while armed in one mode: (n,) each, absolute, without NaN. `kind`: what they are."""

    mode: str
    kind: str
    unit: str
    values: Array

    def cells(self) -> tuple[str, ...]:
        """For a table: median, 95 %, largest, RMS."""
        rms = math.sqrt(float(np.mean(self.values**2)))
        parts = (*(float(np.percentile(self.values, q)) for q in (50.0, 95.0)), float(np.max(self.values)), rms)
        digits = 3 if self.unit == "m" else 2
        return (self.mode, self.kind, *(f"{value:.{digits}f} {self.unit}" for value in parts))


def position_errors(recorded: Recorded) -> Array:
    """Distance from the desired position, (n,); NaN where there is none."""
    ticks = recorded.ticks
    return np.hypot(ticks["desired_north_m"] - ticks["north_m"], ticks["desired_east_m"] - ticks["east_m"])


def heading_errors(recorded: Recorded) -> Array:
    """Desired less estimated heading, (n,), rad."""
    ticks = recorded.ticks
    return wrapped(ticks["desired_yaw_rad"] - ticks["yaw_rad"])


def wrapped(angle: Array) -> Array:
    """Angles from −π to π."""
    return (angle + math.pi) % math.tau - math.pi


def errors_by_mode(recorded: Recorded) -> list[ModeErrors]:
    """Each kind of error in each mode that has it. Where the boat follows a path, the desired position is the nearest
    one on it, so that only the error across the track says something."""
    armed = recorded.ticks["armed"] > 0.0
    on_path = np.isfinite(recorded.ticks["cross_track_error_m"])
    kinds = (
        ("from the desired position", "m", np.where(on_path, np.nan, position_errors(recorded))),
        ("across the track", "m", np.abs(recorded.ticks["cross_track_error_m"])),
        ("heading", "°", np.abs(np.degrees(heading_errors(recorded)))),
    )
    rows = []
    for number, mode in enumerate(recorded.mode_names):
        here = armed & (recorded.modes == number)
        for kind, unit, values in kinds:
            found = values[here & np.isfinite(values)]
            if len(found) * recorded.period_s > _LASTING_S:
                rows.append(ModeErrors(mode, kind, unit, found))
    return rows


def verdicts(recorded: Recorded, links: Sequence[tuple[str, ...]]) -> list[Verdict]:
    """The lines of the first screen. `links`: rows of the packet counts."""
    lines = [_checks(recorded), _failsafes(recorded), *_errors(recorded), _thrusters(recorded), _battery(recorded)]
    lines += [_links(links), _lateness(recorded), _log(recorded)]
    return [line for line in lines if line is not None]


def _checks(recorded: Recorded) -> Verdict | None:
    result = recorded.result
    if result is None:
        return None
    checks = result.get("checks") or ()
    failed = [check["name"] for check in checks if not check["ok"]]
    if result.get("error"):
        return Verdict(Level.BAD, "scenario", str(result["error"]))
    if failed:
        return Verdict(Level.BAD, "scenario", f"{len(failed)} of {len(checks)} checks fail: {', '.join(failed)}")
    return Verdict(Level.GOOD, "scenario", f"all {len(checks)} checks hold")


def failsafe_times(recorded: Recorded) -> dict[str, float]:
    """How long each failsafe lasted, s."""
    total: dict[str, float] = {}
    for words in recorded.words["failsafes"]:
        for name in filter(None, words.split(";")):
            total[name] = total.get(name, 0.0) + recorded.period_s
    return total


def _failsafes(recorded: Recorded) -> Verdict:
    times = failsafe_times(recorded)
    if not times:
        return Verdict(Level.GOOD, "failsafes", "none")
    text = ", ".join(f"{plain(name)} {duration(seconds)}" for name, seconds in times.items())
    return Verdict(Level.BAD, "failsafes", text)


def _errors(recorded: Recorded) -> list[Verdict]:
    rows = []
    for row in errors_by_mode(recorded):
        wanted = "from the desired position" if row.mode in _POSITION_MODES else "across the track"
        if row.kind == wanted:
            text = f"at most {np.max(row.values):.2f} m {row.kind}, 95 % under {np.percentile(row.values, 95.0):.2f} m"
            rows.append(Verdict(Level.NOTE, f"in {row.mode}", text))
    return rows


def _thrusters(recorded: Recorded) -> Verdict:
    ill = []
    for name in recorded.thrusters:
        words = recorded.words[f"{name}_condition"]
        bad = sorted({word for word in words if word and word not in ("ready", "moving", "retracted")})
        if bad:
            ill.append(f"{name} {', '.join(map(plain, bad))}")
    if ill:
        return Verdict(Level.BAD, "thrusters", "; ".join(ill))
    return Verdict(Level.GOOD, "thrusters", "all ready throughout")


def _battery(recorded: Recorded) -> Verdict:
    ticks = recorded.ticks
    left, volts = ticks["battery_remaining"], ticks["battery_v"]
    parts = []
    if np.any(np.isfinite(left)):
        known = left[np.isfinite(left)]
        parts.append(f"{100.0 * known[0]:.0f} % to {100.0 * known[-1]:.0f} %")
    if (used := charge_used_ah(recorded)) is not None:
        parts.append(f"{used:.2f} Ah used")
    if np.any(np.isfinite(volts)):
        parts.append(f"lowest {np.nanmin(volts):.1f} V")
    return Verdict(Level.NOTE, "battery", ", ".join(parts) if parts else "not measured")


def charge_used_ah(recorded: Recorded) -> float | None:
    """Integral of the current; None where it is not measured."""
    current = recorded.ticks["battery_a"]
    if not np.any(np.isfinite(current)):
        return None
    return float(np.nansum(current[1:] * np.diff(recorded.t_s))) / 3600.0


def _links(links: Sequence[tuple[str, ...]]) -> Verdict:
    heard = [row for row in links if "(this boat)" not in row[0]]
    if not heard:
        return Verdict(Level.NOTE, "links", "nothing was heard")
    lost = [row for row in heard if row[2] not in ("0", "")]
    if not lost:
        return Verdict(Level.GOOD, "links", f"{', '.join(row[0] for row in heard)}: no packet missing")
    text = ", ".join(f"{row[0]}: {row[2]} missing ({row[3]})" for row in lost)
    return Verdict(Level.NOTE, "links", text)


def _lateness(recorded: Recorded) -> Verdict:
    steps = np.diff(recorded.t_s)
    late = int(np.sum(steps > _LATE_SHARE * recorded.period_s))
    known = recorded.ticks["load"][np.isfinite(recorded.ticks["load"])]
    load = float(np.percentile(known, 95.0)) if len(known) else 0.0
    busy = f"load 95 % of the time under {100.0 * load:.0f} %" if len(known) else "load not known"
    if not late and load > 1.0:  # as by a clock of `--speed` alone, against which the load counts
        text = f"the computer was up to {load:.1f} times too slow for `--speed`: the simulation waited for it"
        return Verdict(Level.NOTE, "lateness", text)
    if not late:
        return Verdict(Level.GOOD, "lateness", f"every tick in time; {busy}")
    text = f"{late} of {len(steps)} ticks late, at most {float(np.max(steps)) - recorded.period_s:.2f} s; {busy}"
    return Verdict(Level.BAD if late > 0.001 * len(steps) else Level.NOTE, "lateness", text)


def _log(recorded: Recorded) -> Verdict:
    gaps = [event.text for event in recorded.events if event.name.startswith("log") and event.severity in WATCHED]
    if recorded.warnings or gaps:
        return Verdict(Level.BAD, "log", "; ".join([*recorded.warnings[:2], *gaps[:2]]))
    return Verdict(Level.GOOD, "log", "complete")


def thruster_rows(recorded: Recorded) -> list[tuple[str, ...]]:
    """(name, mean throttle, share at the limit, changes of direction a minute, condition) of each thruster, armed."""
    armed = recorded.ticks["armed"] > 0.0
    minutes = max(1e-9, float(np.sum(armed)) * recorded.period_s / 60.0)
    rows: list[tuple[str, ...]] = []
    for name in recorded.thrusters:
        throttle = recorded.ticks[f"{name}_throttle"][armed]
        throttle = throttle[np.isfinite(throttle)]
        if not len(throttle):
            continue
        signs = np.sign(throttle[np.abs(throttle) > 0.02])
        turns = int(np.sum(np.diff(signs) != 0)) if len(signs) > 1 else 0
        words = recorded.words[f"{name}_condition"]
        share = {word: words.count(word) / len(words) for word in dict.fromkeys(words) if word}
        rows.append(
            (
                name,
                f"{100.0 * float(np.mean(np.abs(throttle))):.0f} %",
                f"{100.0 * float(np.mean(np.abs(throttle) >= _AT_LIMIT)):.1f} %",
                f"{turns / minutes:.1f}",
                ", ".join(f"{plain(word)} {100.0 * part:.0f} %" for word, part in share.items()),
            )
        )
    return rows


def consistency_rows(recorded: Recorded) -> list[tuple[str, ...]]:
    """Estimate against the truth: quantity, RMS, largest, share of the time within one and two of the sigmas that the
    filter believes. Empty without truth."""
    truth, ticks, t = recorded.truth, recorded.ticks, recorded.t_s
    if truth is None:
        return []
    north, east, yaw = (np.interp(t, truth["t_s"], values) for values in _truth_pose(truth))
    rows: list[tuple[str, ...]] = []
    off = np.hypot(ticks["north_m"] - north, ticks["east_m"] - east)
    turned = np.abs(wrapped(ticks["yaw_rad"] - yaw))
    for name, unit, scale, error, sigma, valid in (
        ("position", "m", 1.0, off, math.sqrt(2.0) * ticks["position_accuracy_m"], ticks["position_valid"] > 0.0),
        ("heading", "°", math.degrees(1.0), turned, ticks["heading_accuracy_rad"], ticks["heading_valid"] > 0.0),
    ):
        known = valid & np.isfinite(error) & np.isfinite(sigma)
        if np.any(known):
            e, s = error[known], sigma[known]
            within = (f"{100.0 * float(np.mean(e <= k * s)):.0f} %" for k in (1.0, 2.0))
            rms = math.sqrt(float(np.mean(e**2)))
            rows.append((name, f"{scale * rms:.3f} {unit}", f"{scale * float(np.max(e)):.3f} {unit}", *within))
    return rows


def _truth_pose(truth: object) -> tuple[Array, Array, Array]:
    assert isinstance(truth, dict)
    return truth["north_m"], truth["east_m"], np.unwrap(truth["yaw_rad"])


def duration(seconds: float) -> str:
    """A span of time for people."""
    return f"{seconds:.0f} s" if seconds < 60.0 else f"{clock(seconds)} min" if seconds < 3600.0 else clock(seconds)


def plain(name: str) -> str:
    """A name for programs as words."""
    return name.replace("_", " ")


def distance_m(recorded: Recorded) -> float:
    """Way over ground while the boat was armed and its position valid, as the end of a run tells it."""
    ticks = recorded.ticks
    step_s = np.minimum(np.diff(recorded.t_s, prepend=recorded.t_s[0]), _LONGEST_STEP_S)
    sails = (ticks["armed"] > 0.0) & (ticks["position_valid"] > 0.0)
    return float(np.nansum((step_s * np.hypot(ticks["surge_mps"], ticks["sway_mps"]))[sails]))


def mode_times(recorded: Recorded) -> dict[str, float]:
    """Seconds in each mode."""
    period = np.diff(recorded.t_s, prepend=recorded.t_s[0])
    return {name: float(np.sum(period[recorded.modes == n])) for n, name in enumerate(recorded.mode_names)}
