"""manoeuvres.md: how the simulated hulls turn, swing and stop, against a published simulator; how they keep their
course by themselves."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from companion.config.vessel import PlantConfig, find, load
from docs.generate.markdown import code, page, section, table
from docs.generate.source import ROOT
from sitl.hull_flow import mass_kg, regression
from sitl.manoeuvres import Bare, Thrust, course_roots, stopping, turning_circle, zigzag
from sitl.otter_equations import OtterHull
from sitl.wave_hull import wave_hull

_DATA = ROOT / "docs" / "generate" / "published_manoeuvres.toml"
_INTRODUCTION = """Manoeuvres of simulated hulls without a controller, wind or waves. The program computes the tables
when this page is made. [The simulated hull](../inside/hull.md) describes the plants."""
_OTTER = """*Program* is what the published program does by itself, run apart. `published` and `published_2023` are its
equations as this program has them, in six degrees of freedom; `strips` and `fossen` are plants of three. Of each
propeller 40 N; in the circle 20 N between both, in the zig-zag of 10° 40 N.

Two errors of the program are known. The payload's weight pulls along a boat that is not level, with no buoyancy against
it: {trim_n:.1f} N ahead at rest, and {trim_kg:.1f} kg more in surge as the boat pitches. The strips of the cross-flow
count both ends of the hull whole. In the first two tables the force and the kilogrammes are added to the plants of
three degrees of freedom; the third is without both errors."""
_PARTS = {
    "speed_before_mps": "speed before, m/s",
    "advance_m": "advance at 90°, m",
    "transfer_m": "transfer at 90°, m",
    "tactical_diameter_m": "tactical diameter, m",
    "steady_diameter_m": "steady diameter, m",
    "yaw_rate_dps": "yaw rate, °/s",
    "speed_mps": "speed in the circle, m/s",
    "drift_deg": "drift angle, °",
    "overshoot_1_deg": "overshoot 1, °",
    "overshoot_2_deg": "overshoot 2, °",
    "overshoot_3_deg": "overshoot 3, °",
    "first_turn_s": "first change of side, s",
    "period_s": "period, s",
    "half_speed_s": "time to half speed, s",
    "half_speed_m": "way to half speed, m",
}
_MANOEUVRES = {
    "turning_circle": (turning_circle, "turning circle", Thrust(40.0, 20.0)),
    "zigzag": (zigzag, "zig-zag", Thrust(40.0, 40.0)),
    "stopping": (stopping, "deceleration", Thrust(40.0, 0.0)),
}
_AGAINST = {"otter_2024": ("published", "strips", "fossen"), "otter_2023": ("published_2023", "fossen")}
_STEPS = """What makes the difference: from `fossen` to `strips`, one term after the other, as ratios to `mended`."""
_STEPPED = (
    ("turning_circle", "steady_diameter_m"),
    ("turning_circle", "drift_deg"),
    ("zigzag", "overshoot_2_deg"),
    ("stopping", "half_speed_s"),
)
_COURSE = """The less stable eigenvalue of sway and yaw on a straight course, in 1/s: positive, the hull by itself
leaves its course and needs the thrusters to keep it; negative, it comes back to a straight course. `C` is Y_v (N_r −
m x_G u) − N_v (Y_r − m u) of the regression alone, over its first term: positive, the hull of that form is stable."""
_COURSES = (
    ("revolt", 0.9, ("as_sailed", "thesis", "slender")),
    ("aboat", 1.2, ("as_rigged", "slender")),
    ("otter", 1.0, ("fossen", "strips")),
    ("cybership2", 0.2, ()),
)


@dataclass(frozen=True, slots=True)
class Trim:
    """Of a weight that pulls along the boat: force ahead at rest, and inertia in surge."""

    ahead_n: float = 0.0
    surge_kg: float = 0.0


@dataclass(frozen=True, slots=True)
class Row:
    """One figure of a manoeuvre: `reference` of the published program, or of its equations without errors; and of
    plants."""

    edition: str
    manoeuvre: str
    figure: str
    reference: float
    plants: Mapping[str, float]

    def ratio(self, plant: str) -> float:
        """Over the reference."""
        return self.plants[plant] / self.reference


@cache
def published() -> Mapping[str, Any]:
    """What the published program does: by edition its commit, and by manoeuvre each figure."""
    return tomllib.loads(_DATA.read_text(encoding="utf-8"))


@cache
def compared() -> tuple[Row, ...]:
    """Every figure of every manoeuvre of the Otter, against the program and against its equations without errors."""
    data = published()
    rows = [
        row for edition, plants in _AGAINST.items() for row in _rows(edition, plants, data[edition], as_published())
    ]
    mended = {name: dict(_sailed("mended", Trim(), name)) for name in _MANOEUVRES}
    return (*rows, *_rows("mended", ("strips", "fossen"), mended, Trim()))


@cache
def as_published() -> Trim:
    """What the published equations get of the payload's weight."""
    sitl = load(find("otter")).sitl
    assert sitl is not None
    hull = OtterHull(sitl.plants["published"].hull, "otter_2024")
    return Trim(hull.trim_n, hull.trim_kg)


def _rows(
    edition: str, plants: Sequence[str], reference: Mapping[str, Mapping[str, float]], trim: Trim
) -> Iterator[Row]:
    for name, (_, title, _) in _MANOEUVRES.items():
        made = {plant: _sailed(plant, trim, name) for plant in plants}
        for figure, value in reference[name].items():
            yield Row(edition, title, figure, value, {plant: made[plant][figure] for plant in plants})


@cache
def _sailed(name: str, trim: Trim, manoeuvre: str) -> Mapping[str, float]:
    return _sail(_plants()[name], trim, manoeuvre)


def _plants() -> Mapping[str, PlantConfig]:
    sitl = load(find("otter")).sitl
    assert sitl is not None
    return sitl.plants


@cache
def _sail(plant: PlantConfig, trim: Trim, manoeuvre: str) -> Mapping[str, float]:
    helped_n = 0.0
    if plant.equations == "companion":
        helped_n = trim.ahead_n
        plant = replace(plant, hull=replace(plant.hull, m11_kg=plant.hull.m11_kg + trim.surge_kg))
    sail, _, thrust = _MANOEUVRES[manoeuvre]
    return sail(copy.deepcopy(_under_way(plant, helped_n, thrust.mean_n)), thrust)


@cache
def _under_way(plant: PlantConfig, helped_n: float, mean_n: float) -> Bare:
    """The Otter at its steady speed, from where each manoeuvre begins."""
    boat = Bare(load(find("otter")), plant, helped_n)
    boat.run_up(Thrust(mean_n, 0.0))
    return boat


def steps() -> Iterator[tuple[str, PlantConfig]]:
    """From the plant `fossen` to `strips`, each with what is new."""
    plants = _plants()
    strips, plant = plants["strips"], plants["fossen"]
    yield "`fossen`", plant
    plant = replace(plant, thruster_lag_s=strips.thruster_lag_s, lag_on=strips.lag_on)
    yield "propellers of 0.1 s in place of 0.3 s, by revolutions", plant
    damping = replace(plant.hull.damping, y_v=strips.hull.damping.y_v)
    plant = replace(plant, hull=replace(plant.hull, damping=damping))
    yield "linear damping of sway", plant
    plant = replace(plant, hull=replace(plant.hull, damping=replace(damping, n_uv=0.0)))
    yield "the Munk moment", plant
    plant = replace(plant, hull=replace(plant.hull, m23_kgm=strips.hull.m23_kgm))
    yield "centre of gravity 0.153 m ahead", plant
    yield "cross-flow drag by strips: `strips`", strips


def _stepped() -> Iterator[str]:
    reference = {name: _sailed("mended", Trim(), name) for name, _ in _STEPPED}
    lines = []
    for text, plant in steps():
        made = {name: _sail(plant, Trim(), name) for name in reference}
        lines.append((text, *(f"{made[name][key] / reference[name][key]:.2f}" for name, key in _STEPPED)))
    yield table(("with", *(_PARTS[key].rsplit(",", 1)[0] for _, key in _STEPPED)), lines)


def manoeuvres() -> str:
    """The page."""
    return page(
        "Manoeuvres of the simulated hulls",
        _INTRODUCTION,
        section(
            2,
            "The Otter against its published simulator",
            _OTTER.format(trim_n=as_published().ahead_n, trim_kg=as_published().surge_kg),
            *_otter(),
            _STEPS,
            *_stepped(),
        ),
        section(2, "Keeping a straight course", _COURSE, *_courses()),
    )


def _otter() -> Iterator[str]:
    data = published()
    for edition in dict.fromkeys(row.edition for row in compared()):
        rows = [row for row in compared() if row.edition == edition]
        plants = list(rows[0].plants)
        title = "`mended`" if edition == "mended" else "program"
        headers = ["manoeuvre", "figure", title, *(text for plant in plants for text in (code(plant), "ratio"))]
        lines = [(row.manoeuvre, _PARTS[row.figure], f"{row.reference:.2f}", *_cells(row, plants)) for row in rows]
        against = "Without both errors" if edition == "mended" else f"`otter.py` at {data[edition]['commit']}"
        yield f"{against}:\n\n" + table(headers, lines)


def _cells(row: Row, plants: Sequence[str]) -> Iterator[str]:
    for plant in plants:
        yield f"{row.plants[plant]:.2f}"
        yield f"{row.ratio(plant):.3f}"


def _courses() -> Iterator[str]:
    lines = []
    for name, speed_mps, plants in _COURSES:
        vessel = load(find(name))
        assert vessel.sitl is not None
        for plant in plants or (vessel.sitl.plant,):
            root = course_roots(vessel, vessel.sitl.plants[plant], speed_mps)[0].real
            lines.append((vessel.title, f"{speed_mps:g}", code(plant), f"{root:+.2f}".replace("-", "−")))
    yield table(("boat", "speed, m/s", "plant", "eigenvalue, 1/s"), lines)
    yield "The plants `slender` by the two regressions, with and without fins:"
    yield table(("boat", "regression", "Y_v", "Y_r", "N_v", "N_r", "C", "eigenvalue", "without fins"), _laws())
    yield "In N and Nm per m/s or rad/s at 1 m/s ahead. N_v has the Munk moment in it, Y_r the added mass in surge."


def _laws() -> Iterator[Sequence[str]]:
    for name, speed_mps in (("revolt", 0.9), ("aboat", 1.2)):
        vessel = load(find(name))
        assert vessel.sitl is not None
        plant = vessel.sitl.plants["slender"]
        assert plant.lift is not None
        for law in ("clarke", "inoue"):
            with_law = replace(plant, lift=replace(plant.lift, law=law))
            bare = replace(plant, lift=replace(plant.lift, law=law, fin_area_m2=0.0))
            found = regression(law, plant.hull, wave_hull(plant.hull, vessel))
            whole = found.y_v * found.n_r
            criterion = (whole - found.n_v * (found.y_r - mass_kg(plant.hull))) / whole
            roots = [course_roots(vessel, one, speed_mps)[0].real for one in (with_law, bare)]
            figures = (found.y_v, found.y_r, found.n_v, found.n_r)
            shown = (*(f"{value:.0f}" for value in figures), f"{criterion:+.2f}", *(f"{root:+.2f}" for root in roots))
            yield vessel.title, code(law), *(text.replace("-", "−") for text in shown)
