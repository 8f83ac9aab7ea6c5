"""A rudder behind a propeller on a boat that drifts and turns: what the hull feels of it, over a whole log.

Formulae and sources: `companion.config.rudder`. Beside them the drift of the blade, of which hull and race straighten a
share (MMG, Yasukawa and Yoshimura 2015), and the flow from its trailing edge on the way astern.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.fins import STRAIGHTENED
from companion.config.dimensions.form import WATER_KGPM3
from companion.config.rudder import RudderConfig

Array = NDArray[np.float64]

_BACKWARDS = 0.6  # share of the lift with the flow from the trailing edge
_STALL_RAD = math.radians(35.0)  # in a race the flow stays on the blade longer than in free water (Molland 1992)
_PLATE_DRAG = 1.2  # of a flat plate across the flow (Hoerner 1965)


@dataclass(frozen=True, slots=True)
class BladeForce:
    """(n,) each: `surge_n` of the blade alone, `sway_n`, and by how much sway_n falls for each m/s with which the blade
    moves to starboard."""

    surge_n: Array
    sway_n: Array
    fin: Array


@dataclass(frozen=True, slots=True)
class Blade:
    """`rudder`, `disc_m2` of its propeller: as in the vessel's file."""

    rudder: RudderConfig
    disc_m2: float

    def force(self, thrust_n: Array, angle_rad: Array, surge_mps: Array, across_mps: Array, gain: float) -> BladeForce:
        """The force for thrust (n,) along the hull, angles (n,), and velocities (n,) through the water, ahead and, of
        the blade, to starboard. `gain`: share of the race's extra speed that the blade feels. For a `lift_scale` of
        the vessel's file."""
        blade = self.rudder
        free = (1.0 - blade.wake_share) * surge_mps
        ahead = np.maximum(free, 0.0)
        jet = np.sqrt(ahead * ahead + np.maximum(thrust_n, 0.0) / (0.5 * WATER_KGPM3 * self.disc_m2))
        raced = ahead + gain * (jet - ahead)
        slowed = np.sqrt(
            np.maximum(ahead * ahead + np.minimum(thrust_n, 0.0) / (0.5 * WATER_KGPM3 * self.disc_m2), 0.0)
        )
        braked = np.where(slowed > 0.0, slowed, np.minimum(free, 0.0))
        race = np.where(thrust_n < 0.0, braked, np.where(raced > -free, raced, free))
        drift = STRAIGHTENED * across_mps
        shares = ((blade.race_share, race), (1.0 - blade.race_share, free))
        parts = [(share, self._in_flow(along, drift, angle_rad)) for share, along in shares]
        surge, sway, fin = (sum(share * part[i] for share, part in parts) for i in range(3))
        return BladeForce(np.asarray(surge), np.asarray(sway), np.asarray(fin))

    def _in_flow(self, along: Array, across: Array, angle_rad: Array) -> tuple[Array, Array, Array]:
        """(surge, sway, fall of sway per m/s across) of the whole blade in a flow from ahead or astern."""
        blade, ahead = self.rudder, along >= 0.0
        speed = np.hypot(along, across)
        drift = np.arctan2(across, np.abs(along))
        angle = np.where(ahead, angle_rad, -angle_rad) - drift
        size = np.abs(angle)
        at = np.minimum(size, _STALL_RAD)
        lift = (blade.slope + blade.cross_flow * at) * at
        drag = np.asarray(blade.drag(lift))
        stalled = np.where(size > _STALL_RAD, np.cos(size) / math.cos(_STALL_RAD), 1.0)
        plate = np.clip(np.sin(np.minimum(size, 0.5 * math.pi)) - math.sin(_STALL_RAD), 0.0, None)
        drag += (np.maximum(_PLATE_DRAG, drag) - drag) * plate / (1.0 - math.sin(_STALL_RAD))
        lift = np.sign(angle) * lift * stalled * np.where(ahead, 1.0, _BACKWARDS)
        pressure = 0.5 * WATER_KGPM3 * blade.area_m2 * blade.lift_scale * speed * speed
        c, s = np.cos(drift), np.sin(drift)
        against = pressure * (lift * s + drag * c)
        slope = (blade.slope + 2.0 * blade.cross_flow * at) * (size <= _STALL_RAD)
        fin = 0.5 * WATER_KGPM3 * blade.area_m2 * blade.lift_scale * slope * speed * STRAIGHTENED
        return (
            np.where(ahead, -against, against),
            pressure * (lift * c - drag * s),
            fin * np.where(ahead, 1.0, _BACKWARDS),
        )


def blade_of(thruster: ThrusterConfig) -> Blade | None:
    """The blade of a thruster; None without one."""
    if thruster.rudder is None or thruster.propeller_m is None:
        return None
    return Blade(thruster.rudder, 0.25 * math.pi * thruster.propeller_m**2)
