"""The shape of a hull as a person can measure it, and what its form says about the rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeGuard, get_args

from companion.config.kinds import Problem

WATER_KGPM3 = 1025.0
GRAVITY_MPS2 = 9.81

Form = Literal["monohull", "catamaran", "inflatable", "barge", "planing"]


@dataclass(frozen=True, slots=True)
class FormTraits:
    """What a form is taken to be where nothing was measured.

    `block`: block coefficient of one hull. `cross_flow`: drag coefficient of the flow across (Faltinsen 1990, ch. 6;
    Hoerner 1965). `residual`: what pods, transom and waves add to friction at low speed. `height_share`: height above
    the water over the length. `frontal_share`: part of beam times height that is solid. `waterline`: beam at
    the waterline over that over all, since tubes stand clear of the water.
    """

    block: float
    cross_flow: float
    residual: float
    height_share: float
    frontal_share: float
    waterline: float = 1.0


TRAITS: Mapping[str, FormTraits] = {
    "monohull": FormTraits(0.6, 0.8, 0.006, 0.15, 0.8),
    "catamaran": FormTraits(0.5, 0.8, 0.006, 0.2, 0.6),
    "inflatable": FormTraits(0.5, 1.0, 0.010, 0.13, 0.8, 0.6),
    "barge": FormTraits(0.9, 1.0, 0.008, 0.15, 0.8),
    "planing": FormTraits(0.45, 0.8, 0.006, 0.2, 0.8),
}
LEAST_BLOCK, MOST_BLOCK = 0.15, 1.0
_MOST_SPREAD = 1.05  # of the beam, between the middles of two hulls: more is not rounding
_MOST_SLENDER = 30.0  # length over beam, and beam over length
_LEAST_DRAFT_SHARE, _MOST_DRAFT_SHARE = 0.002, 0.5  # of the length
_LEAST_SHOWN_M = 0.001
_SHOWN_IN_CM_M = 0.1  # a deeper draft is told in whole cm, another one in mm
_MOST_PRISMATIC = 0.65  # of a hull with fine ends


@dataclass(frozen=True, slots=True)
class Dimensions:
    """A boat as a person can measure it. `beam_m` is over all; a catamaran's single hull has `hull_beam_m`, and its two
    centre planes are `hull_spacing_m` apart. `height_m`: of hull and gear above the water. `top_speed_mps` None:
    unknown."""

    form: str
    length_m: float
    beam_m: float
    mass_kg: float
    draft_m: float
    hull_beam_m: float
    hull_spacing_m: float
    height_m: float
    top_speed_mps: float | None = None

    @property
    def traits(self) -> FormTraits:
        """What its form is taken to be."""
        return TRAITS[self.form]

    @property
    def hulls(self) -> int:
        """Two of a catamaran, else one."""
        return 2 if self.form == "catamaran" else 1

    @property
    def hull_volume_m3(self) -> float:
        """Displacement of one hull."""
        return self.mass_kg / WATER_KGPM3 / self.hulls

    @property
    def block(self) -> float:
        """Block coefficient of one hull."""
        return self.hull_volume_m3 / (self.length_m * self.hull_beam_m * self.draft_m)

    @property
    def prismatic(self) -> float:
        """How full the ends are: displacement over midship section times length."""
        return max(self.block, _MOST_PRISMATIC) if self.midship >= 1.0 else self.block / self.midship

    @property
    def midship(self) -> float:
        """How full the midship section is, 0.5 (a V) to 1 (a box)."""
        return min(1.0, max(0.5, self.block / _MOST_PRISMATIC))

    @property
    def wetted_m2(self) -> float:
        """Wetted surface of all hulls: 1.7 L T + ∇/T each (Denny and Mumford, in Molland 2011, eq. 10.86)."""
        return self.hulls * (1.7 * self.length_m * self.draft_m + self.hull_volume_m3 / self.draft_m)

    @property
    def hull_speed_mps(self) -> float:
        """Speed at which the bow wave is as long as the hull: √(g L / 2π)."""
        return math.sqrt(GRAVITY_MPS2 * self.length_m / math.tau)


KEYS = (
    "form",
    "length_m",
    "beam_m",
    "mass_kg",
    "draft_m",
    "hull_beam_m",
    "hull_spacing_m",
    "height_m",
    "top_speed_mps",
)
"""Keys of `[hull]` that are dimensions."""

_BY_HAND = ("m11_kg", "m22_kg", "m33_kgm2")
_NO_FORM: Problem = (
    ("hull", "form"),
    f"is missing: one of {', '.join(get_args(Form))}; with it the model is made of the dimensions",
)
_MEANINGS = {
    "length_m": "length of the waterline, in m",
    "beam_m": "width over all, in m",
    "mass_kg": "mass of the boat as it floats, in kg",
    "hull_beam_m": "width of one of the two hulls at the waterline, in m",
}


def dimensions_of(hull: Mapping[str, Any], top: Mapping[str, Any]) -> tuple[Dimensions | None, list[Problem]]:
    """The dimensions in a raw `[hull]` table, with length and beam of the file's top level where it has none, and what
    is wrong with them. (None, []) where it has no `form`: its model is given by hand."""
    if "form" not in hull:
        return None, [] if "mass_kg" not in hull or any(key in hull for key in _BY_HAND) else [_NO_FORM]
    form = hull["form"]
    if form not in get_args(Form):
        return None, [(("hull", "form"), f"should be one of {', '.join(get_args(Form))}")]
    numbers = {key: hull.get(key, top.get(key) if key in ("length_m", "beam_m") else None) for key in KEYS[1:]}
    wrong: list[Problem] = [
        (("hull", key), f"should be a number above 0, not {value!r}")
        for key, value in numbers.items()
        if value is not None and not above_zero(value)
    ]
    needed = ("length_m", "beam_m", "mass_kg", *(("hull_beam_m",) if form == "catamaran" else ()))
    wrong += [
        (("hull", key), f"is missing: {_MEANINGS[key]}; with it the model is made of the dimensions")
        for key in needed
        if numbers[key] is None
    ]
    if wrong:
        return None, wrong
    return _checked(form, {key: float(value) for key, value in numbers.items() if value is not None})


def _checked(form: str, numbers: Mapping[str, float]) -> tuple[Dimensions | None, list[Problem]]:
    """The dimensions, with what was not measured filled in by the form."""
    traits, twin = TRAITS[form], form == "catamaran"
    length_m, beam_m, mass_kg = numbers["length_m"], numbers["beam_m"], numbers["mass_kg"]
    hull_beam_m = numbers["hull_beam_m"] if twin else traits.waterline * beam_m
    if twin and 2.0 * hull_beam_m > beam_m:
        return None, [(("hull", "hull_beam_m"), f"two hulls of {hull_beam_m:g} m are wider than beam_m, {beam_m:g}")]
    spacing_m = numbers.get("hull_spacing_m", beam_m - hull_beam_m) if twin else 0.0
    if spacing_m > _MOST_SPREAD * beam_m:
        text = f"middles of the hulls {spacing_m:g} m apart, but beam_m is {beam_m:g}: check both, in m"
        return None, [(("hull", "hull_spacing_m"), text)]
    volume_m3 = mass_kg / WATER_KGPM3 / (2 if twin else 1)
    draft_m = numbers.get("draft_m", volume_m3 / (length_m * hull_beam_m * traits.block))
    found = Dimensions(
        form=form,
        length_m=length_m,
        beam_m=beam_m,
        mass_kg=mass_kg,
        draft_m=draft_m,
        hull_beam_m=hull_beam_m,
        hull_spacing_m=spacing_m,
        height_m=numbers.get("height_m", traits.height_share * length_m),
        top_speed_mps=numbers.get("top_speed_mps"),
    )
    if problem := _out_of_scale(found, "draft_m" in numbers):
        return None, [problem]
    if not LEAST_BLOCK <= found.block <= MOST_BLOCK:
        least_m, most_m = (_draft(found, block) for block in (MOST_BLOCK, LEAST_BLOCK))
        steps = 100.0 if most_m > _SHOWN_IN_CM_M else 1000.0  # a metre
        fits = f"from {math.ceil(steps * least_m) / steps:g} to {math.floor(steps * most_m) / steps:g} m"
        text = f"{mass_kg:g} kg do not float so: with this length and beam the draft is {fits}"
        return None, [(("hull", "draft_m" if "draft_m" in numbers else "mass_kg"), text)]
    return found, []


def _out_of_scale(boat: Dimensions, draft_given: bool) -> Problem | None:
    """A dimension or mass that no boat has, most likely in another unit."""
    slender = boat.length_m / boat.beam_m
    if not 1.0 / _MOST_SLENDER <= slender <= _MOST_SLENDER:
        return ("hull", "length_m"), f"{boat.length_m:g} m long and {boat.beam_m:g} m wide: check both, in m"
    if not _LEAST_DRAFT_SHARE <= boat.draft_m / boat.length_m <= _MOST_DRAFT_SHARE:
        if draft_given:
            return ("hull", "draft_m"), f"{boat.draft_m:g} m deep and {boat.length_m:g} m long: check both, in m"
        deep = f"{boat.draft_m:.3g} m" if boat.draft_m >= _LEAST_SHOWN_M else f"less than {_LEAST_SHOWN_M:g} m"
        floats = f"{boat.mass_kg:g} kg on {boat.length_m:g} m of length float {deep} deep"
        return ("hull", "mass_kg"), f"{floats}: check it, in kg, and length and beam, in m"
    return None


def _draft(boat: Dimensions, block: float) -> float:
    return boat.hull_volume_m3 / (boat.length_m * boat.hull_beam_m * block)


def above_zero(value: object) -> TypeGuard[float]:
    """Whether a raw value is a finite number above 0."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0.0 < value < math.inf
