"""A vessel's raw tables with what follows from its dimensions filled in. Keys that the file has are never touched."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from companion.config.blades import without_blades
from companion.config.devices import ThrusterConfig
from companion.config.dimensions import jets, limits, motors, rudders, surge_damping
from companion.config.dimensions.derivation import (
    hull_figures,
    limit_figures,
    parameter_figures,
)
from companion.config.dimensions.figure import Figure
from companion.config.dimensions.fins import with_fins
from companion.config.dimensions.form import Dimensions, dimensions_of
from companion.config.dimensions.limits import KEYS as LIMIT_KEYS
from companion.config.hull import HullConfig
from companion.config.kinds import Place, Problem
from companion.config.sensors import SensorRow

_ROUND = 4  # digits that a derived figure keeps


@dataclass(frozen=True, slots=True)
class Completion:
    """`data`: the tables as they are read on. `figures`: what was filled in. `problems`: what keeps something from
    being filled in. `moot`: places whose missing keys are only a consequence of those problems."""

    data: dict[str, Any]
    figures: tuple[Figure, ...] = ()
    problems: tuple[Problem, ...] = ()
    moot: tuple[Place, ...] = ()


@dataclass(slots=True)
class _Work:
    data: dict[str, Any]
    figures: list[Figure] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    moot: list[Place] = field(default_factory=list)

    def fill(self, figures: Sequence[Figure]) -> None:
        """Put each figure at its place in the tables, unless something stands there."""
        for figure in figures:
            *path, key = figure.key.split(".")
            table = self.data
            for name in path:
                inner = table.get(name)
                if inner is not None and not isinstance(inner, dict):
                    return
                table[name] = dict(inner or {})
                table = table[name]
            if key not in table:
                table[key] = _rounded(figure.value)
                self.figures.append(figure)


def completed(data: Mapping[str, Any]) -> Completion:
    """Fill in thrust by motor, the hull by its dimensions, limits by thrusters and parameters by all of them."""
    work = _Work(dict(data))
    boat, problems = _dimensions(work)
    unclear = boat is None and (bool(problems) or _has_form(work))
    thrusters = _thrusters(work, boat, explained=unclear)
    work.problems += problems
    if thrusters is None:
        work.moot.append(("limits",))
    elif not _given(work.data.get("limits"), LIMIT_KEYS):  # a search of 30 ms
        _limits(work, boat, thrusters)
    if boat is not None and thrusters is not None:
        _hull(work, boat, thrusters)
    elif problems or _has_form(work):
        work.moot.append(("hull",))
    return Completion(work.data, tuple(work.figures), tuple(work.problems), tuple(work.moot))


def _has_form(work: _Work) -> bool:
    """Whether the file means the model to follow from the dimensions."""
    hull = work.data.get("hull")
    return isinstance(hull, dict) and "form" in hull


def _limits(work: _Work, boat: Dimensions | None, thrusters: tuple[ThrusterConfig, ...]) -> None:
    if jets.is_jet(thrusters):
        work.fill(jets.limit_figures(boat, thrusters[0]))
        return
    figures = limit_figures(thrusters)
    lack = limits.lack(thrusters, figures)
    if lack is None:
        work.fill(figures)
    else:
        work.problems.append(lack)
        work.moot.append(("limits",))


def _given(table: object, keys: Sequence[str]) -> bool:
    return isinstance(table, dict) and all(key in table for key in keys)


def figures_of(hull: HullConfig, thrusters: Sequence[ThrusterConfig]) -> tuple[Figure, ...]:
    """What inertia, damping and windage follow from the dimensions of a hull, whatever its file says by hand. Empty
    where its file gives no dimensions."""
    raw = {
        "form": hull.form,
        "length_m": hull.length_m,
        "beam_m": hull.beam_m,
        "mass_kg": hull.mass_kg,
        "draft_m": hull.draft_m,
        "hull_beam_m": hull.hull_beam_m,
        "hull_spacing_m": hull.hull_spacing_m,
        "height_m": hull.height_m,
        "top_speed_mps": hull.top_speed_mps,
    }
    boat, _ = dimensions_of({key: value for key, value in raw.items() if value is not None}, {})
    return () if boat is None else hull_figures(boat, thrusters)


def _thrusters(work: _Work, boat: Dimensions | None, explained: bool) -> tuple[ThrusterConfig, ...] | None:
    """The thrusters, with their thrust filled in; None where they are wrong, which their own checks say. `explained`:
    a fault of the hull says already why no rudder and no jet follows from it."""
    rows = work.data.get("thruster")
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        return None
    filled, figures, problems = motors.completed(rows)
    filled, blades = rudders.completed(filled, boat)
    filled, curves, missing = jets.completed(filled, boat)
    problems += missing
    if explained:
        problems = [found for found in problems if found[1] != jets.NEEDS_FORM]
        work.moot += [("thruster", i, "rudder") for i in range(len(rows))]
        work.moot += [("thruster", i) for i, row in enumerate(rows) if row.get("kind") == "jet"]
    work.data["thruster"] = filled
    work.figures += [*figures, *blades, *curves]
    work.problems += problems
    work.moot += [("thruster", place[1]) for place, _ in problems]
    found: tuple[ThrusterConfig, ...] | None = _read(tuple[ThrusterConfig, ...], filled)
    return found


def _dimensions(work: _Work) -> tuple[Dimensions | None, list[Problem]]:
    hull = work.data.get("hull")
    if not isinstance(hull, dict):
        return None, []
    boat, problems = dimensions_of(hull, work.data)
    if "form" in hull:  # one place is enough for length and beam
        work.data["hull"] = {**{key: work.data[key] for key in ("length_m", "beam_m") if key in work.data}, **hull}
        for key in ("length_m", "beam_m"):
            if key in hull:
                work.data.setdefault(key, hull[key])
    return boat, problems


def _hull(work: _Work, boat: Dimensions, thrusters: Sequence[ThrusterConfig]) -> None:
    """Fill in the hull, and the parameters that follow from it."""
    work.fill(hull_figures(boat, thrusters, work.data["hull"]))
    if boat.form == "planing":
        work.data["hull"].setdefault(
            "resistance", [list(pair) for pair in surge_damping.planing_table(boat, thrusters)]
        )
    hull: HullConfig | None = _read(HullConfig, work.data["hull"])
    sensors = _read(tuple[SensorRow, ...], work.data.get("sensor", []))
    limits = work.data.get("limits", {})
    if hull is None or not isinstance(limits, dict):
        return
    surge_n, sway_n, yaw_nm = (limits.get(key) for key in ("surge_n", "sway_n", "yaw_nm"))
    if isinstance(surge_n, int | float) and isinstance(sway_n, int | float) and isinstance(yaw_nm, int | float):
        steers = any(thruster.kind in ("rudder", "jet") for thruster in without_blades(thrusters))
        drifts = not any(thruster.pushes_astern for thruster in thrusters)
        made = parameter_figures(
            with_fins(hull, thrusters, surge_n),
            (surge_n, sway_n, yaw_nm),
            boat.length_m,
            sensors or (),
            thrusters,
            needs_flow=steers,
            drifts=drifts,
        )
        work.fill((*made, *(jets.parameter_figures(thrusters[0]) if jets.is_jet(thrusters) else ())))


def _read(kind: Any, raw: Any) -> Any:
    """The raw tables as dataclasses; None where they are wrong."""
    try:
        return _reader(kind).validate_python(raw)
    except ValidationError:
        return None


@cache
def _reader(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _rounded(value: float) -> float:
    return float(f"{value:.{_ROUND}g}")
