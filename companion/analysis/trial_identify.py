"""A Trial's log → an overlay of the vessel's file: hull, thrusters, windage, bandwidths, and how far to trust them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from pathlib import Path

import numpy as np

from companion.analysis.gains import NEEDED, Design, designed
from companion.analysis.held_out import Prediction, prediction, split
from companion.analysis.hull_fit import HullFit, fit
from companion.analysis.hull_model import COUPLING, HEADING, INERTIA, HullModel
from companion.analysis.identify import advice, plot, report
from companion.analysis.log_reader import Log, LogError, parameters_of
from companion.analysis.manoeuvre import Manoeuvre, read_manoeuvre
from companion.analysis.trial_checks import DEAD_BAND, PLACE_AHEAD, PLACE_ASIDE, Check, checks
from companion.analysis.trial_log import Ran, manoeuvres
from companion.config.devices import SensorConfig, ThrusterConfig
from companion.config.dimensions.limits import figures
from companion.config.hull import DampingConfig, WindageConfig
from companion.config.overlay import free_place
from companion.config.rudder import RudderConfig
from companion.config.top_speed import steady_speed_mps
from companion.config.vessel import LimitsConfig, VesselConfig
from companion.core.progress import Told, part, tell_nobody
from companion.params.store import Parameters
from companion.record.replacing import replace_file

_NINETY_FIVE = 1.96  # sigmas of a 95 % interval
_READ, _FITTED = 0.1, 0.9  # shares of the whole after which the log is read, and the hull fitted
_BETTER = 0.9  # of the old model's prediction error, from which the new model is worth having
_SAME_SHARE = 0.01  # a limit that changes by less stays
_WIND_SCALES = ("wind_surge_scale", "wind_sway_scale")


@dataclass(frozen=True, slots=True)
class HeadingError:
    """By how much the heading reads too much, and half its 95 % interval, in rad."""

    error_rad: float
    interval_rad: float

    @property
    def counts(self) -> bool:
        """Whether it is other than zero, as far as the log tells."""
        return abs(self.error_rad) > max(self.interval_rad, math.radians(1.0))


@dataclass(frozen=True, slots=True)
class TrialIdentification:
    """`overlay`: its text. `better`: whether the held-out part of the log speaks for it; if not, the overlay has no
    hull. `values`, `model`: all quantities of the fit, after and before."""

    log: Log
    fit: HullFit
    ran: tuple[Ran, ...]
    prediction: Prediction | None
    designs: tuple[Design, ...]
    checks: tuple[Check, ...]
    heading: HeadingError | None
    manoeuvre: Manoeuvre
    values: Mapping[str, float]
    model: HullModel
    overlay: str
    text: str
    warnings: tuple[str, ...]

    @property
    def better(self) -> bool:
        """Whether the new model predicts better than the old one."""
        return _is_better(self.prediction)


def _is_better(compared: Prediction | None) -> bool:
    return compared is not None and compared.ratio < _BETTER


def identify_trial(log: Log, hold: Sequence[str] = (), told: Told = tell_nobody) -> TrialIdentification:
    """Fit, compare on the part that was held out, and design the bandwidths.

    Raises LogError for a log that is too short or a boat that cannot be fitted, OSError.
    """
    warnings: list[str] = []
    sailed, log = log.config.hull, log.bare
    told("reading the log", 0.0)
    ran = manoeuvres(log.folder)
    whole = read_manoeuvre(log, warnings)
    fitted, held_out = split(whole, ran)
    if not fitted.stretches:
        raise LogError(f"{log.folder}: nothing is left to fit beside what is held out; sail longer")
    found = fit(log, fitted, hold, mounting=True, told=part(told, _READ, _FITTED))
    told("designing the gains", _FITTED)
    values = {estimate.name: estimate.value for estimate in found.estimates}
    model = HullModel(log, whole, mounting=True)
    unknown = [name for name in hold if name not in model.model]
    if unknown:
        raise LogError(f"nothing named {', '.join(unknown)} to hold; there is {', '.join(model.model)}")
    compared = prediction(log, held_out, model.model, values)
    if compared is None:
        warnings.append("the log is too short to judge the new model, so that of before stays: sail longer")
    parameters = parameters_of(log, warnings)
    boat, hull = log.config, sailed
    if _is_better(compared):
        boat, hull = replace(boat, limits=rescaled(boat.limits, boat.thrusters, found.thrusters)), found.hull
    designs = designed(boat, hull, values["lag_s"], {name: parameters[name] for name in NEEDED})
    heading = _heading_error(found)
    warnings += advice(model, found)
    if _is_better(compared):
        warnings += _course(replace(boat, hull=hull, thrusters=tuple(found.thrusters)), parameters)
    checked = _checks(model, found, ran, warnings)
    made = TrialIdentification(
        log, found, ran, compared, designs, checked, heading, whole, values, model, "", "", tuple(warnings)
    )
    return replace(made, overlay=_overlay(made), text=_text(made))


def _course(boat: VesselConfig, parameters: Parameters) -> list[str]:
    """Says that the hull leaves its course by itself at the speed of missions."""
    steady = steady_speed_mps(boat)
    if parameters["WP_SPEED"] <= steady:
        return []
    return [
        f"beyond {steady:.2f} m/s the hull leaves its course faster than the thrusters can turn it back: missions "
        f"weave at WP_SPEED {parameters['WP_SPEED']:.2f}. Once the trial counts, WP_SPEED and MPC_XY_VEL_MAX follow, "
        "unless the vessel's file sets them"
    ]


def _checks(model: HullModel, found: HullFit, ran: Sequence[Ran], warnings: list[str]) -> tuple[Check, ...]:
    """What the log says beside the hull; a warning, where that cannot be made out."""
    try:
        return checks(model, found, ran, warnings)
    except (LogError, OSError, ValueError, np.linalg.LinAlgError) as error:
        warnings.append(f"dead band, lever arms and accelerometer are not checked: {error}")
        return ()


def _heading_error(found: HullFit) -> HeadingError | None:
    """The heading's error of the fit; None where the log does not tell."""
    estimate = next((one for one in found.estimates if one.name == HEADING), None)
    if estimate is None or estimate.sigma is None:
        return None
    return HeadingError(estimate.value, _NINETY_FIVE * estimate.sigma)


# --- what is written ------------------------------------------------------------------------------------------------


def _overlay(found: TrialIdentification) -> str:
    """The overlay as TOML: hull and thrusters if they predict better, and the bandwidths that go with them."""
    config, fitted = found.log.config, found.fit
    lines = [
        f"# {config.title}: what the trial in {found.log.folder.name} found. 95 % intervals.",
        "# It counts while `accepted` is true: `companion trial accept FILE`, `companion trial undo VESSEL`.",
        "[trial]",
        "accepted = false",
        f'vessel = "{config.name}"',
        f'log = "{found.log.folder.name}"',
    ]
    if not found.better:
        lines.append("# The model of before stays: the new one predicts no better. What changes are the bandwidths.")
        return "\n".join([*lines, *_parameters(found)]) + "\n"
    sigmas = {estimate.name: estimate.sigma for estimate in fitted.estimates}
    lines += ["", "[hull]"]
    lines += [_row(name, getattr(fitted.hull, name), sigmas[name]) for name in (*INERTIA, COUPLING)]
    lines += [_row("m32_kgm", fitted.hull.m32_kgm, sigmas[COUPLING])] if fitted.hull.m32_kgm is not None else []
    lines += ["[hull.damping]"]
    terms = [name for name in DampingConfig.__slots__ if name in sigmas]
    lines += [_row(name, getattr(fitted.hull.damping, name), sigmas[name]) for name in terms]
    lines += _windage(config.windage, found.values, sigmas)
    limits = rescaled(config.limits, config.thrusters, fitted.thrusters)
    lines += ["", "[limits]", *(f"{name} = {value:g}" for name, value in asdict(limits).items())]
    for before, after in zip(config.thrusters, fitted.thrusters, strict=True):
        lines += ["", "[[thruster]]", f'name = "{before.name}"']
        lines += [f"{name} = {getattr(after, name):.4g}" for name in ("x_m", "max_n", "min_n", "ahead_n", "astern_n")]
        if before.rudder is not None and after.rudder is not None:
            lines.append(f"rudder = {{ {_blade(after.rudder)} }}")
        lines += band_row(before.dead_band, found.checks)
    error_rad = found.heading.error_rad if found.heading is not None and found.heading.counts else 0.0
    lines += sensor_rows(config.sensors, found.checks, error_rad)
    return "\n".join([*lines, *_parameters(found)]) + "\n"


def _parameters(found: TrialIdentification) -> list[str]:
    """The bandwidths."""
    return ["", "[parameters]", *(f"{design.name} = {design.value:g}" for design in found.designs)]


def _blade(rudder: RudderConfig) -> str:
    """What the fit finds of a rudder."""
    return ", ".join(f"{name} = {getattr(rudder, name):.4g}" for name in ("x_m", "lift_scale", "race_gain"))


def _row(name: str, value: float, sigma: float | None, without: str = "the log says little") -> str:
    doubt = without if sigma is None else f"± {_NINETY_FIVE * sigma:.2g}"
    return f"{f'{name} = {value:.5g}':28}# {doubt}"


def _windage(windage: WindageConfig, values: Mapping[str, float], sigmas: Mapping[str, float | None]) -> list[str]:
    """The areas: as a wind sensor has told, else as they were, since an overlay accepted before gives way to this."""
    areas = ("frontal_m2", "lateral_m2")
    if any(name not in values for name in _WIND_SCALES):
        kept = [_row(area, getattr(windage, area), None, "as it was") for area in areas if getattr(windage, area) > 0.0]
        return ["", "[windage]", *kept] if kept else []
    rows = [
        _row(area, size * values[scale], None if sigmas[scale] is None else size * (sigmas[scale] or 0.0))
        for area, size, scale in zip(
            ("frontal_m2", "lateral_m2"), (windage.frontal_m2, windage.lateral_m2), _WIND_SCALES, strict=True
        )
        if values[scale] > 0.0
    ]
    return ["", "[windage]", *rows] if rows else []


def band_row(band: float, checks: Sequence[Check]) -> list[str]:
    """The line of a thruster's dead band: as the log tells it, else as it was."""
    check = next((one for one in checks if one.name == DEAD_BAND and one.differs), None)
    band = band if check is None else check.value
    return [f"dead_band = {band:.3f}"] if band or check is not None else []


def rescaled(
    limits: LimitsConfig, before: tuple[ThrusterConfig, ...], after: tuple[ThrusterConfig, ...]
) -> LimitsConfig:
    """The limits of the wrench: each by as much other than before as what the thrusters give together on its axis, with
    their forces, places and blades."""
    kept = []
    for limit, then, now in zip(astuple(limits), figures(before), figures(after), strict=True):
        ratio = now.value / then.value if then.value > 0.0 else 1.0
        kept.append(limit if abs(ratio - 1.0) < _SAME_SHARE else float(f"{ratio * limit:.4g}"))
    return LimitsConfig(*kept)


def sensor_rows(sensors: Sequence[SensorConfig], checks: Sequence[Check], error_rad: float) -> list[str]:
    """Lines of the overlay for the sensors: places that the log tells to be others than the file's, and the offset of
    what gives the heading, which reads too much by `error_rad`; else all as it was, since an overlay accepted before
    gives way to this."""
    lines = []
    for sensor in sensors:
        gives = sensor.heading != "none" or (sensor.driver == "nmea0183" and sensor.antennas == 2)
        rows = _place(checks, sensor)
        if gives and (sensor.heading_offset_rad or error_rad):
            offset = math.degrees(sensor.heading_offset_rad - error_rad)
            rows.append(f"heading_offset_deg = {offset:.2f}")
        if rows:
            lines += ["", "[[sensor]]", f'name = "{sensor.name}"', *rows]
    return lines


def _place(checks: Sequence[Check], sensor: SensorConfig) -> list[str]:
    """Where a sensor is, on the axes on which the log tells that it is elsewhere than the file says."""
    rows = []
    for key, where, file in (("x_m", PLACE_AHEAD, sensor.x_m), ("y_m", PLACE_ASIDE, sensor.y_m)):
        check = next((one for one in checks if one.name == f"{sensor.name}: {where}"), None)
        if check is not None and check.differs:
            rows.append(f"{f'{key} = {check.value:.3f}':28}# ± {check.interval:.2g}; the file has {check.file:.3g}")
        elif check is not None and file:
            rows.append(f"{f'{key} = {file:.3f}':28}# as it was")
    return rows


def _text(found: TrialIdentification) -> str:
    """All of it for a person."""
    lines = [report(found.fit, found.manoeuvre), ""]
    if found.prediction is not None:
        p = found.prediction
        lines.append(
            f"predicted over 10 s: error {p.before:.3f} with the old model, {p.after:.3f} with the new one "
            f"({p.ratio:.2f} of it)"
        )
        for axis, unit, old, new in zip(
            ("surge", "sway", "yaw rate"), ("m/s", "m/s", "rad/s"), p.axes_before, p.axes_after, strict=True
        ):
            lines.append(f"  {axis}: {old:.4f} -> {new:.4f} {unit} RMS")
    lines += [check.text for check in found.checks]
    lines += [design.text for design in found.designs]
    return "\n".join(lines)


def write(
    found: TrialIdentification, folder: Path, stem: str, date: str, pictures: Path | None = None
) -> tuple[Path, Path | None]:
    """Write the overlay `stem.trial-date.toml` into `folder`, the picture into `pictures` or the log folder: (overlay,
    picture; None without matplotlib). Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    overlay = free_place(folder, stem, date)
    replace_file(folder, overlay.name, found.overlay.encode())  # half an overlay could be accepted
    picture: Path | None = (pictures or found.log.folder) / "identified.png"
    try:
        assert picture is not None
        plot(found.model, replace(found.fit, simulated=found.model.simulate(found.values)), picture)
    except ImportError:
        picture = None
    return overlay, picture
