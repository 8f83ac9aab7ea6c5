"""Damping ahead: friction and form of the hull, and the thrust that propellers lose with speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import GRAVITY_MPS2, WATER_KGPM3, Dimensions
from companion.config.hull import humps

_VISCOSITY_M2PS = 1.19e-6  # sea water at 15 °C (ITTC 7.5-02-01-03)
_KT_BOLLARD, _ADVANCE_AT_ZERO = 0.35, 0.9  # of a Wageningen B propeller of P/D 0.8 to 0.9 (Carlton 2012, ch. 6)
_DISC_LOAD_PA = 4000.0  # bollard thrust over disc area where the diameter is unknown: between trolling motors and pods
_THRUST_SHARE = 0.5  # of full thrust at which the loss is taken: it grows with the root of thrust
_HULL_SHARE = 0.8  # of full thrust at top speed: the most that a planing hull takes of it, the rest the propellers lose
_FROUDE = 0.25  # at which friction is taken
# Resistance over weight of planing hulls by volumetric Froude number: mean of Series 62 (Clement and Blount 1963) and
# of what small planing boats are rated at.
_PLANING = ((0.0, 0.0), (0.7, 0.02), (1.4, 0.10), (1.9, 0.145), (2.8, 0.135), (4.2, 0.185), (5.6, 0.28), (7.2, 0.42))


def friction(boat: Dimensions, speed_mps: float) -> float:
    """ITTC-57 line: C_F = 0.075 / (log10 Re − 2)²."""
    reynolds = max(1.0e4, speed_mps * boat.length_m / _VISCOSITY_M2PS)
    return float(0.075 / (math.log10(reynolds) - 2.0) ** 2)


def form_factor(boat: Dimensions) -> float:
    """1 + k, of Watanabe: k = −0.095 + 25.6 C_B / ((L/B)² √(B/T)), within 0.1 and 0.6."""
    slender = (boat.length_m / boat.hull_beam_m) ** 2 * math.sqrt(boat.hull_beam_m / boat.draft_m)
    return 1.0 + min(0.6, max(0.1, -0.095 + 25.6 * boat.block / slender))


def quadratic(boat: Dimensions) -> float:
    """x_uu = ½ ρ S (C_F (1 + k) + C_r), in N per (m/s)²."""
    speed_mps = _FROUDE * math.sqrt(GRAVITY_MPS2 * boat.length_m)
    total = friction(boat, speed_mps) * form_factor(boat) + boat.traits.residual
    return 0.5 * WATER_KGPM3 * boat.wetted_m2 * total


def thrust_loss(ahead_n: float, diameter_m: float | None) -> float:
    """Thrust that a propeller loses with speed, at half thrust, N per (m/s): D √(K_T ρ T) / J₀, of K_T (1 − J/J₀)."""
    return (
        propeller_across_m(ahead_n, diameter_m)
        * math.sqrt(_KT_BOLLARD * WATER_KGPM3 * _THRUST_SHARE * ahead_n)
        / _ADVANCE_AT_ZERO
    )


def propeller_across_m(ahead_n: float, diameter_m: float | None) -> float:
    """The diameter of a propeller; where it is unknown, of one with the usual load of its disc."""
    return math.sqrt(4.0 * ahead_n / (math.pi * _DISC_LOAD_PA)) if diameter_m is None else diameter_m


def pushes_ahead(thruster: ThrusterConfig) -> bool:
    """Whether it can push the boat ahead."""
    return thruster.turns or abs(math.cos(thruster.azimuth_rad)) > 0.5


def full_ahead_n(thrusters: Sequence[ThrusterConfig], ahead_mps: float = 0.0) -> float:
    """Thrust of all together ahead, by their pull. Of a jet, what its curve gives at that speed."""
    return sum(_full_n(t, ahead_mps) for t in thrusters if pushes_ahead(t))


def _full_n(thruster: ThrusterConfig, ahead_mps: float) -> float:
    if thruster.jet is not None:
        return thruster.jet.full_n(ahead_mps)
    ahead = 1.0 if thruster.turns else math.cos(thruster.azimuth_rad)
    return max(thruster.max_n * ahead, thruster.min_n * ahead)


def linear(thrusters: Sequence[ThrusterConfig]) -> float:
    """x_u: what all propellers that push ahead lose. A jet's own curve has its loss."""
    return sum(thrust_loss(t.max_n, t.propeller_m) for t in thrusters if t.kind != "jet" and pushes_ahead(t))


def planing_table(boat: Dimensions, thrusters: Sequence[ThrusterConfig]) -> tuple[tuple[float, float], ...]:
    """Resistance of a planing hull, as (speed m/s, force N). Where its top speed is known and its full thrust is less
    than that hulls usually need there, the resistance is less in proportion. A jet's curve says what is left of its
    thrust there, so the hull takes just that."""
    usual = _usual_resistance(boat)
    share = 1.0
    if boat.top_speed_mps is not None:
        usual_n = _force_n(usual, boat.top_speed_mps)
        if linear(thrusters) > 0.0:
            share = min(1.0, _HULL_SHARE * full_ahead_n(thrusters) / usual_n)
        elif any(thruster.jet is not None for thruster in thrusters):
            share = full_ahead_n(thrusters, boat.top_speed_mps) / usual_n
    return tuple((round(speed_mps, 2), round(share * force_n, 1)) for speed_mps, force_n in usual)


def planes(boat: Dimensions, thrusters: Sequence[ThrusterConfig]) -> bool:
    """Whether full thrust takes a planing hull over the hump of its resistance."""
    last = humps(planing_table(boat, thrusters) if boat.form == "planing" else ())[-1:]
    loss = linear(thrusters)
    return any(full_ahead_n(thrusters, mps) - loss * mps > force_n for mps, force_n in last)


def usual_speed_mps(boat: Dimensions, force_n: float) -> float:
    """The highest speed at which hulls of this form and mass usually take no more than that force."""
    if boat.form != "planing":
        return math.sqrt(force_n / quadratic(boat))
    pairs = tuple(pairwise(_usual_resistance(boat)))
    for (low_mps, low_n), (high_mps, high_n) in reversed(pairs):
        if force_n >= low_n:  # the last two points go on beyond the table's end
            return low_mps + (force_n - low_n) / (high_n - low_n) * (high_mps - low_mps)
    return 0.0


def _usual_resistance(boat: Dimensions) -> list[tuple[float, float]]:
    unit_mps = math.sqrt(GRAVITY_MPS2 * boat.hull_volume_m3 ** (1.0 / 3.0))
    weight_n = boat.mass_kg * GRAVITY_MPS2
    return [(froude * unit_mps, share * weight_n) for froude, share in _PLANING]


def _planing_loss(boat: Dimensions, thrusters: Sequence[ThrusterConfig], top_speed_mps: float) -> float:
    """x_u with which full thrust drives a planing hull at its top speed: what the hull does not take there, the
    propellers lose."""
    return (full_ahead_n(thrusters) - _force_n(planing_table(boat, thrusters), top_speed_mps)) / top_speed_mps


def _force_n(table: Sequence[tuple[float, float]], speed_mps: float) -> float:
    """As `HullConfig.drag_n` reads the table: beyond its end, by the slope of the last two points."""
    (low_mps, low_n), (high_mps, high_n) = table[-2:]
    if speed_mps > high_mps:
        return high_n + (high_n - low_n) / (high_mps - low_mps) * (speed_mps - high_mps)
    return float(np.interp(speed_mps, [speed for speed, _ in table], [force for _, force in table]))


def figures(boat: Dimensions, thrusters: Sequence[ThrusterConfig]) -> tuple[Figure, ...]:
    """x_u and x_uu. Both are scaled to the top speed where that is known."""
    x_u, x_uu, factor, by_speed = linear(thrusters), quadratic(boat), 2.3, ""
    if boat.form == "planing":
        x_uu = 0.0  # the table of resistance has it
        if boat.top_speed_mps is not None and x_u > 0.0:
            x_u, factor = _planing_loss(boat, thrusters, boat.top_speed_mps), 1.6
            by_speed = ", but as much as full thrust gives the top speed"
    elif boat.top_speed_mps is not None:
        drag_n = x_u * boat.top_speed_mps + x_uu * boat.top_speed_mps**2
        scale = full_ahead_n(thrusters, boat.top_speed_mps) / drag_n if drag_n > 0.0 else 1.0
        x_u, x_uu, factor = scale * x_u, scale * x_uu, 1.6
        by_speed = ", scaled so that full thrust gives the top speed"
    return (
        Figure(
            "hull.damping.x_u",
            x_u,
            factor,
            "D √(K_T ρ T) / J₀ for each propeller ahead" + by_speed,
            "Wageningen B series, in Carlton, Marine Propellers (2012)",
        ),
        Figure(
            "hull.damping.x_uu",
            x_uu,
            factor,
            "½ ρ S (C_F (1 + k) + C_r)" + by_speed,
            "ITTC-57; Watanabe; Denny and Mumford",
        ),
    )
