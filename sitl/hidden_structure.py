"""Hidden hulls whose equations have terms that their file lacks, or lack some that it has, and the sea around them.

`structured_hull(seed)` is the hidden hull of that seed with, by draws of its own: sway and yaw coupled (a centre of
gravity, of added mass and of drag that are not amidships), no lift, cross-flow drag by strips in place of the
quadratic terms, a wind sensor. `water_of` draws wind, current and waves.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, replace

from companion.config.dimensions.form import WATER_KGPM3
from companion.config.hull import HullConfig
from companion.config.hull_flow import CrossFlowConfig
from companion.config.vessel import AS_MODELLED, parse
from sitl.hidden_hull import HiddenHull, hidden_hull
from sitl.wave_hull import wave_hull

_COUPLED, _WITHOUT_LIFT, _STRIPS, _WIND_SENSOR = 0.5, 0.25, 0.2, 0.33  # shares of the boats
_GRAVITY_AHEAD, _ADDED_AHEAD, _DRAG_AHEAD = 0.05, 0.04, 0.12  # of the length, either way
_TURN_SHARE = 0.75  # of y_rr that strips of even drag would have: the ends are shallower
_SCATTER = (0.8, 1.2)
_WIND_MPS, _CURRENT_SHARE, _WAVES, _WAVE_SHARE = (1.0, 6.0), (0.0, 0.3), 0.5, (0.01, 0.05)
_GUSTS = ("", "", "/davenport", "/npd")
_ANEMOMETER = '[[sensor]]\nname = "wind"\ndriver = "nmea0183"\nport = "serial:/dev/usv-wind:4800"\nrate_hz = 5.0\n'


@dataclass(frozen=True, slots=True)
class Structure:
    """What a hidden hull has beside the terms of its file, and what it has not."""

    coupled: bool
    lift: bool
    strips: bool
    wind_sensor: bool


@dataclass(frozen=True, slots=True)
class Water:
    """`wind`, `waves`: as a scenario takes them. `current_share`: of the boat's top speed."""

    wind: str
    current_share: float
    waves: str


def structure_of(seed: int) -> Structure:
    """What the boat of that seed has."""
    draw = random.Random(f"structure {seed}")
    coupled, lift = draw.random() < _COUPLED, draw.random() >= _WITHOUT_LIFT
    strips, sensor = draw.random() < _STRIPS, draw.random() < _WIND_SENSOR
    return Structure(coupled, lift, strips, sensor)


def water_of(boat: HiddenHull) -> Water:
    """The sea around it: gusts plain or by a spectrum, waves by the boat's length around every second boat."""
    draw = random.Random(f"water {boat.seed}")
    wind = f"{draw.uniform(*_WIND_MPS):.1f}{draw.choice(_GUSTS)}"
    current = draw.uniform(*_CURRENT_SHARE)
    high = draw.uniform(*_WAVE_SHARE) * boat.known.length_m
    return Water(wind, current, f"{high:.3f}" if draw.random() < _WAVES else "")


def structured_hull(seed: int) -> HiddenHull:
    """The boat of that seed."""
    boat, structure = hidden_hull(seed), structure_of(seed)
    text, known, real = boat.text, boat.known, boat.real
    if structure.wind_sensor:
        text += _ANEMOMETER
        known = parse(text, f"hidden hull {seed}")
        real = replace(real, sensors=(*real.sensors, known.sensors[-1]))
    assert real.sitl is not None
    plant = real.sitl.plants[AS_MODELLED]
    hull, length_m = real.hull, known.length_m
    if not structure.lift:
        hull = replace(hull, damping=replace(hull.damping, y_uv=0.0, n_uv=0.0, n_ur=0.0))
    if structure.coupled:
        hull = _coupled(random.Random(f"coupling {seed}"), hull, length_m)
    flow = None
    if structure.strips:
        draft_m = wave_hull(hull, known).draft_m
        flow = CrossFlowConfig(hull.damping.y_vv / (0.5 * WATER_KGPM3 * draft_m * length_m))
        hull = replace(hull, damping=replace(hull.damping, y_vv=0.0, n_rr=0.0, n_vv=0.0, y_rr=0.0))
    plants = {AS_MODELLED: replace(plant, hull=hull, cross_flow=flow)}
    real = replace(real, hull=hull, sitl=replace(real.sitl, plants=plants))
    return replace(boat, text=text, known=known, real=real)


def _coupled(draw: random.Random, hull: HullConfig, length_m: float) -> HullConfig:
    """The hull with its centres off amidships: m23 of gravity and added mass, the rest as drag at a place ahead has
    it."""
    mass = hull.mass_kg or 0.0
    gravity_m, added_m, drag_m = (
        draw.uniform(-share, share) * length_m for share in (_GRAVITY_AHEAD, _ADDED_AHEAD, _DRAG_AHEAD)
    )
    d = hull.damping
    turn = 0.5 * _TURN_SHARE * length_m * drag_m * d.y_vv
    damping = replace(
        d,
        n_v=drag_m * d.y_v * draw.uniform(*_SCATTER),
        n_vv=drag_m * d.y_vv * draw.uniform(*_SCATTER),
        y_r=drag_m * d.y_v * draw.uniform(*_SCATTER),
        y_rr=turn * draw.uniform(*_SCATTER),
    )
    return replace(hull, m23_kgm=mass * gravity_m + (hull.m22_kg - mass) * added_m, damping=damping)
