"""hulls.md: the formulae by which a model follows from dimensions, and how far off they are for published hulls."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from companion.config.devices import ThrusterConfig
from companion.config.dimensions import motors
from companion.config.dimensions.derivation import hull_figures
from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import GRAVITY_MPS2, dimensions_of
from companion.config.units import unit_of
from docs.generate.markdown import code, page, section, table
from docs.generate.source import ROOT

_DATA = ROOT / "docs" / "generate" / "published_hulls.toml"
_TURN_RADPS = 0.2
_INTRODUCTION = """The model that the program derives from the dimensions in `[hull]`, if it has a `form`, when it
reads a vessel's file. A key of the file overrides one figure.

The true figure is expected within the stated factor, up or down. [Identification](../use/identification.md) measures
it."""
_COMPARED = """The ratio of the derived figure to the published one, with the stated factor. Coefficients of damping
share a force between them in many ways, so the forces are compared: ahead at 0.2 √(gL), across at 0.05 √(gL), turning
at 0.2 rad/s.

Damping ahead holds the thrust that propellers lose with speed: the model's thrusters push as at the bollard."""


@dataclass(frozen=True, slots=True)
class Compared:
    """One figure of one published hull. `set_aside`: why it says nothing of the hull; empty where it does."""

    hull: str
    name: str
    derived: float
    published: float
    factor: float
    set_aside: str

    @property
    def off(self) -> float:
        """By what factor the derived figure is off, 1 or more."""
        return max(self.derived / self.published, self.published / self.derived)

    @property
    def covered(self) -> bool:
        """Whether the published figure lies within the stated factor."""
        return self.off <= self.factor


def hulls() -> str:
    """The page."""
    rows = list(comparison())
    return page(
        "A model from dimensions",
        _INTRODUCTION,
        section(2, "Formulae", table(("key", "formula", "within", "source"), _formulae())),
        section(2, "Against published hulls", _COMPARED, _compared(rows), *_notes(rows)),
        section(2, "Motors", _motors()),
    )


def comparison() -> Iterator[Compared]:
    """Every figure of every published hull."""
    for row in tomllib.loads(_DATA.read_text(encoding="utf-8"))["hull"]:
        boat, problems = dimensions_of(row["dimensions"], {})
        assert boat is not None, problems
        figures = {figure.key: figure for figure in hull_figures(boat, _thrusters(*row["thrusters"]))}
        model, aside = row["model"], row.get("set_aside", {})
        for key in ("m11_kg", "m22_kg", "m33_kgm2"):
            found = figures[f"hull.{key}"]
            yield Compared(row["name"], key, found.value, model[key], found.factor, aside.get(key, ""))
        unit_mps = math.sqrt(GRAVITY_MPS2 * boat.length_m)
        for name, axis, speed in (
            ("surge_n", "x_u", 0.2 * unit_mps),
            ("sway_n", "y_v", 0.05 * unit_mps),
            ("yaw_nm", "n_r", _TURN_RADPS),
        ):
            yield _force(row["name"], name, axis, speed, figures, model, aside)


def _force(
    hull: str,
    name: str,
    axis: str,
    speed: float,
    figures: Mapping[str, Figure],
    model: Mapping[str, float],
    aside: Mapping[str, str],
) -> Compared:
    """A damping force at a speed: sums of powers of it."""
    motion = axis[-1]
    powers = [(axis, speed), (axis + motion, speed**2), (axis + 2 * motion, speed**3)]
    terms = [(found, found.value * power) for key, power in powers if (found := figures.get(f"hull.damping.{key}"))]
    derived = sum(value for _, value in terms)
    factor = sum(found.factor * value for found, value in terms) / derived
    published = sum(model.get(key, 0.0) * power for key, power in powers)
    return Compared(hull, name, derived, published, factor, aside.get(name, ""))


def _thrusters(number: int, ahead_n: float, diameter_m: float) -> Sequence[ThrusterConfig]:
    one = ThrusterConfig(
        name="a",
        kind="fixed",
        x_m=0.0,
        y_m=0.0,
        max_n=ahead_n,
        min_n=-ahead_n,
        ahead_n=ahead_n,
        astern_n=ahead_n,
        force_rate_nps=ahead_n,
        propeller_m=diameter_m or None,
    )
    return [one] * number


_NAMES = {
    "m11_kg": "m11",
    "m22_kg": "m22",
    "m33_kgm2": "m33",
    "surge_n": "drag ahead",
    "sway_n": "drag across",
    "yaw_nm": "moment turning",
}


def _compared(rows: Sequence[Compared]) -> str:
    names = list(dict.fromkeys(row.hull for row in rows))
    lines = []
    for hull in names:
        own = {row.name: row for row in rows if row.hull == hull}
        lines.append((hull, *(_cell(own[name]) for name in _NAMES)))
    return table(("hull", *_NAMES.values()), lines)


def _cell(row: Compared) -> str:
    sign = "×" if row.derived >= row.published else "÷"
    text = f"{sign} {row.off:.2f} of {row.factor:.1f}"
    return f"({text})" if row.set_aside else text


def _notes(rows: Sequence[Compared]) -> Iterator[str]:
    yield "`× 1.20 of 1.7`: the derived figure is 1.2 times the published one, and a factor of 1.7 is stated."
    data: Sequence[Mapping[str, Any]] = tomllib.loads(_DATA.read_text(encoding="utf-8"))["hull"]
    yield table(("hull", "published by"), ((row["name"], row["source"]) for row in data))
    aside = [f"* {row.hull}, {_NAMES[row.name]}: {row.set_aside}." for row in rows if row.set_aside]
    yield "In parentheses is what says nothing of the hull:\n\n" + "\n".join(aside)


def _formulae() -> Iterator[tuple[str, ...]]:
    boat, _ = dimensions_of({"form": "monohull", "length_m": 3.0, "beam_m": 0.7, "mass_kg": 250.0}, {})
    assert boat is not None
    for figure in hull_figures(boat, _thrusters(1, 25.0, 0.0)):
        yield code(figure.key), figure.formula, f"× ÷ {figure.factor:g}", figure.source


def _motors() -> str:
    rows = (
        (
            code(key),
            motor.title,
            ", ".join(
                f"{volts:g} V: {ahead:g} / {astern:g} {unit_of('max_n')}" for volts, ahead, astern in motor.thrust
            ),
            motor.source,
        )
        for key, motor in motors.table().items()
    )
    text = (
        "What `motor` of a thruster can be, in any case and spacing. `trolling 55 lb`: a trolling motor by its thrust."
    )
    return text + "\n\n" + table(("motor", "name", "thrust ahead / astern", "source"), rows)
