"""`companion new FILE`: a vessel's file from what a person can measure, by questions or by options."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from companion.cli.common import UsageError, typed
from companion.cli.drawing import characters
from companion.cli.new_file import BOARDS, FORMS, LAYOUTS, RECEIVERS, Answers, file_text
from companion.config.dimensions import motors
from companion.config.dimensions.completion import figures_of
from companion.config.dimensions.derivation import top_speed_mps
from companion.config.plausibility import judgements
from companion.config.vessel import ConfigError, VesselConfig, parse

Known = Mapping[str, Any]
_T = TypeVar("_T")
_FILE = "file"  # what is known before any question: the file's name without its end


@dataclass(frozen=True, slots=True)
class Question:
    """One thing to know. `default` None: it must be answered; `when`: whether it is asked, by what is known so far."""

    key: str
    text: str
    read: Callable[[str], Any]
    default: Callable[[Known], Any] | None = None
    when: Callable[[Known], bool] = lambda known: True


_UNIT = re.compile(r"\s*(m/s|m|kg|V|N|deg|°)$")
_LENGTHS = {"cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
_MASSES = {"lb": 0.45359, "lbs": 0.45359, "t": 1000.0}
_SPEEDS = {"km/h": 1.0 / 3.6, "kn": 0.51444, "knots": 0.51444}


def _read_number(text: str) -> float:
    """A number as people write it: with a decimal comma, with its unit."""
    try:
        return float(_UNIT.sub("", text).replace(",", "."))
    except ValueError:
        raise ValueError("a number, such as 1.2") from None


def _number(text: str) -> float:
    value = _read_number(text)
    if not math.isfinite(value) or value <= 0.0:
        raise ValueError("a number above 0")
    return value


def _in_units(others: Mapping[str, float]) -> Callable[[str], float]:
    """Reads a number in the question's unit, or in another one of `others` (SI for each of it) that is written out."""

    def read(text: str) -> float:
        value, _, unit = text.rpartition(" ") if " " in text else ("", "", "")
        if not value and (found := re.fullmatch(r"([\d.,]+)([a-z/]+)", text)):
            value, unit = found[1], found[2]
        return float(f"{_number(value) * others[unit]:.6g}") if unit in others else _number(text)

    return read


_metres, _kilograms, _speed = _in_units(_LENGTHS), _in_units(_MASSES), _in_units(_SPEEDS)


def _or_unknown(read: Callable[[str], _T]) -> Callable[[str], _T | None]:
    return lambda text: None if text in ("", "-") else read(text)


def _degrees(text: str) -> float:
    value = _read_number(text)
    if not abs(value) <= 180.0:
        raise ValueError("degrees, such as 63.442; south and west negative")
    return value


def _one_of(words: Mapping[str, str] | tuple[str, ...]) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in words:
            raise ValueError(f"one of {', '.join(words)}")
        return text

    return read


def _motor(text: str) -> str:
    if re.fullmatch(r"-?[\d.,]+(e\d+)?\s*N?", text):
        return f"{_number(text):g}"
    if motors.find(text) is None:
        if re.fullmatch(r"[\d.]+ *lbs?", text.lower()):
            raise ValueError(f"of a trolling motor it is 'trolling {text}'; else give its thrust in N")
        raise ValueError(motors.unknown_motor(text).replace("or give max_n", "or give its thrust in N"))
    return text


def _in_newtons(motor: str | None) -> bool:
    """Whether that answer is a thrust, or none."""
    return motor is None or re.fullmatch(r"[\d.]+", motor) is not None


def _name(text: str) -> str:
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,31}", text):
        raise ValueError("small letters, digits and _, from a letter on")
    return text


def _short_name(known: Known) -> str:
    """The file's name as a short name."""
    plain = re.sub(r"[^a-z0-9]+", "_", known[_FILE].lower()).strip("_0123456789")
    return plain[:32] or "boat"


def _choices(words: Mapping[str, str]) -> str:
    """One line each."""
    return "".join(f"\n  {word}: {text}" for word, text in words.items()) + "\n"


QUESTIONS: tuple[Question, ...] = (
    Question("name", "Short name", _name, _short_name),
    Question("title", "Name for people", str, lambda known: str(known["name"]).replace("_", " ")),
    Question("form", f"Form of the hull:{_choices(FORMS)}which", _one_of(FORMS)),
    Question("length_m", "Length of the waterline, m", _metres),
    Question("beam_m", "Width over all, m", _metres),
    Question("mass_kg", "Mass afloat with batteries, kg", _kilograms),
    Question(
        "hull_beam_m",
        "Width of one of the two hulls at the waterline, m",
        _metres,
        when=lambda known: known["form"] == "catamaran",
    ),
    Question("draft_m", "Depth below the water, m (- if unknown)", _or_unknown(_metres), lambda known: None),
    Question("top_speed_mps", "Top speed, m/s (- if unknown)", _or_unknown(_speed), lambda known: None),
    Question("layout", f"Thrusters:{_choices(LAYOUTS)}which", _one_of(LAYOUTS), lambda known: "twin"),
    Question(
        "motor",
        "Motor of each thruster (T200, trolling 55 lb …), or its largest thrust in N; of a jet its pull in N",
        _motor,
    ),
    Question(
        "bow_motor",
        "Motor of the thruster across the bow, or its largest thrust in N (- as the others)",
        _or_unknown(_motor),
        lambda known: None,
        lambda known: str(known["layout"]).endswith("-bow"),
    ),
    Question(
        "voltage_v",
        "Voltage at the motor, V (- if unknown)",
        _or_unknown(_number),
        lambda known: None,
        lambda known: any(not _in_newtons(known[key]) for key in ("motor", "bow_motor")),
    ),
    Question(
        "spread_m",
        "Distance from the port to the starboard thrusters, m",
        _metres,
        lambda known: round(known["beam_m"] - (known.get("hull_beam_m") or 0.3 * known["beam_m"]), 3),
        lambda known: known["layout"] in ("twin", "twin-bow", "vectored", "two-rudders"),
    ),
    Question(
        "rudder_span_m",
        "Height of the rudder blade, m (- if unknown)",
        _or_unknown(_metres),
        lambda known: None,
        lambda known: "rudder" in str(known["layout"]),
    ),
    Question(
        "rudder_chord_m",
        "Width of the rudder blade, fore and aft, m (- if unknown)",
        _or_unknown(_metres),
        lambda known: None,
        lambda known: "rudder" in str(known["layout"]),
    ),
    Question(
        "nozzle_m",
        "Inner diameter of the jet's nozzle, m (- if unknown)",
        _or_unknown(_metres),
        lambda known: None,
        lambda known: known["layout"] == "jet",
    ),
    Question(
        "board", f"What drives the motors:{_choices(BOARDS)}which", _one_of(BOARDS), lambda known: "microcontroller"
    ),
    Question("receiver", f"Satellite receiver:{_choices(RECEIVERS)}which", _one_of(RECEIVERS), lambda known: "one"),
    Question("lat_deg", "Latitude of its home, degrees", _degrees, lambda known: 63.442),
    Question("lon_deg", "Longitude of its home, degrees", _degrees, lambda known: 10.4),
)


def _option(key: str) -> str:
    return "--" + re.sub(r"_(m|kg|mps|v|deg)$", "", key).replace("_", "-")


_OPTION_OF = {
    **{question.key: _option(question.key) for question in QUESTIONS},
    "thruster[1].jet": "--nozzle",
    "thruster[1].rudder.chord_m": "--rudder-chord",
}


_INERTIA = {
    "hull.m11_kg": ("mass with the water it drags along, ahead", "kg"),
    "hull.m22_kg": ("the same, sideways", "kg"),
    "hull.m33_kgm2": ("the same, turning", "kg m²"),
}
_WIDTH = 41


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    new = commands.add_parser("new", help="write a vessel's file from what you can measure, by questions or options")
    new.add_argument("file", type=Path, metavar="FILE", help="the TOML file to write; it must not exist yet")
    for question in QUESTIONS:
        new.add_argument(_option(question.key), dest=question.key, metavar="VALUE", help=_as_help(question.text))
    new.add_argument("--yes", action="store_true", help="ask nothing: what is not given takes its default")
    new.set_defaults(command=_new)


def _as_help(text: str) -> str:
    """A question in running text: its choices behind one another."""
    asked, *choices = text.split("\n")
    return asked + " " * bool(choices) + "; ".join(re.sub(r"^ *(\S+): (.*)", r"\1 (\2)", line) for line in choices[:-1])


def _new(arguments: argparse.Namespace) -> int:
    """Exit code 0 where the file was written, 1 where it was declined."""
    if arguments.file.exists():
        raise UsageError(f"{arguments.file}: exists already; choose another name")
    folder = arguments.file.absolute().parent
    if not folder.is_dir():
        raise UsageError(f"{folder}: no such folder; make it first")
    if not os.access(folder, os.W_OK):
        raise UsageError(f"{folder}: you may not write there; choose another folder")
    try:
        return _written(arguments, asks=not arguments.yes and sys.stdin.isatty())
    except EOFError as error:  # Ctrl-D in place of an answer
        raise UsageError("new: the answers ended; nothing was written") from error


def _written(arguments: argparse.Namespace, asks: bool) -> int:
    text, config = _boat(arguments, asks)
    print(characters(config))
    print()
    for line in summary(config):
        print(line)
    if asks and not _confirmed(f"Write {arguments.file}?"):
        return 1
    arguments.file.write_text(text, encoding="utf-8")
    print(f"{arguments.file}: written. Next: {typed('check', arguments.file)}")
    print(f"and, to sail it in simulation: {typed('run', arguments.file, '--sitl')}")
    return 0


def _boat(arguments: argparse.Namespace, asks: bool) -> tuple[str, VesselConfig]:
    """The file's text and its vessel. Whoever is asked answers again, from what they said, where no boat follows from
    it; else raises UsageError."""
    known = _answers(arguments, asks)
    while True:
        text = file_text(Answers(**{question.key: known[question.key] for question in QUESTIONS}))
        try:
            return text, _checked(text)
        except UsageError as error:
            if not asks:
                raise
            print(f"\n{error}\nOnce more; an empty line keeps what you said.\n")
            known = _asked_again(known)


def _checked(text: str) -> VesselConfig:
    """The vessel of a file that is not written yet. Raises UsageError with the option that each fault comes from."""
    try:
        return parse(text, "")
    except ConfigError as error:
        raise UsageError("\n".join(f"new: {_as_option(problem)}" for problem in error.problems)) from error


def _as_option(problem: str) -> str:
    """A fault of a file without its place there, and with the option in place of the key."""
    key, _, said = re.sub(r"^:\d*:? *", "", problem).partition(": ")
    option = _OPTION_OF.get(re.sub(r"^(hull|home)\.", "", key))
    return f"{option or key}: {said}"


def summary(config: VesselConfig) -> list[str]:
    """What follows from the answers, with its uncertainty, and what is implausible."""
    lines = []
    for figure in figures_of(config.hull, config.thrusters):
        if figure.key in _INERTIA:
            low, high = figure.value / figure.factor, figure.value * figure.factor
            what, unit = _INERTIA[figure.key]
            value, least, most = map(_three_digits, (figure.value, low, high))
            lines.append(f"{what:{_WIDTH}} {value} {unit} ({least} to {most})")
    lines.append(f"{'top speed':{_WIDTH}} {top_speed_mps(config.hull, config.limits.surge_n):.1f} m/s")
    limits = config.limits
    ahead, sideways, turning = map(_three_digits, (limits.surge_n, limits.sway_n, limits.yaw_nm))
    thrust = f"{ahead} N ahead, {sideways} N sideways, {turning} Nm of yaw moment"
    lines.append(f"{'largest thrust':{_WIDTH}} {thrust}")
    return lines + [f"note: {found}" for found in judgements(config)]


def _three_digits(value: float) -> str:
    """Three digits, without an exponent."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def _answers(arguments: argparse.Namespace, asks: bool) -> dict[str, Any]:
    """All answers by their keys: options first, then questions or defaults. Raises UsageError that names all
    missing ones."""
    known: dict[str, Any] = {question.key: None for question in QUESTIONS}
    known["spread_m"], known[_FILE] = 0.0, arguments.file.stem
    missing = []
    for question in QUESTIONS:
        given = getattr(arguments, question.key)
        if given is not None:
            known[question.key] = _read(question, given)
        elif question.when(known):
            if asks:
                known[question.key] = _asked(question, known)
            elif question.default is None:
                missing.append(_option(question.key))
            elif not missing:  # a default may follow from an answer before
                known[question.key] = question.default(known)
    if missing:
        raise UsageError(f"new: missing: {', '.join(missing)}; give them, or run in a terminal to be asked")
    return known


def _asked_again(before: Known) -> dict[str, Any]:
    """All answers, asked anew; what was said before is proposed."""
    known = {**dict.fromkeys(before), "spread_m": 0.0, _FILE: before[_FILE]}
    for question in QUESTIONS:
        if question.when(known):
            known[question.key] = _asked(question, known, before[question.key] if question.when(before) else None)
    return known


def _read(question: Question, text: str) -> Any:
    try:
        return question.read(text)
    except ValueError as error:
        asked = question.text.partition("\n")[0].rstrip(":")
        raise UsageError(f"new: {asked}: '{text}': {error}") from error


def _asked(question: Question, known: Known, said: Any = None) -> Any:
    """Ask until the answer can be read. `said`: proposed in place of the default."""
    from rich.prompt import Prompt

    default = said if said is not None or question.default is None else question.default(known)
    shown = "-" if question.default is not None and default is None else None if default is None else str(default)
    while True:
        text = Prompt.ask(question.text) if shown is None else Prompt.ask(question.text, default=shown)
        try:
            return question.read((text or "").strip())
        except ValueError as error:
            print(f"  {error}")


def _confirmed(text: str) -> bool:
    from rich.prompt import Confirm

    return Confirm.ask(text, default=True)
