"""The Otter by the equations and figures of another simulator: the second opinion on the companion's own plant.

Fossen's Python Vehicle Simulator (github.com/cybergalactic/PythonVehicleSimulator), otter.py and gnc.py, as of October
2023 and of March 2024, in six degrees of freedom: M ν̇_r + C(ν_r) ν_r + D(ν_r) ν_r + G η = τ + g₀ (Fossen, Handbook of
Marine Craft Hydrodynamics and Motion Control, 2nd ed., 2021). Written from the equations; nothing here is shared with
`sitl.hull.dynamics`. In both, the payload's weight pulls along a boat that is not level, with no buoyancy against it,
and the 21 strips of the cross-flow count both ends whole; `otter_mended` is that of 2024 without either.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.config.hull import HullConfig
from companion.core.angles import wrap_pi
from sitl.hull import Hull

Vector = tuple[float, float, float]
Matrix = NDArray[np.float64]

_GRAVITY_MPS2, _CROSS_WATER_KGPM3 = 9.81, 1026.0
_LENGTH_M, _BEAM_M = 2.0, 1.08
_HULL_KG, _PAYLOAD_KG = 55.0, 25.0
_HULL_CENTRE_M: Vector = (0.2, 0.0, -0.2)  # of gravity, without payload
_PAYLOAD_AT_M: Vector = (0.05, 0.0, -0.35)
_PONTOON_BEAM_M, _PONTOON_Y_M, _WATERPLANE, _BLOCK = 0.25, 0.395, 0.75, 0.4
_FLOTATION_X_M = -0.2
_TOP_MPS, _FULL_KGF = 6.0 * 0.5144, 24.4
_YAW_QUADRATIC = 10.0  # times the linear damping of yaw
_STRIPS = 20
_HOERNER = ((0.5585, 0.6464), (1.0836, 0.9986))  # beam over twice the draft, drag of a section, around the Otter's 0.64


@dataclass(frozen=True, slots=True)
class Edition:
    """What differs between them. `munk`: added mass turns with the boat in surge, sway and yaw. `sway_time_s`: time
    constant of sway; None: no linear damping. `mended`: weight has no part along the boat and across, strips end with
    the hull."""

    water_kgpm3: float
    munk: bool
    sway_time_s: float | None
    mended: bool = False


EDITIONS = {
    "otter_2023": Edition(1026.0, False, None),
    "otter_2024": Edition(1025.0, True, 1.0),
    "otter_mended": Edition(1025.0, True, 1.0, True),
}


class OtterHull(Hull):
    """A `Hull` that moves by the published equations; forces act along the boat and across. Beside its state:
    `roll_rad`, `pitch_rad`, the means of their change in the last step, `rolling_radps` and `pitching_radps`, and the
    rates about the boat's axes. It starts in its trim."""

    __slots__ = (
        "_blocks",
        "_cross_n",
        "_d",
        "_inertia",
        "_mended",
        "_munk",
        "_places",
        "_restoring",
        "_weight_n",
        "heave_m",
        "heave_mps",
        "pitch_rad",
        "pitch_rate_radps",
        "pitching_radps",
        "roll_rad",
        "roll_rate_radps",
        "rolling_radps",
    )

    def __init__(self, config: HullConfig, edition: str) -> None:
        """`config` is there for what else a plant needs of its hull. `edition`: a key of EDITIONS."""
        chosen = EDITIONS[edition]
        self._munk, self._mended = chosen.munk, chosen.mended
        self._prepare(chosen)
        self.roll_rad = self.pitch_rad = self.heave_m = 0.0
        self.roll_rate_radps = self.pitch_rate_radps = self.heave_mps = 0.0
        self.rolling_radps = self.pitching_radps = 0.0
        super().__init__(config)
        self._settle()

    # --- figures -----------------------------------------------------------------------------------------------------

    def _prepare(self, chosen: Edition) -> None:
        """Matrices of the published figures: `_inertia` holds mass, centre of gravity, rigid inertia and the diagonal
        of added mass; `_blocks` the inverse inertia of (surge, heave, pitch) and (sway, roll, yaw)."""
        mass = _HULL_KG + _PAYLOAD_KG
        centre = (_HULL_KG * np.array(_HULL_CENTRE_M) + _PAYLOAD_KG * np.array(_PAYLOAD_AT_M)) / mass
        radii = np.array([0.4 * _BEAM_M, 0.25 * _LENGTH_M, 0.25 * _LENGTH_M])
        at_centre, at_payload = _cross_matrix(centre), _cross_matrix(np.array(_PAYLOAD_AT_M))
        own = _HULL_KG * (np.diag(radii**2) - at_centre @ at_centre) - _PAYLOAD_KG * at_payload @ at_payload
        move = np.eye(6)
        move[:3, 3:] = at_centre.T
        rigid = np.zeros((6, 6))
        rigid[:3, :3], rigid[3:, 3:] = mass * np.eye(3), own
        added = np.array([0.1, 1.5, 1.0, 0.0, 0.0, 0.0]) * _HULL_KG
        added[3:] = np.array([0.2, 0.8, 1.7]) * np.diag(own)
        whole = move.T @ rigid @ move + np.diag(added)
        self._inertia = (mass, tuple(centre.tolist()), [tuple(row) for row in own.tolist()], tuple(added.tolist()))
        self._blocks = [
            [tuple(row) for row in np.linalg.inv(whole[np.ix_(axes, axes)]).tolist()] for axes in ([0, 2, 4], [1, 3, 5])
        ]
        draft = mass / chosen.water_kgpm3 / (2.0 * _BLOCK * _PONTOON_BEAM_M * _LENGTH_M)
        self._restoring = _restoring(chosen.water_kgpm3, mass, draft, float(centre[2]))
        self._d = _damping(whole, self._restoring, chosen)
        share = 0.5 * _PONTOON_BEAM_M / draft
        drag = float(np.interp(share, *_HOERNER))
        self._cross_n = 0.5 * _CROSS_WATER_KGPM3 * draft * drag * _LENGTH_M / _STRIPS
        ends = (0.5, _STRIPS) if chosen.mended else (0.0, _STRIPS + 1)
        self._places = [((i + ends[0]) / _STRIPS - 0.5) * _LENGTH_M for i in range(int(ends[1]))]
        self._weight_n = _PAYLOAD_KG * _GRAVITY_MPS2

    def _settle(self) -> None:
        """Put heave and pitch where the payload's weight and the water balance."""
        for _ in range(20):
            _, _, down, _, trim, _ = self._static()
            g33, _, g55, g35 = self._restoring
            scale = g33 * g55 - g35 * g35
            self.heave_m += (g55 * down - g35 * trim) / scale
            self.pitch_rad += (g33 * trim - g35 * down) / scale

    @property
    def trim_n(self) -> float:
        """Force ahead of the payload's weight in the present trim."""
        return self._static()[0]

    @property
    def trim_kg(self) -> float:
        """What the same weight adds to the inertia in surge, as acceleration pitches the boat."""
        mass, centre, *_ = self._inertia
        heave, _, pitch, both = self._restoring
        stiffness = pitch - both * both / heave + self._weight_n * _PAYLOAD_AT_M[2]
        return 0.0 if self._mended else -self._weight_n * mass * centre[2] / stiffness

    # --- equations ---------------------------------------------------------------------------------------------------

    def _static(self) -> tuple[float, ...]:
        """Weight of the payload and the water's restoring force, in the six axes."""
        g33, g44, g55, g35 = self._restoring
        s_roll, c_roll = math.sin(self.roll_rad), math.cos(self.roll_rad)
        s_pitch, c_pitch = math.sin(self.pitch_rad), math.cos(self.pitch_rad)
        weight = self._weight_n
        force = (-weight * s_pitch, weight * c_pitch * s_roll, weight * c_pitch * c_roll)
        k, m, n = _cross(_PAYLOAD_AT_M, force)
        along, across = (0.0, 0.0) if self._mended else force[:2]
        return (
            along,
            across,
            force[2] - g33 * self.heave_m - g35 * self.pitch_rad,
            k - g44 * self.roll_rad,
            m - g55 * self.pitch_rad - g35 * self.heave_m,
            n,
        )

    def _turning(self, speed: Vector, turn: Vector) -> tuple[Vector, Vector]:
        """C(ν) ν: of the rigid body about its centre of gravity, and of the added mass (without products of surge, sway
        and yaw in the yaw row and of yaw in surge and sway where the edition leaves them out)."""
        mass, centre, own, added = self._inertia
        at_centre = _cross(turn, centre)
        whirl = _cross(turn, (speed[0] + at_centre[0], speed[1] + at_centre[1], speed[2] + at_centre[2]))
        force = (mass * whirl[0], mass * whirl[1], mass * whirl[2])
        spin = (_dot(own[0], turn), _dot(own[1], turn), _dot(own[2], turn))
        moment = _add(_cross(turn, spin), _cross(centre, force))
        p = (added[0] * speed[0], added[1] * speed[1], added[2] * speed[2])
        h = (added[3] * turn[0], added[4] * turn[1], added[5] * turn[2])
        carried, twisted = _cross(turn, p), _add(_cross(speed, p), _cross(turn, h))
        if not self._munk:
            carried = (carried[0] + turn[2] * p[1], carried[1] - turn[2] * p[0], carried[2])
            twisted = (twisted[0], twisted[1], twisted[2] - (speed[0] * p[1] - speed[1] * p[0]))
        return _add(force, carried), _add(moment, twisted)

    def _accelerations(self, speed: Vector, turn: Vector, push: Vector) -> tuple[Vector, Vector]:
        """ν̇ of the six axes. `push`: surge_n, sway_n, yaw_nm."""
        against, twist = self._turning(speed, turn)
        d, static = self._d, self._static()
        cross_n, cross_nm = self._cross_flow(speed[1], turn[2])
        x = push[0] + static[0] - against[0] - d[0] * speed[0]
        y = push[1] + static[1] - against[1] - d[1] * speed[1] + cross_n
        z = static[2] - against[2] - d[2] * speed[2]
        k = static[3] - twist[0] - d[3] * turn[0]
        m = static[4] - twist[1] - d[4] * turn[1]
        n = push[2] + static[5] - twist[2] - d[5] * turn[2] * (1.0 + _YAW_QUADRATIC * abs(turn[2])) + cross_nm
        upright, aslant = self._blocks
        u, w, q = (_dot(row, (x, z, m)) for row in upright)
        v, p, r = (_dot(row, (y, k, n)) for row in aslant)
        return (u, v, w), (p, q, r)

    def _cross_flow(self, v: float, r: float) -> tuple[float, float]:
        sway = yaw = 0.0
        for x in self._places:
            one = abs(v + x * r) * (v + x * r)
            sway, yaw = sway - one, yaw - x * one
        return self._cross_n * sway, self._cross_n * yaw

    # --- motion ------------------------------------------------------------------------------------------------------

    def set_current(self, north_mps: float, east_mps: float) -> None:
        """As `Hull.set_current`, for axes that roll and pitch."""
        super().set_current(north_mps, east_mps)
        s_roll, c_roll = math.sin(self.roll_rad), math.cos(self.roll_rad)
        s_pitch, c_pitch = math.sin(self.pitch_rad), math.cos(self.pitch_rad)
        ahead, w = self.water_surge_mps, self.heave_mps
        v = self.water_sway_mps = (self.water_sway_mps + s_roll * w) / c_roll
        self.water_surge_mps = (ahead - s_pitch * (s_roll * v + c_roll * w)) / c_pitch

    def step(self, surge_n: float, sway_n: float, yaw_nm: float, dt_s: float) -> None:
        """As `Hull.step`, semi-implicit: velocities by the forces at the start, the attitude by the velocities at the
        end, which keeps roll, pitch and heave stable."""
        speed = (self.water_surge_mps, self.water_sway_mps, self.heave_mps)
        turn = (self.roll_rate_radps, self.pitch_rate_radps, self.yaw_rate_radps)
        faster, swifter = self._accelerations(speed, turn, (surge_n, sway_n, yaw_nm))
        u, v, w = (old + dt_s * rate for old, rate in zip(speed, faster, strict=True))
        p, q, r = (old + dt_s * rate for old, rate in zip(turn, swifter, strict=True))
        s_roll, c_roll = math.sin(self.roll_rad), math.cos(self.roll_rad)
        s_pitch, c_pitch = math.sin(self.pitch_rad), math.cos(self.pitch_rad)
        self.turn_radps = (q * s_roll + 0.5 * (turn[2] + r) * c_roll) / c_pitch
        self.rolling_radps = p + (q * s_roll + r * c_roll) * s_pitch / c_pitch
        self.pitching_radps = q * c_roll - r * s_roll
        self.heave_m += dt_s * (-s_pitch * u + c_pitch * (s_roll * v + c_roll * w))
        self.roll_rad += dt_s * self.rolling_radps
        self.pitch_rad += dt_s * self.pitching_radps
        self.roll_rate_radps, self.pitch_rate_radps, self.yaw_rate_radps = p, q, r
        self.water_surge_mps, self.water_sway_mps, self.heave_mps = u, v, w
        self._carry(dt_s)

    def _carry(self, dt_s: float) -> None:
        """Move by the velocities at the end of the step in level axes, and note what sensors feel of it."""
        u, v, w = self.water_surge_mps, self.water_sway_mps, self.heave_mps
        s_roll, c_roll = math.sin(self.roll_rad), math.cos(self.roll_rad)
        s_pitch, c_pitch = math.sin(self.pitch_rad), math.cos(self.pitch_rad)
        ahead = c_pitch * u + s_pitch * (s_roll * v + c_roll * w)
        across = c_roll * v - s_roll * w
        middle = self.yaw_rad + 0.5 * dt_s * self.turn_radps
        self.yaw_rad = wrap_pi(self.yaw_rad + dt_s * self.turn_radps)
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        north_mps = c * ahead - s * across + self.current_north_mps
        east_mps = s * ahead + c * across + self.current_east_mps
        self.north_m += 0.5 * dt_s * (self.north_mps + north_mps)
        self.east_m += 0.5 * dt_s * (self.east_mps + east_mps)
        north_mps2, east_mps2 = (north_mps - self.north_mps) / dt_s, (east_mps - self.east_mps) / dt_s
        c, s = math.cos(middle), math.sin(middle)
        self.surge_mps2, self.sway_mps2 = c * north_mps2 + s * east_mps2, c * east_mps2 - s * north_mps2
        self.north_mps, self.east_mps = north_mps, east_mps


def _restoring(water_kgpm3: float, mass: float, draft: float, centre_z_m: float) -> tuple[float, float, float, float]:
    """Stiffness of heave, roll, pitch, and of heave with pitch."""
    volume = mass / water_kgpm3
    area = _WATERPLANE * _LENGTH_M * _PONTOON_BEAM_M
    fine = 6.0 * _WATERPLANE**3 / ((1.0 + _WATERPLANE) * (1.0 + 2.0 * _WATERPLANE))
    across = _LENGTH_M * _PONTOON_BEAM_M**3 * fine / 6.0 + 2.0 * area * _PONTOON_Y_M**2
    along = 0.8 * _PONTOON_BEAM_M * _LENGTH_M**3 / 6.0
    buoyancy = (2.5 * draft - 0.5 * volume / (_LENGTH_M * _PONTOON_BEAM_M)) / 3.0
    gravity = draft - centre_z_m
    weight = water_kgpm3 * _GRAVITY_MPS2 * volume
    heave = water_kgpm3 * _GRAVITY_MPS2 * 2.0 * area
    roll, pitch = weight * (buoyancy + across / volume - gravity), weight * (buoyancy + along / volume - gravity)
    return heave, roll, pitch + heave * _FLOTATION_X_M**2, -heave * _FLOTATION_X_M


def _damping(whole: Matrix, restoring: tuple[float, float, float, float], chosen: Edition) -> tuple[float, ...]:
    """Linear damping of the six axes: by top speed, time constants, and shares of the critical."""
    heave, roll, pitch, _ = restoring
    pitch -= heave * _FLOTATION_X_M**2  # the published frequencies are those about the centre of flotation
    return (
        _FULL_KGF * _GRAVITY_MPS2 / _TOP_MPS,
        0.0 if chosen.sway_time_s is None else float(whole[1, 1]) / chosen.sway_time_s,
        *(
            2.0 * share * math.sqrt(stiffness * float(whole[i, i]))
            for i, (share, stiffness) in enumerate(((0.3, heave), (0.2, roll), (0.4, pitch)), start=2)
        ),
        float(whole[5, 5]),
    )


def _cross_matrix(a: Matrix) -> Matrix:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _add(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]
