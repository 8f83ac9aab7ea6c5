"""Forces of the water on a moving hull, beyond the derivatives of its file: cross-flow drag by strips, lift."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.config.dimensions.form import WATER_KGPM3
from companion.config.hull import HullConfig
from companion.config.hull_flow import CrossFlowConfig, LiftConfig
from companion.config.vessel import PlantConfig, VesselConfig
from sitl.hull import Flow, Hull
from sitl.otter_equations import OtterHull
from sitl.wave_hull import WaveHull, wave_hull

_SURGE_ADDED = 0.05  # share of the mass that the water adds in surge, where the file has no mass


@dataclass(frozen=True, slots=True)
class Derivatives:
    """Of sway force and yaw moment per speed ahead in m/s: by sway and by rate of yaw, negative where they resist. They
    are whole: the moment by sway has the Munk moment in it, the force by yaw the added mass in surge, and neither the
    mass itself."""

    y_v: float
    y_r: float
    n_v: float
    n_r: float


def flows(plant: PlantConfig, vessel: VesselConfig) -> tuple[Flow, ...]:
    """What the plant of that vessel has beyond its derivatives; empty for a plant without such tables."""
    boat = wave_hull(plant.hull, vessel)
    found: list[Flow] = []
    if plant.cross_flow is not None:
        found.append(strips(plant.cross_flow, boat))
    if plant.lift is not None:
        found.append(lift(plant.lift, plant.hull, boat))
    return tuple(found)


def hull_of(vessel: VesselConfig, plant: PlantConfig) -> Hull:
    """The hull of a plant of that vessel, by the equations that it asks for."""
    if plant.equations != "companion":
        return OtterHull(plant.hull, plant.equations)
    return Hull(plant.hull, flows(plant, vessel))


def strips(config: CrossFlowConfig, boat: WaveHull) -> Flow:
    """Cross-flow drag: −½ρ C T ∫ |v + x r| (v + x r) (1, x) dx (Faltinsen 1990, 6; Fossen 2021, 6.4.3)."""
    length, draft = config.length_m or boat.length_m, config.draft_m or boat.draft_m
    step = length / config.strips
    factor = 0.5 * WATER_KGPM3 * config.coefficient * draft * step * config.hulls
    places = [(i + 0.5) * step - 0.5 * length for i in range(config.strips)]

    def drag(_u: float, v: float, r: float) -> tuple[float, float]:
        sway = yaw = 0.0
        for x in places:
            across = v + x * r
            one = across * abs(across)
            sway += one
            yaw += x * one
        return -factor * sway, -factor * yaw

    return drag


def lift(config: LiftConfig, hull: HullConfig, boat: WaveHull) -> Flow:
    """What the regression has beyond the plant's own C(ν)ν, and the fins: Y = −½ρ A C_L' |u| (v + x r) at their place.

    A hull is taken to be the same fore and aft: astern, force by yaw and moment by sway change their sign. Fins lead
    there.
    """
    whole = regression(config.law, hull, boat)
    fin_x_m = -0.5 * boat.length_m if config.fin_x_m is None else config.fin_x_m
    fins = 0.5 * WATER_KGPM3 * config.fin_area_m2 * lift_slope(config.fin_aspect)
    own = own_derivatives(hull)
    y_v, n_r, y_r, n_v = whole.y_v - own.y_v, whole.n_r - own.n_r, whole.y_r - own.y_r, whole.n_v - own.n_v

    def force(u: float, v: float, r: float) -> tuple[float, float]:
        speed = abs(u)
        at_fins = -fins * speed * (v + fin_x_m * r)
        sway = y_v * speed * v + y_r * u * r + at_fins
        return sway, n_v * u * v + n_r * speed * r + fin_x_m * at_fins

    return force


def regression(law: str, hull: HullConfig, boat: WaveHull) -> Derivatives:
    """The derivatives of a hull of that size by a published regression; a catamaran's hulls count singly."""
    one = _clarke(hull, boat) if law == "clarke" else _inoue(hull, boat)
    added = 0.0 if law == "clarke" else mass_kg(hull) - hull.m11_kg  # which Inoue's force by yaw counts apart
    return Derivatives(boat.hulls * one.y_v, boat.hulls * one.y_r + added, boat.hulls * one.n_v, boat.hulls * one.n_r)


def own_derivatives(hull: HullConfig) -> Derivatives:
    """What C(ν)ν of the plant gives by itself, by the definition of `Derivatives`."""
    coupling = 0.5 * (hull.m23_kgm + hull.yaw_coupling_kgm)
    return Derivatives(0.0, mass_kg(hull) - hull.m11_kg, hull.m11_kg - hull.m22_kg, -coupling)


def mass_kg(hull: HullConfig) -> float:
    """Mass without added mass."""
    return hull.mass_kg or hull.m11_kg / (1.0 + _SURGE_ADDED)


def lift_slope(aspect: float) -> float:
    """Slope of the lift coefficient of a fin, per rad: 2π Λ (Λ + 0.7)/(Λ + 1.7)² (Söding 1982)."""
    return 2.0 * math.pi * aspect * (aspect + 0.7) / (aspect + 1.7) ** 2


def _block(hull: HullConfig, boat: WaveHull) -> float:
    volume = mass_kg(hull) / WATER_KGPM3 / boat.hulls
    return min(volume / (boat.length_m * boat.hull_beam_m * boat.draft_m), 1.0)


def _clarke(hull: HullConfig, boat: WaveHull) -> Derivatives:
    """Clarke, Gedling and Hine (1983): regression of captive tests of bare hulls, on even keel."""
    length, beam, draft = boat.length_m, boat.hull_beam_m, boat.draft_m
    scale = 0.5 * WATER_KGPM3 * math.pi * draft * draft
    wide, flat, deep = beam / length, beam / draft, draft / length
    return Derivatives(
        -scale * (1.0 + 0.40 * _block(hull, boat) * flat),
        -scale * length * (-0.5 + 2.2 * wide - 0.080 * flat),
        -scale * length * (0.5 + 2.4 * deep),
        -scale * length * length * (0.25 + 0.039 * flat - 0.56 * wide),
    )


def _inoue(hull: HullConfig, boat: WaveHull) -> Derivatives:
    """Inoue, Hirano and Kijima (1981): wing of low aspect ratio 2T/L with a term of the block, on even keel."""
    length, beam, draft = boat.length_m, boat.hull_beam_m, boat.draft_m
    scale, low = 0.5 * WATER_KGPM3 * length * draft, 2.0 * draft / length
    return Derivatives(
        -scale * (0.5 * math.pi * low + 1.4 * _block(hull, boat) * beam / length),
        scale * length * 0.25 * math.pi * low,
        -scale * length * low,
        -scale * length * length * (0.54 * low - low * low),
    )
