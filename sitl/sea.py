"""A sea state as a boat in it meets it: first-order motion, slow drift, and the water at the thrusters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.config.dimensions.form import GRAVITY_MPS2
from companion.core.angles import wrap_pi
from sitl.environment import Waves, WindModel
from sitl.hull import Hull
from sitl.sea_state import Components
from sitl.wake import Wake
from sitl.wake_feel import ARM_SHARE, WakeFeel
from sitl.wave_hull import DriftTable, Met, WaveHull, followed, heaves, pitches, rolls, yaws

Array = NDArray[np.float64]

_EVERY_S = 0.1  # between two looks at heading and speed, to which the responses then go
_SETTLES = 12  # looks, after which the responses are there: what is left falls by 0.7 from one to the next
_TURNED_RAD, _FASTER_MPS = 0.03, 0.1  # a smaller change is not worth new ones
_WAKE_TILT = 0.6  # share of a wake's slope that the hull follows
_HEAVE, _HEAVE_RATE, _HEAVE_ACC, _ROLL, _PITCH, _YAW, _NORTH, _EAST, _RE, _IM = range(10)
_DRIFT = 10  # three pairs: real and imaginary part, of surge, sway and yaw
_PLACES = 16  # from here on, three a place in the boat: water to north and east beside the hull's own, elevation
_ROWS_A_PLACE = 3


class Sea(Waves):
    """Every signal is a sum over the components of Re(H a e^{iθ}), θ = ω t − k·x + ε, and so at the frequency of
    encounter; the responses H of `wave_hull` follow heading and speed. As in all first-order theory, x is the hull's
    place without the motion to and fro, so that Stokes's drift is left out.

    Out, beside `Waves`: `orbit`, velocity north and east and rate of yaw with which the water carries the hull along,
    and `force()`, the drift: Newman's approximation (1974), Σ_j Σ_k a_j a_k ½(T_j + T_k) cos(θ_j − θ_k), as the product
    of the two sums Σ a T e^{iθ} and Σ a e^{−iθ}, plus what the wakes of other boats push.
    """

    __slots__ = (
        "_at",
        "_boat",
        "_components",
        "_count",
        "_drift_on",
        "_due_s",
        "_hull",
        "_matrix",
        "_numbers",
        "_phase",
        "_place",
        "_places",
        "_rise",
        "_settling",
        "_steeper",
        "_sums",
        "_t_s",
        "_table",
        "_target",
        "_values",
        "_wakes",
        "_waves",
        "_weight_n",
        "orbit",
    )  # fmt: skip

    def __init__(  # noqa: PLR0913
        self,
        components: Components,
        boat: WaveHull,
        hull: Hull,
        wind: WindModel,
        *,
        seed: int,
        mass_kg: float,
        places: Sequence[tuple[float, float, float]] = (),
        wakes: Sequence[Wake] = (),
        drift: bool = True,
    ) -> None:
        """`places`: points in the boat (x, y, z below the water), of which `water_at_places` tells; `drift` False: no
        drift force."""
        self._components, self._boat, self._hull, self._drift_on = components, boat, hull, drift
        self._places = tuple(places)
        self._wakes, self._weight_n = WakeFeel(wakes, boat.length_m), mass_kg * GRAVITY_MPS2
        self._table = DriftTable(boat)
        k, towards, phase = components.number_radpm, components.towards_rad, components.phase_rad
        one = np.stack([components.omega_radps, -k * np.cos(towards), -k * np.sin(towards), phase], axis=1)
        self._numbers = np.concatenate([one, one - np.array([0.0, 0.0, 0.0, 0.5 * math.pi])])
        self._count = len(k)
        self._place = np.array([0.0, 0.0, 0.0, 1.0])  # t, north, east
        self._phase = np.empty(2 * self._count)  # θ, then θ − π/2
        self._waves = np.empty(2 * self._count)  # cos θ, then sin θ
        self._t_s, self._due_s = -1.0, -math.inf
        self.roll_rad = self.pitch_rad = 0.0
        self.orbit = (0.0, 0.0, 0.0)
        self._at = self._heading_and_speed()  # those of the responses
        self._matrix = self._target = self._responses()
        self._sums = np.empty(len(self._matrix))
        self._rise, self._steeper = np.zeros_like(self._matrix), np.zeros_like(self._matrix)  # a step, and its change
        self._settling = 0  # looks until the matrix is the target
        super().__init__(wind, seed)

    def update(self, t_s: float) -> None:
        """Compute motion, orbit and drift at `t_s`."""
        hull, dt_s = self._hull, t_s - self._t_s
        begun = self._t_s >= 0.0 and dt_s > 0.0
        if t_s >= self._due_s:
            self._renew(t_s, dt_s if begun else 0.0)
        if self._settling:
            self._rise += self._steeper
            self._matrix += self._rise
        place = self._place
        place[0] = t_s
        place[1], place[2] = hull.north_m - hull.carried_north_m, hull.east_m - hull.carried_east_m
        np.dot(self._numbers, place, out=self._phase)
        np.cos(self._phase, out=self._waves)
        values = self._values = np.dot(self._matrix, self._waves, out=self._sums).tolist()
        roll, pitch = values[_ROLL], values[_PITCH]
        self._wakes.update(hull, t_s, max(dt_s, 0.0))
        bow_x, bow_y, stern_x, stern_y = self._wakes.felt
        roll -= 0.5 * _WAKE_TILT * (bow_y + stern_y)
        pitch += 0.5 * _WAKE_TILT * (bow_x + stern_x)
        self.roll_rate_radps = (roll - self.roll_rad) / dt_s if begun else 0.0
        self.pitch_rate_radps = (pitch - self.pitch_rad) / dt_s if begun else 0.0
        self.roll_rad, self.pitch_rad, self._t_s = roll, pitch, t_s
        self.half_step_s = 0.5 * dt_s if begun else 0.0
        self.heave_m, self.heave_mps, self.heave_mps2 = -values[_HEAVE], -values[_HEAVE_RATE], -values[_HEAVE_ACC]
        self.orbit = (values[_NORTH], values[_EAST], values[_YAW])

    def force(self) -> tuple[float, float, float]:
        """(surge_n, sway_n, yaw_nm) at the last update."""
        values, weight = self._values, self._weight_n
        bow_x, bow_y, stern_x, stern_y = self._wakes.felt
        arm_m = ARM_SHARE * self._boat.length_m
        x, y = -0.5 * weight * (bow_x + stern_x), -0.5 * weight * (bow_y + stern_y)
        n = -0.5 * weight * (bow_y - stern_y) * arm_m
        if not self._drift_on:
            return x, y, n
        re, im, at = values[_RE], values[_IM], values[_DRIFT:_PLACES]
        return x + at[0] * re + at[1] * im, y + at[2] * re + at[3] * im, n + at[4] * re + at[5] * im

    def water_at_places(self) -> list[tuple[float, float, float]]:
        """At each of the places in the boat: the water's velocity ahead and to starboard beyond what carries the hull
        along, and the water above the place at rest plus the elevation beyond the hull's own motion, in m."""
        values, at, found = self._values, _PLACES, []
        c, s = math.cos(self._hull.yaw_rad), math.sin(self._hull.yaw_rad)
        heave, pitch, roll = self.heave_m, self.pitch_rad, self.roll_rad
        for x, y, z in self._places:
            north, east, up = values[at], values[at + 1], values[at + 2]
            found.append((c * north + s * east, c * east - s * north, z + up + heave - x * pitch + y * roll))
            at += _ROWS_A_PLACE
        return found

    def _renew(self, t_s: float, dt_s: float) -> None:
        """Go on to the responses at the present heading and speed, without a jump of the rates: an inertial sensor
        feels it. At the first step they hold at once."""
        self._due_s = t_s + _EVERY_S - 1e-9
        yaw, north, east = now = self._heading_and_speed()
        changed = abs(wrap_pi(yaw - self._at[0])) > _TURNED_RAD or (
            math.hypot(north - self._at[1], east - self._at[2]) > _FASTER_MPS
        )
        if dt_s <= 0.0:
            self._at, self._matrix, self._settling = now, self._responses(), 0
            self._target = self._matrix
            return
        if changed:
            self._at, self._target, self._settling = now, self._responses(), _SETTLES
        elif self._settling:
            self._settling -= 1
            if not self._settling:
                self._matrix, self._rise = self._target, np.zeros_like(self._rise)
        if self._settling:
            share = dt_s / _EVERY_S
            self._steeper = share * (share * (self._target - self._matrix) - self._rise)

    def _heading_and_speed(self) -> tuple[float, float, float]:
        """Heading, and velocity over ground to north and east without the orbital motion."""
        hull = self._hull
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        surge, sway = hull.water_surge_mps, hull.water_sway_mps
        north, east = c * surge - s * sway + hull.current_north_mps, s * surge + c * sway + hull.current_east_mps
        return hull.yaw_rad, north, east

    def _responses(self) -> Array:
        """The matrix that makes signals of cos θ and sin θ."""
        hull, sea = self._hull, self._components
        beside = sea.towards_rad - hull.yaw_rad
        ahead, across = np.cos(beside), np.sin(beside)
        along_mps = hull.water_surge_mps * ahead + hull.water_sway_mps * across
        north, east = np.cos(sea.towards_rad), np.sin(sea.towards_rad)
        along_mps += hull.current_north_mps * north + hull.current_east_mps * east
        number, omega, amplitude = sea.number_radpm, sea.omega_radps, sea.amplitude_m
        met = Met(number, omega, omega - number * along_mps, ahead, across)
        heave = heaves(self._boat, met)
        carried = omega * followed(self._boat, met)
        drift = self._table.coefficients(self._boat, met, hull.water_surge_mps, hull.water_sway_mps)
        rows: list[NDArray[Any]] = [heave, 1j * met.encounter * heave, -(met.encounter**2) * heave]
        rows += [rolls(self._boat, met), pitches(self._boat, met), yaws(self._boat, met)]
        rows += [carried * north, carried * east, np.ones(self._count), -1j * np.ones(self._count)]
        rows += [one for force in drift for one in (force, -1j * force)]
        for x, y, z in self._places:
            there = np.exp(-1j * number * (x * ahead + y * across))
            beyond = omega * np.exp(-number * max(z, 0.0)) * there - carried
            rows += [beyond * north, beyond * east, there]
        made = np.asarray(rows, dtype=np.complex128) * amplitude
        return np.concatenate([made.real, -made.imag], axis=1)
