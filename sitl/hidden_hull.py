"""Random boats whose owner knows only what a person can type, and which are something else in truth.

`hidden_hull(seed)` draws a form, dimensions and thrusters, writes the vessel's file from them, and then a boat with
thrust, drag, added mass, windage, delays, sensors and mountings off by up to half of what the file's formulae say.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace

from companion.config.devices import SensorConfig, ThrusterConfig
from companion.config.dimensions.form import LEAST_BLOCK, MOST_BLOCK, TRAITS, WATER_KGPM3
from companion.config.hull import DampingConfig, HullConfig
from companion.config.vessel import AS_MODELLED, PlantConfig, VesselConfig, parse

_MASS_KG = (15.0, 2000.0)
_LENGTH_M = (1.0, 8.0)
_OFF = 0.5
_BLADE_OFF = 0.3  # of a rudder's side force; its race is off besides
_FORMS = ("monohull", "catamaran", "inflatable", "barge")
PROPULSIONS = ("two fixed", "fixed and bow", "one azimuth", "two azimuths", "outboard")
RUDDERS = ("rudder", "rudder and bow", "two rudders")
_RUDDERS = 6  # one boat of so many has a rudder
_LAG_S = (0.1, 0.6)
_COMPASS_RAD = math.radians(8.0)
_MISTAKEN = 0.3  # share of boats with a wrong place of antenna and thrusters


@dataclass(frozen=True, slots=True)
class HiddenHull:
    """`text`: the vessel's file; `known`: as the controller reads it; `real`: as the boat is. `propulsion`: one of
    PROPULSIONS or RUDDERS. `mistaken`: antenna and thrusters are not where the file has them."""

    seed: int
    text: str
    known: VesselConfig
    real: VesselConfig
    propulsion: str
    mistaken: bool


def hidden_hull(seed: int) -> HiddenHull:
    """The boat of that seed."""
    draw = random.Random(f"hidden hull {seed}")
    propulsion = draw.choice(PROPULSIONS)
    apart = random.Random(f"rudder {seed}")  # so that the other boats stay what they are
    if apart.randrange(_RUDDERS) == 0:
        propulsion = apart.choice(RUDDERS)
    text = _file(draw, seed, propulsion)
    known = parse(text, f"hidden hull {seed}")
    mistaken = draw.random() < _MISTAKEN
    return HiddenHull(seed, text, known, _real(draw, known, mistaken, seed), propulsion, mistaken)


# --- what the owner types -----------------------------------------------------------------------------------------


def _file(draw: random.Random, seed: int, propulsion: str) -> str:
    while True:
        form = draw.choice(_FORMS)
        length = math.exp(draw.uniform(math.log(_LENGTH_M[0]), math.log(_LENGTH_M[1])))
        beam = length / draw.uniform(*((1.7, 2.5) if form == "catamaran" else (2.2, 4.5)))
        hull_beam = beam * draw.uniform(0.2, 0.3) if form == "catamaran" else beam * TRAITS[form].waterline
        draft = hull_beam * draw.uniform(0.25, 0.5)
        block = min(0.95 * MOST_BLOCK, max(1.1 * LEAST_BLOCK, TRAITS[form].block * draw.uniform(0.85, 1.1)))
        hulls = 2 if form == "catamaran" else 1
        mass = hulls * block * length * hull_beam * draft * WATER_KGPM3
        if _MASS_KG[0] <= mass <= _MASS_KG[1]:
            break
    twin = f"hull_beam_m = {hull_beam:.2f}\n" if form == "catamaran" else ""
    rtk = draw.random() < 0.5
    compass = "" if rtk else 'heading = "magnetic"\n'
    thrusters = _thrusters(draw, propulsion, length, beam, mass)
    names = ", ".join(f'"{name}"' for name, _ in thrusters)
    return (
        f'name = "hidden{seed}"\ntitle = "Hidden hull {seed}"\ncontrol_rate_hz = 10.0\n'
        "[home]\nlat_deg = 60.41\nlon_deg = 22.07\n"
        f'[hull]\nform = "{form}"\nlength_m = {length:.2f}\nbeam_m = {beam:.2f}\nmass_kg = {mass:.0f}\n{twin}'
        f"{''.join(row for _, row in thrusters)}"
        '[[sensor]]\nname = "gnss"\ndriver = "nmea0183"\nport = "serial:/dev/usv-gnss:115200"\n'
        f"antennas = {2 if rtk else 1}\nrate_hz = 10.0\nx_m = {-0.2 * length:.2f}\n"
        '[[sensor]]\nname = "imu"\ndriver = "mtdata2"\nport = "serial:/dev/usv-imu:115200"\nrate_hz = 100.0\n'
        f"timeout_s = 0.5\n{compass}"
        f'[[actuator]]\nname = "mcu"\ndriver = "microcontroller"\nport = "serial:/dev/usv-mcu:115200"\n'
        f"thrusters = [{names}]\n"
    )


def _thrusters(draw: random.Random, propulsion: str, length: float, beam: float, mass: float) -> list[tuple[str, str]]:
    total = mass**0.75 * draw.uniform(1.5, 4.0)
    stern, side = -0.4 * length, 0.35 * beam
    if propulsion == "two fixed":
        return [_fixed("port", stern, -side, 0.5 * total), _fixed("starboard", stern, side, 0.5 * total)]
    if propulsion == "fixed and bow":
        return [
            _fixed("port", stern, -side, 0.5 * total),
            _fixed("starboard", stern, side, 0.5 * total),
            _fixed("bow", 0.35 * length, 0.0, 0.25 * total, 90.0),
        ]
    if propulsion == "one azimuth":
        return [_azimuth("pod", stern, 0.0, total)]
    if propulsion == "two azimuths":
        return [_azimuth("bow", 0.35 * length, 0.0, 0.5 * total), _azimuth("stern", stern, 0.0, 0.5 * total)]
    if propulsion == "rudder":
        return [_rudder("propeller", stern, 0.0, total)]
    if propulsion == "rudder and bow":
        return [
            _rudder("propeller", stern, 0.0, total),
            _fixed("bow", 0.35 * length, 0.0, 0.2 * total, 90.0),
        ]
    if propulsion == "two rudders":
        return [_rudder("port", stern, -side, 0.5 * total), _rudder("starboard", stern, side, 0.5 * total)]
    return [_azimuth("outboard", -0.5 * length, 0.0, total, 40.0)]


def _fixed(name: str, x_m: float, y_m: float, max_n: float, azimuth_deg: float = 0.0) -> tuple[str, str]:
    row = f'[[thruster]]\nname = "{name}"\nkind = "fixed"\nx_m = {x_m:.2f}\ny_m = {y_m:.2f}\n'
    return name, f"{row}azimuth_deg = {azimuth_deg:.0f}\nmax_n = {max_n:.1f}\n"


def _rudder(name: str, x_m: float, y_m: float, max_n: float) -> tuple[str, str]:
    row = f'[[thruster]]\nname = "{name}"\nkind = "rudder"\nx_m = {x_m:.2f}\ny_m = {y_m:.2f}\n'
    return name, f"{row}max_n = {max_n:.1f}\n"


def _azimuth(name: str, x_m: float, y_m: float, max_n: float, stop_deg: float | None = None) -> tuple[str, str]:
    row = f'[[thruster]]\nname = "{name}"\nkind = "azimuth"\nx_m = {x_m:.2f}\ny_m = {y_m:.2f}\nmax_n = {max_n:.1f}\n'
    stops = "" if stop_deg is None else f"azimuth_min_deg = {-stop_deg:.0f}\nazimuth_max_deg = {stop_deg:.0f}\n"
    return name, f"{row}azimuth_rate_dps = 60\nmanual_azimuth_deg = 40\n{stops}"


# --- what the boat is ---------------------------------------------------------------------------------------------


def _real(draw: random.Random, known: VesselConfig, mistaken: bool, seed: int) -> VesselConfig:
    hull = _hull(draw, known.hull)
    w = known.windage
    windage = replace(w, frontal_m2=w.frontal_m2 * _off(draw), lateral_m2=w.lateral_m2 * _off(draw))
    strength = _off(draw)
    shift_m = draw.uniform(-0.15, 0.15) * known.length_m if mistaken else 0.0
    dead = draw.uniform(0.0, 0.06)
    thrusters = tuple(
        _thruster(_blade(seed, t), strength * draw.uniform(0.93, 1.07), shift_m, dead) for t in known.thrusters
    )
    plant = PlantConfig(hull=hull, windage=windage, thruster_lag_s=draw.uniform(*_LAG_S))
    assert known.sitl is not None
    return replace(
        known,
        hull=hull,
        windage=windage,
        thrusters=thrusters,
        limits=replace(
            known.limits,
            surge_n=strength * known.limits.surge_n,
            sway_n=strength * known.limits.sway_n,
            yaw_nm=strength * known.limits.yaw_nm,
        ),
        sensors=_sensors(draw, known.sensors, known.length_m, mistaken),
        sitl=replace(known.sitl, plant=AS_MODELLED, plants={AS_MODELLED: plant}),
    )


def _off(draw: random.Random) -> float:
    """A factor from 1 − _OFF to 1 + _OFF."""
    return draw.uniform(1.0 - _OFF, 1.0 + _OFF)


def _hull(draw: random.Random, hull: HullConfig) -> HullConfig:
    mass = hull.mass_kg or 0.0
    factors = {"x": _off(draw), "y": _off(draw), "n": _off(draw)}
    damping = DampingConfig(
        **{
            name: getattr(hull.damping, name) * factors[name[0]] * draw.uniform(0.9, 1.1)
            for name in DampingConfig.__slots__
        }
    )
    return replace(
        hull,
        m11_kg=mass + (hull.m11_kg - mass) * _off(draw),
        m22_kg=mass + (hull.m22_kg - mass) * _off(draw),
        m33_kgm2=hull.m33_kgm2 * draw.uniform(0.7, 1.4),
        damping=damping,
    )


def _blade(seed: int, thruster: ThrusterConfig) -> ThrusterConfig:
    """The thruster with a blade that gives more or less side force than the formula, by draws of its own."""
    draw, rudder = random.Random(f"blade {seed}"), thruster.rudder
    if rudder is None:
        return thruster
    scale, gain = draw.uniform(1.0 - _BLADE_OFF, 1.0 + _BLADE_OFF), draw.uniform(0.5, 0.75)
    return replace(thruster, rudder=replace(rudder, lift_scale=scale, race_gain=gain))


def _thruster(thruster: ThrusterConfig, strength: float, shift_m: float, dead: float) -> ThrusterConfig:
    rudder = thruster.rudder
    return replace(
        thruster,
        x_m=thruster.x_m + shift_m,
        rudder=None if rudder is None else replace(rudder, x_m=rudder.x_m + shift_m),
        max_n=strength * thruster.max_n,
        min_n=strength * thruster.min_n,
        ahead_n=strength * thruster.ahead_n,
        astern_n=strength * thruster.astern_n,
        dead_band=dead,
    )


def _sensors(
    draw: random.Random, sensors: Sequence[SensorConfig], length_m: float, mistaken: bool
) -> tuple[SensorConfig, ...]:
    off_rad, shift_m = draw.uniform(-_COMPASS_RAD, _COMPASS_RAD), draw.uniform(-0.15, 0.15) * length_m
    return tuple(
        replace(
            sensor,
            heading_offset_rad=sensor.heading_offset_rad
            + (off_rad if sensor.heading != "none" or sensor.driver == "nmea0183" else 0.0),
            x_m=sensor.x_m + (shift_m if mistaken and sensor.driver == "nmea0183" else 0.0),
        )
        for sensor in sensors
    )
