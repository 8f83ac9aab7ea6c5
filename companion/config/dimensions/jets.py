"""A water jet by its pull and the boat: what its owner has not measured."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from companion.config.devices import JetConfig, ThrusterConfig
from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import WATER_KGPM3, Dimensions, above_zero
from companion.config.dimensions.surge_damping import planing_table, usual_speed_mps
from companion.config.hull import humps
from companion.config.kinds import Problem

NEEDS_FORM = "a jet needs its table [thruster.jet], or [hull] a form"

_RATIO = 1.6  # speed of the jet at full throttle over the boat's top speed: RescueRunner's; 1.5 to 2 (Allison 1993)
_INTAKE_SHARE = 0.9  # of the boat's speed, with which water enters below a hull
_IDLE_SHARE = 0.2  # of the full speed of the jet, at which the impeller idles
_LEFT = 1.0 - _INTAKE_SHARE / _RATIO  # of the pull, at top speed
_OVER_HUMP = 1.1
_ROUNDS = 30  # halve the error of the top speed
_STEERED = 0.1  # of pull times arm: what the nozzle turns the boat with at the thrust of its cruise (RescueRunner's)
_STEERING_SHARE = 0.07  # of the pull, that the allocation may add to steer (RescueRunner's)
_SOURCE = "momentum theory; Allison, Marine Waterjet Propulsion (SNAME 1993)"
_AS_SMALL_JETS = "as small jets have it"
_STOPS_DEG = 24.0
_REST: Mapping[str, float] = {
    "min_n": 0.0,
    "azimuth_rate_dps": 40.0,
    "manual_azimuth_deg": _STOPS_DEG,
    "dead_band": 0.02,
}
_STOPS: Mapping[str, float] = {"azimuth_min_deg": -_STOPS_DEG, "azimuth_max_deg": _STOPS_DEG}
_BY_PULL: Mapping[str, float] = {"astern_n": 0.3, "force_rate_nps": 1.0}


def is_jet(thrusters: Sequence[ThrusterConfig]) -> bool:
    """Whether a jet drives the boat. It is then its only thruster."""
    return bool(thrusters) and thrusters[0].kind == "jet"


def completed(
    rows: Sequence[Mapping[str, Any]], boat: Dimensions | None
) -> tuple[list[dict[str, Any]], list[Figure], list[Problem]]:
    """Raw `[[thruster]]` rows with their jets filled in by `max_n` or `ahead_n`, the pull; the figures that were filled
    in, and what is missing for that. Keys given by hand stay. Without dimensions `density_area_kgpm` must be given."""
    found: list[dict[str, Any]] = []
    figures: list[Figure] = []
    problems: list[Problem] = []
    for i, row in enumerate(rows):
        made, curve = dict(row), row.get("jet", {})
        if row.get("kind") == "jet" and isinstance(curve, Mapping):
            problem = _missing(row, curve, boat)
            if problem is None:
                made = _filled(row)
                new = [f for f in _curve(float(made["ahead_n"]), curve, boat) if f.key not in curve]
                made["jet"] = {**{figure.key: figure.value for figure in new}, **curve}
                where = f"thruster.{row.get('name', i + 1)}.jet"
                figures += [Figure(f"{where}.{f.key}", f.value, f.factor, f.formula, f.source) for f in new]
            else:
                problems.append((("thruster", i, problem[0]), problem[1]))
        found.append(made)
    return found, figures, problems


def _missing(row: Mapping[str, Any], curve: Mapping[str, Any], boat: Dimensions | None) -> tuple[str, str] | None:
    """(key, text) of what the jet cannot be completed without."""
    if not above_zero(row.get("ahead_n", row.get("max_n"))):
        return "max_n", "is missing: pull of the jet at full throttle with the boat at rest, in N: a scale at the quay"
    area = curve.get("density_area_kgpm")
    if boat is not None and above_zero(area) and area > WATER_KGPM3 * boat.hull_beam_m * boat.draft_m:
        return "jet", f"density_area_kgpm = {area:.3g}: a nozzle larger than the hull below the water: check it, in m"
    if boat is None and not curve:
        return "kind", NEEDS_FORM
    return None


def _filled(row: Mapping[str, Any]) -> dict[str, Any]:
    """The row with what follows from the pull. Stops are filled in where both are missing."""
    pull_n = row.get("ahead_n", row.get("max_n"))
    rest = {**_REST, "max_n": pull_n, "ahead_n": pull_n, **{key: share * pull_n for key, share in _BY_PULL.items()}}
    if not any(key in row for key in _STOPS):
        rest |= _STOPS
    return {**rest, **row}


def _curve(pull_n: float, given: Mapping[str, Any], boat: Dimensions | None) -> list[Figure]:
    """The keys of `[thruster.jet]` for that pull, as far as they follow."""
    area = given.get("density_area_kgpm")
    if above_zero(area):
        exit_mps = math.sqrt(pull_n / float(area))
    elif boat is not None:
        exit_mps = _RATIO * top_mps(boat, pull_n)
    else:
        return []
    idle, exponent = given.get("idle_mps"), "1, as of an impeller whose speed follows the throttle"
    idle_mps = float(idle) if above_zero(idle) else _IDLE_SHARE * exit_mps
    return [
        Figure(
            "density_area_kgpm", round(pull_n / exit_mps**2, 4), 1.6, "pull / V², V = 1.6 of the top speed", _SOURCE
        ),
        Figure("idle_mps", round(idle_mps, 3), 1.5, "0.2 V", _AS_SMALL_JETS),
        Figure("span_mps", round(max(0.01, exit_mps - idle_mps), 3), 1.3, "V − idle_mps", _SOURCE),
        Figure("exponent", 1.0, 1.4, exponent, _AS_SMALL_JETS),
        Figure("intake_share", _INTAKE_SHARE, 1.1, "0.9: water enters below the hull", _SOURCE),
    ]


def top_mps(boat: Dimensions, pull_n: float, jet: JetConfig | None = None) -> float:
    """Top speed with that pull at rest: as measured, or where the hull takes what the jet has left there. Without its
    curve that is a share of the pull."""
    if boat.top_speed_mps is not None:
        return boat.top_speed_mps
    found_mps = usual_speed_mps(boat, _LEFT * pull_n)
    if jet is not None:
        for _ in range(_ROUNDS):
            found_mps = 0.5 * (found_mps + usual_speed_mps(boat, jet.full_n(found_mps)))
    return found_mps


def limit_figures(boat: Dimensions | None, thruster: ThrusterConfig) -> tuple[Figure, ...]:
    """Limits of the wrench of a jet: ahead what it has left at top speed, or what lifts the hull over its hump."""
    ahead_n, jet = _LEFT * thruster.max_n, thruster.jet
    if boat is not None and jet is not None:
        ahead_n = jet.full_n(top_mps(boat, thruster.ahead_n, jet))
        ahead_n = min(thruster.max_n, max(ahead_n, _OVER_HUMP * _hump_n(boat, thruster)))
    turning_nm = _STEERED * abs(thruster.x_m) * thruster.max_n
    return (
        Figure("limits.surge_n", ahead_n, 1.5, "thrust of the jet at top speed, 1.1 of the hump at least", _SOURCE),
        Figure("limits.sway_n", 0.0, 1.0, "none", _SOURCE),
        Figure("limits.yaw_nm", turning_nm, 2.0, "0.1 · pull · |x|", _AS_SMALL_JETS),
    )


def parameter_figures(thruster: ThrusterConfig) -> tuple[Figure, ...]:
    """Parameters of the allocation over a jet."""
    return (
        Figure("parameters.JET_STEER_N", _STEERING_SHARE * thruster.max_n, 2.0, "0.07 of the pull", _AS_SMALL_JETS),
    )


def _hump_n(boat: Dimensions, thruster: ThrusterConfig) -> float:
    """The largest resistance below top speed of a hull whose resistance falls once it planes; else 0."""
    table = planing_table(boat, (thruster,)) if boat.form == "planing" else ()
    return max((force_n for _, force_n in humps(table)), default=0.0)
