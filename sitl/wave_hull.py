"""What waves do to a hull of that size, in closed form: how it follows them, and how it is pushed along by those that
it does not follow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.config.dimensions.form import GRAVITY_MPS2, TRAITS, WATER_KGPM3
from companion.config.hull import HullConfig
from companion.config.vessel import VesselConfig

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complexfloating[Any, Any]]

_SURGE_ADDED = 0.05  # share of the mass that the water adds in surge
_ROLL_RADIUS, _ROLL_ADDED, _ROLL_DAMPING = 0.39, 0.2, 0.15  # of the beam; of the inertia; of critical (Himeno 1981)
_LEAST_GM = 0.05  # of the beam
_WATERPLANE = 0.75  # share of length times beam
_BUOYANCY = 0.53  # height of its centre above the keel over the draft
_BOW = 0.4  # share of the length in which the waterline narrows, along a parabola
REFLECTED = 0.6  # R² of the waves that the hull does not follow (Faltinsen 1990, 5.4: short waves on a ship's side)
_PANELS = 40
_HEADINGS = 72


@dataclass(frozen=True, slots=True)
class WaveHull:
    """A hull as waves meet it. `beam_m`: over the waterlines; `hull_beam_m`: of one hull; `roll_radps`: natural
    frequency of roll; `stiffness_nm`: righting moment per rad of heel; `hulls`: two of a catamaran; `blunt`: no
    narrowing at the bow."""

    length_m: float
    beam_m: float
    hull_beam_m: float
    draft_m: float
    roll_radps: float
    stiffness_nm: float
    hulls: int = 1
    blunt: bool = False


def wave_hull(plant: HullConfig, vessel: VesselConfig) -> WaveHull:
    """The hull of a plant of that vessel. What the plant does not give is that of the vessel's own hull, or follows
    from form (without one, a monohull's) and mass; the centre of gravity is taken to lie in the waterline."""
    own = vessel.hull
    form = plant.form or own.form or "monohull"
    traits = TRAITS[form]
    length = plant.length_m or own.length_m or vessel.length_m
    over_all = plant.beam_m or own.beam_m or vessel.beam_m
    single = plant.hull_beam_m or own.hull_beam_m or 0.3 * over_all
    hulls, beam = (2, over_all) if form == "catamaran" else (1, traits.waterline * over_all)
    single = single if hulls == 2 else beam
    mass_kg = plant.mass_kg or plant.m11_kg / (1.0 + _SURGE_ADDED)
    volume = mass_kg / WATER_KGPM3
    draft = plant.draft_m or own.draft_m or volume / (hulls * length * single * traits.block)
    apart = over_all - single if hulls == 2 else 0.0
    second_m4 = _WATERPLANE * hulls * length * single * (single * single / 12.0 + 0.25 * apart * apart)
    height = max(second_m4 / volume - (1.0 - _BUOYANCY) * draft, _LEAST_GM * beam)
    roll = math.sqrt(GRAVITY_MPS2 * height / (1.0 + _ROLL_ADDED)) / (_ROLL_RADIUS * beam)
    return WaveHull(length, beam, single, draft, roll, mass_kg * GRAVITY_MPS2 * height, hulls, form == "barge")


def air_height_m(plant: HullConfig, vessel: VesselConfig) -> float:
    """Height above the water of the middle of what the wind meets: half of the hull's and gear's."""
    form = plant.form or vessel.hull.form or "monohull"
    return 0.5 * (plant.height_m or vessel.hull.height_m or TRAITS[form].height_share * vessel.length_m)


@dataclass(frozen=True, slots=True)
class Met:
    """Regular waves as a hull meets them: their number k in rad/m, frequency ω, and frequency of encounter ω_e, in
    rad/s; cos and sin of their direction from the bow (0: from astern, they overtake)."""

    number: Array
    omega: Array
    encounter: Array
    ahead: Array
    across: Array


def followed(boat: WaveHull, met: Met) -> Array:
    """Share of the water's orbital motion that the hull takes part in, surge and sway: its mean over a box of the
    hull's length, beam and draft. 1 in long waves."""
    depth = met.number * boat.draft_m
    return -np.expm1(-depth) / depth * _mean(boat, met)


def heaves(boat: WaveHull, met: Met) -> ComplexArray:
    """Heave upwards over elevation amidships. After Jensen, Mansour and Olsen (Ocean Engineering 31, 2004): pressure by
    Smith, resonance and damping by radiated waves, forces by the motion relative to the water."""
    return np.exp(-met.number * boat.draft_m) * _mean(boat, met) * _resonance(boat, met)


def pitches(boat: WaveHull, met: Met) -> ComplexArray:
    """Pitch, bow up, over elevation amidships, in rad/m: the mean slope along the hull, with the response of heave."""
    half = 0.5 * boat.length_m * met.number * met.ahead
    slope = met.number * met.ahead * _slope(half) * _sinc(0.5 * boat.beam_m * met.number * met.across)
    return -1j * slope * np.exp(-met.number * boat.draft_m) * _resonance(boat, met)


def rolls(boat: WaveHull, met: Met) -> ComplexArray:
    """Roll, starboard down, over elevation amidships, in rad/m: one degree of freedom under the mean slope across."""
    half = 0.5 * boat.beam_m * met.number * met.across
    slope = met.number * met.across * _slope(half) * _sinc(0.5 * boat.length_m * met.number * met.ahead)
    ratio = met.encounter / boat.roll_radps
    return 1j * slope * np.exp(-met.number * boat.draft_m) / (1.0 - ratio * ratio + 2j * _ROLL_DAMPING * ratio)


def yaws(boat: WaveHull, met: Met) -> ComplexArray:
    """Rate of yaw over elevation amidships, in rad/s/m: the water's orbital motion turns a slender hull as far as its
    strain turns an ellipse of that length and beam (Jeffery 1922)."""
    length, beam = boat.length_m**2, boat.beam_m**2
    half = 0.5 * boat.length_m * met.number * met.ahead
    depth = met.number * boat.draft_m
    mean = -np.expm1(-depth) / depth * _slope(half) * _sinc(0.5 * boat.beam_m * met.number * met.across)
    slender = (length - beam) / (length + beam)
    made: ComplexArray = -1j * slender * met.omega * met.number * met.ahead * met.across * mean
    return made


def _resonance(boat: WaveHull, met: Met) -> ComplexArray:
    """Heave over the mean elevation under the hull."""
    number = met.encounter * met.encounter / GRAVITY_MPS2
    width = np.clip(0.5 * number * boat.hull_beam_m, 1e-9, 0.5 * math.pi)
    radiated: Array = 2.0 * np.sin(width) * np.exp(-number * boat.draft_m)
    damped: ComplexArray = 1j * radiated * radiated / (2.0 * width)
    inertia = number * boat.draft_m  # added mass is taken to be as large as the mass
    made: ComplexArray = (1.0 - inertia + damped) / (1.0 - 2.0 * inertia + damped)
    return made


def _mean(boat: WaveHull, met: Met) -> Array:
    """Mean of a wave over length and beam, over its value amidships."""
    along = _sinc(0.5 * boat.length_m * met.number * met.ahead)
    return along * _sinc(0.5 * boat.beam_m * met.number * met.across)


def _sinc(x: Array) -> Array:
    made: Array = np.sinc(x / math.pi)
    return made


def _slope(x: Array) -> Array:
    """3 (sin x − x cos x)/x³: slope of the straight line that fits a wave best, over that amidships."""
    safe = np.where(np.abs(x) < 1e-2, 1e-2, x)
    made: Array = 3.0 * (np.sin(safe) - safe * np.cos(safe)) / safe**3
    return made


class DriftTable:
    """Mean force and moment of waves that a hull reflects, over the square of their amplitude.

    Faltinsen et al. (1980) for short waves: ½ρg R² ∫ (n·e)² along the waterline that they meet, against its normal n;
    as large in longer waves as the hull does not follow them: times 1 − `followed`². At speed, times 1 + 2 ω U/g
    with U against the waves. A catamaran has the ends of both its hulls and the sides of one, which shelters the other.
    """

    def __init__(self, boat: WaveHull) -> None:
        angles = np.linspace(0.0, 2.0 * math.pi, _HEADINGS, endpoint=False)
        points = _waterline(boat)
        middle, step = 0.5 * (points[1:] + points[:-1]), np.diff(points, axis=0)
        outward = np.stack([step[:, 1], -step[:, 0]], axis=1)  # normal times length
        length = np.hypot(step[:, 0], step[:, 1])
        rows = []
        for angle in angles:
            flux = outward @ np.array([math.cos(angle), math.sin(angle)])
            share = np.where(flux < 0.0, flux * flux / np.maximum(length, 1e-12) ** 2, 0.0)
            x, y = -(share * outward[:, 0]), -(share * outward[:, 1])
            rows.append((boat.hulls * x.sum(), y.sum(), (middle[:, 0] * y - middle[:, 1] * x).sum()))
        table = 0.5 * WATER_KGPM3 * GRAVITY_MPS2 * REFLECTED * np.array(rows)
        self._table = np.vstack([table, table[:1]])  # closed, to interpolate

    def coefficients(self, boat: WaveHull, met: Met, surge_mps: float, sway_mps: float) -> Array:
        """(3, N): surge and sway in N/m², yaw in Nm/m², at that velocity through the water."""
        at = np.arctan2(met.across, met.ahead) % (2.0 * math.pi) * (_HEADINGS / (2.0 * math.pi))
        low = at.astype(int) % _HEADINGS
        part = (at - np.floor(at))[:, None]
        shape = self._table[low] * (1.0 - part) + self._table[low + 1] * part
        with_waves = surge_mps * met.ahead + sway_mps * met.across
        speed = np.maximum(0.0, 1.0 - 2.0 * met.omega * with_waves / GRAVITY_MPS2)
        made: Array = shape.T * (speed * (1.0 - followed(boat, met) ** 2))
        return made


def _waterline(boat: WaveHull) -> Array:
    """Points around the waterline of one hull, from the stern along port to the bow and back along starboard: a
    transom, parallel sides, and a bow that narrows along a parabola."""
    half, stern, bow = 0.5 * boat.hull_beam_m, -0.5 * boat.length_m, 0.5 * boat.length_m
    if boat.blunt:
        side = np.array([[stern, half], [bow, half]])
    else:
        shoulder = bow - _BOW * boat.length_m
        x = np.linspace(shoulder, bow, _PANELS + 1)
        side = np.vstack(
            [[[stern, half]], np.stack([x, half * (1.0 - ((x - shoulder) / (bow - shoulder)) ** 2)], axis=1)]
        )
    port = side * np.array([1.0, -1.0])
    return np.vstack([port, side[::-1], port[:1]])
