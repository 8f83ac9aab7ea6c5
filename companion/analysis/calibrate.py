"""Turns in a log → `mag_offset` and `mag_matrix` of a magnetometer, as lines for the vessel's TOML, and a plot."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from companion.analysis.figure import MATPLOTLIB_MISSING, new_figure
from companion.analysis.log_reader import LogError, SensedBoat, SensorLog, parameters_of
from companion.config.devices import SensorConfig
from companion.core.geomagnetism import decimal_year, field_nt
from companion.core.readings import FixType, GnssFix, Imu, MagneticField, Reading, TimeOfDay
from companion.nav.compass_turns import GOOD_RAD, PASSES, TiltPass, Turns, TurnsError, fit_turns, left_rad, wander_rad
from companion.nav.field_fit import SECTORS, FieldFit, headings
from companion.nav.lever_arms import lever_arms, normal_gravity_mps2
from companion.nav.mounting import Mounting
from companion.record.readings import path_in, read_kind

TOML_FILE = "magnetometer.toml"
PLOT_FILE = "magnetometer.png"
_SAMPLES = 3000


@dataclass(frozen=True, slots=True)
class Calibration:
    """`fit`: in the magnetometer's own axes. `report`: for a person; `toml`: for the sensor's table; `plot`: None where
    matplotlib is not installed."""

    fit: FieldFit
    report: str
    toml: str
    plot: Path | None
    warnings: tuple[str, ...]


def calibrate(
    log: SensorLog, out: Path, sensor: str | None = None, from_s: float = 0.0, to_s: float = math.inf
) -> Calibration:
    """Fit, and write `magnetometer.toml` and `magnetometer.png` into `out`.

    `sensor`: the magnetometer's name, needed where the log has several. Raises LogError for an unsuitable log, OSError.
    """
    warnings: list[str] = []
    row, own = _readings(log, sensor, from_s, to_s, warnings)
    lat_deg, dip_rad = _latitude_and_dip(log, warnings)
    mounting = _mounting(log, row, warnings)
    readings = [_turned(reading, mounting) for reading in own]
    gravity = normal_gravity_mps2(lat_deg)
    turns = _tilts(log, row, readings, gravity, dip_rad, None)
    found = _fit(turns)
    for _ in range(PASSES):
        turns = _tilts(log, row, readings, gravity, dip_rad, found)
        found = _fit(turns)
    warnings += _doubts(found)
    turn = mounting.compass(row.name)
    in_own_axes = found if turn is None else found.before_turn(turn)
    toml = toml_lines(log, row, in_own_axes)
    out.mkdir(parents=True, exist_ok=True)
    (out / TOML_FILE).write_text(toml, encoding="utf-8")
    plotted: Path | None = out / PLOT_FILE
    try:
        plot(turns, found, out / PLOT_FILE)
    except ImportError:
        plotted = None
        warnings.append(f"no plot: {MATPLOTLIB_MISSING}")
    return Calibration(in_own_axes, report(row, turns, found), toml, plotted, tuple(warnings))


def _mounting(log: SensorLog, row: SensorConfig, warnings: list[str]) -> Mounting:
    """How the parameters turn the devices once the lines are in the vessel's file, so that the row is numbered."""
    sensors = tuple(replace(one, heading="ahrs") if one.name == row.name else one for one in log.config.sensors)
    return Mounting(SensedBoat(log.config.home, sensors), parameters_of(log, warnings))


def _turned(reading: Reading, mounting: Mounting) -> Reading:
    """The reading in the boat's axes, as the parameters turn its device."""
    if isinstance(reading, Imu):
        return mounting.turned(reading)
    return mounting.field(reading) if isinstance(reading, MagneticField) else reading


def _readings(
    log: SensorLog, sensor: str | None, from_s: float, to_s: float, warnings: list[str]
) -> tuple[SensorConfig, list[Reading]]:
    """The sensor's row, and its readings and all velocities in order of time."""
    path = path_in(log.folder)
    fields = read_kind(path, "field", warnings)
    names = sorted({reading.source for reading in fields})
    if not names:
        raise LogError(
            f"{path}: no magnetic field in this log. With heading = 'ahrs' the inertial sensor must send it "
            "(MTData2: add Magnetic Field to its output); with 'magnetic' or 'true' it makes the heading itself, and "
            "its maker's program calibrates it"
        )
    if sensor is None and len(names) > 1:
        raise LogError(f"several magnetometers: choose one with --sensor {' or --sensor '.join(names)}")
    name = sensor or names[0]
    row = next((row for row in log.config.sensors if row.name == name), None)
    if row is None or name not in names:
        raise LogError(f"no magnetometer named '{name}' in this log; there is {', '.join(names)}")
    own = [reading for reading in (*fields, *read_kind(path, "imu", warnings)) if reading.source == name]
    if not any(isinstance(reading, Imu) for reading in own):
        raise LogError(f"{path}: no accelerations of '{name}', so its tilt is not known")
    chosen = [r for r in (*own, *read_kind(path, "velocity", warnings)) if from_s <= r.t_s <= to_s]
    chosen.sort(key=lambda reading: reading.t_s)
    return row, chosen


def _latitude_and_dip(log: SensorLog, warnings: list[str]) -> tuple[float, float]:
    """(latitude in degrees, dip of the Earth's field in rad, positive down) where the log was made."""
    path = path_in(log.folder)
    place = log.config.home.lat_deg, log.config.home.lon_deg
    for fix in read_kind(path, "gnss", warnings):
        if isinstance(fix, GnssFix) and fix.fix >= FixType.FIX_2D:
            place = fix.lat_deg, fix.lon_deg
            break
    time_ns = next(
        (reading.time_unix_ns for reading in read_kind(path, "time", warnings) if isinstance(reading, TimeOfDay)), None
    )
    north, east, down = field_nt(*place, decimal_year(time_ns))
    return place[0], math.atan2(down, math.hypot(north, east))


def _tilts(
    log: SensorLog, row: SensorConfig, readings: list[Reading], gravity: float, dip_rad: float, rough: FieldFit | None
) -> Turns:
    """One pass of the log through an AHRS."""
    levers = lever_arms(log.config.sensors)
    tilts = TiltPass(levers[row.name], levers, gravity, rough)
    for reading in readings:
        tilts.take(reading)
    try:
        return tilts.turns(dip_rad, _SAMPLES)
    except TurnsError as error:
        raise LogError(str(error)) from error


def _fit(turns: Turns) -> FieldFit:
    try:
        return fit_turns(turns)
    except TurnsError as error:
        raise LogError(f"{error}: sail two slow circles to each side") from error


def _doubts(found: FieldFit) -> list[str]:
    doubts = []
    if found.flat:
        doubts.append(
            "the boat did not tilt enough to determine the vertical part: fitted in the plane, with the vertical "
            "offset from the World Magnetic Model. The heading is good while the boat is about as level as here. "
            "For more, heel and pitch by 10° while turning (crew to one side, then the other)"
        )
    if left_rad(found) > GOOD_RAD:
        doubts.append(
            f"{math.degrees(left_rad(found)):.1f}° of deviation remain: "
            "iron that moves, currents that change, or another hull close by?"
        )
    return doubts


def report(row: SensorConfig, turns: Turns, found: FieldFit) -> str:
    """What was fitted and the residuals, for a person."""
    before = float(np.sqrt(np.nanmean((found.deviation_before_rad - np.nanmean(found.deviation_before_rad)) ** 2)))
    kind = "in the plane (flat circle)" if found.flat else "ellipsoid"
    tilt = np.degrees(np.ptp(turns.tilt, axis=0))
    return "\n".join(
        [
            f"{row.name}: {len(turns.t_s)} samples over {turns.t_s[-1] - turns.t_s[0]:.0f} s, "
            f"roll over {tilt[0]:.0f}°, pitch over {tilt[1]:.0f}°; fit: {kind}",
            f"strength of the field: {found.residual:.2%} RMS left of {found.before:.1%}",
            f"deviation of the heading: about {math.degrees(left_rad(found)):.1f}° RMS "
            f"left of {math.degrees(before):.0f}°",
            f"offset known to {found.offset_sigma:.2%} of the field",
        ]
    )


def toml_lines(log: SensorLog, row: SensorConfig, found: FieldFit) -> str:
    """Lines for the sensor's table in the vessel's file."""
    wander_deg = math.degrees(wander_rad(found))
    rows = ", ".join("[" + ", ".join(f"{value:.6g}" for value in line) + "]" for line in found.matrix.tolist())
    return "\n".join(
        [
            f"# magnetometer of '{row.name}', calibrated from {log.folder.name}"
            f"{', in the plane only' if found.flat else ''}",
            'heading = "ahrs"',
            f"heading_wander_deg = {wander_deg:.1f}",
            f"mag_offset = [{', '.join(f'{value:.6g}' for value in found.offset.tolist())}]",
            f"mag_matrix = [{rows}]",
            "",
        ]
    )


def plot(turns: Turns, found: FieldFit, path: Path) -> None:
    """Write a picture: the field from above, its strength, and the deviation over heading, before and after.

    Raises ImportError without matplotlib.
    """
    figure = new_figure(13.0, 5.0)
    above, strength, deviation = figure.subplots(1, 3)
    true = (turns.field - found.offset) @ found.matrix
    raw = turns.field / np.median(np.linalg.norm(turns.field, axis=1))
    heading, length = headings(true, turns.tilt)
    level = math.cos(turns.dip_rad)
    round_ = np.linspace(0.0, 2.0 * math.pi, 100)
    above.plot(raw[:, 1], raw[:, 0], ".", markersize=1.5, color="tab:gray", label="measured")
    above.plot(
        -length * np.sin(heading),
        length * np.cos(heading),
        ".",
        markersize=1.5,
        color="tab:blue",
        label="calibrated, levelled",
    )
    above.plot(level * np.sin(round_), level * np.cos(round_), color="tab:orange", linewidth=0.8, label="the Earth's")
    above.set_aspect("equal")
    above.set_xlabel("starboard")
    above.set_ylabel("ahead")
    for values, color, label in ((raw, "tab:gray", "measured"), (true, "tab:blue", "calibrated")):
        strength.plot(turns.t_s, np.linalg.norm(values, axis=1), color=color, linewidth=0.7, label=label)
    strength.set_xlabel("time, s")
    strength.set_ylabel("strength of the field")
    at = (np.arange(SECTORS) + 0.5) * 360.0 / SECTORS
    before = found.deviation_before_rad - np.nanmean(found.deviation_before_rad)
    deviation.plot(at, np.degrees(before), ".-", color="tab:gray", label="measured")
    deviation.plot(at, np.degrees(found.deviation_rad), ".-", color="tab:blue", label="calibrated")
    deviation.set_xlabel("magnetic heading, °")
    deviation.set_ylabel("length of the level field, as a heading error, °")
    for axes in (above, strength, deviation):
        axes.grid(alpha=0.3)
        axes.legend(loc="upper right", fontsize=8)
    figure.savefig(path, dpi=80)
