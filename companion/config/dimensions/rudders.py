"""A rudder by the boat's dimensions: what its owner has not measured."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import Dimensions
from companion.config.dimensions.surge_damping import propeller_across_m

_ASPECT = 1.5  # of blades that hang freely behind a small boat
_COVERS, _MOST_COVERS = 1.1, 1.5  # span over the propeller's diameter (Molland and Turnock 2007, ch. 5)
_SHORT_OF_PROPELLER = 0.6  # diameters from the propeller to the blade
_FULL_DEG = 35.0
_RATE_DPS = 30.0  # of a servo or a linear actuator on a small boat's tiller
_REST: Mapping[str, float] = {
    "azimuth_min_deg": -_FULL_DEG,
    "azimuth_max_deg": _FULL_DEG,
    "azimuth_rate_dps": _RATE_DPS,
}


def least_area_m2(boat: Dimensions) -> float:
    """Area of all rudders: L T / 100 · (1 + 25 (B/L)²), at least that of DNV (Rules for Ships, Pt. 3 Ch. 3). B is
    that of one hull."""
    return 0.01 * boat.length_m * boat.draft_m * (1.0 + 25.0 * (boat.hull_beam_m / boat.length_m) ** 2)


def completed(rows: Sequence[Mapping[str, Any]], boat: Dimensions | None) -> tuple[list[dict[str, Any]], list[Figure]]:
    """Raw `[[thruster]]` rows with their rudders filled in, and the figures that were filled in. Keys given by hand
    stay. Without dimensions the blade must be given."""
    found: list[dict[str, Any]] = []
    figures: list[Figure] = []
    count = sum(row.get("kind") == "rudder" for row in rows)
    for i, row in enumerate(rows):
        if row.get("kind") != "rudder":
            found.append(dict(row))
            continue
        name = str(row.get("name", i + 1))
        rest = {key: value for key, value in _REST.items() if key not in row}
        rest |= {} if "manual_azimuth_deg" in row else {"manual_azimuth_deg": _most_deg({**row, **rest})}
        made = {**row, **rest, **_propeller(row)}
        blade, by_hand = _blade(made, boat, count), row.get("rudder", {})
        if isinstance(by_hand, Mapping):
            made["rudder"] = {**{key: figure.value for key, figure in blade.items()}, **by_hand}
            figures += [
                Figure(f"thruster.{name}.rudder.{key}", figure.value, figure.factor, figure.formula, figure.source)
                for key, figure in blade.items()
                if key not in by_hand
            ]
        found.append(made)
    return found, figures


def _most_deg(row: Mapping[str, Any]) -> float:
    """What the full stick gives: the smaller of both stops."""
    stops = [row["azimuth_min_deg"], row["azimuth_max_deg"]]
    return min(abs(float(stop)) for stop in stops) if all(map(_is_number, stops)) else _FULL_DEG


def _propeller(row: Mapping[str, Any]) -> dict[str, float]:
    """The diameter of a propeller that is not given, by its thrust."""
    if "propeller_m" in row or not _is_number(row.get("max_n")) or row["max_n"] <= 0.0:
        return {}
    return {"propeller_m": round(propeller_across_m(float(row["max_n"]), None), 3)}


def _blade(row: Mapping[str, Any], boat: Dimensions | None, count: int) -> dict[str, Figure]:
    """span_m, chord_m, x_m and race_share, as far as they follow."""
    given = row.get("rudder", {})
    given = given if isinstance(given, Mapping) else {}
    across_m, at_m = _number(row.get("propeller_m")), _number(row.get("x_m"))
    span = _number(given.get("span_m"))
    blade: dict[str, Figure] = {}
    source = "DNV, Rules for Ships, Pt. 3 Ch. 3; Molland and Turnock 2007, ch. 5"
    if boat is not None:
        if span is None:
            span = math.sqrt(_ASPECT * least_area_m2(boat) / max(1, count))
            span = span if across_m is None else min(_MOST_COVERS * across_m, max(span, _COVERS * across_m))
            formula = "√(1.5 A) with A = L T (1 + 25 (B/L)²) / 100, 1.1 to 1.5 diameters of the propeller"
            blade["span_m"] = Figure("span_m", round(span, 3), 1.5, formula, source)
        blade["chord_m"] = Figure("chord_m", round(span / _ASPECT, 3), 1.5, "span / 1.5", source)
    if across_m is not None and at_m is not None:
        behind = "0.6 diameters behind the propeller"
        blade["x_m"] = Figure("x_m", round(at_m - _SHORT_OF_PROPELLER * across_m, 3), 1.2, behind, "usual gap")
    if across_m is not None and span is not None and span > 0.0:
        share = round(min(1.0, max(0.0, across_m / span)), 3)
        blade["race_share"] = Figure("race_share", share, 1.3, "diameter over span", "Yasukawa and Yoshimura 2015")
    return blade


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, (int, float)) and _is_number(value) else None


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
