"""The equations of motion of a hull over one recorded manoeuvre, by named quantities: what `hull_fit` fits.

M ν̇ + C(ν) ν + D(ν) ν = Σ scale·wrench(thruster group, lever arm, lag) + weather, with ν through the water of a steady
current.

Terms that the vessel's file lacks are candidates, in groups: the coupling of sway and yaw by inertia and by drag, what
cross-flow drag by strips has beside them, and lift.

The weather is the wind on the vessel's windage: the measured wind with a scale on each axis if there is a wind sensor,
else a steady wind. Beside it, or alone for a vessel without windage, a constant force in NED, such as the drift by
waves. `disturbance` models what varies beside that.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from companion.analysis.band import band_of
from companion.analysis.blade import Blade, BladeForce
from companion.analysis.log_reader import Log
from companion.analysis.manoeuvre import Array, Group, Manoeuvre, group_wrenches, groups_of
from companion.config.devices import ThrusterConfig
from companion.config.dimensions.completion import figures_of
from companion.config.hull import AIR_KGPM3, DampingConfig, HullConfig

INERTIA = ("m11_kg", "m22_kg", "m33_kgm2")
COUPLING = "m23_kgm"
CANDIDATES = ((COUPLING,), ("n_v", "n_vv"), ("y_r", "y_rr"), ("y_rv", "n_vr"), ("y_uv", "n_uv", "n_ur"))
"""Groups of terms that a hull may have beside those of its file."""
HEADING = "heading_error_rad"  # by how much the heading reads too much
ANTENNA = ("antenna_ahead_m", "antenna_starboard_m")  # by how much the antenna is further there than in the file
FOLLOWED = "antenna_s"  # time in which the estimate follows the antenna's turning, where the inertial sensor has none
LAG = "lag_s"  # of the thrusters, which no vessel's file has
LIFT = "rudder_scale"  # side force of a rudder over what its formula says
RACE = "rudder_race_gain"  # share of the race's extra speed that the blade feels
CURRENT = ("current_north_mps", "current_east_mps")
_WIND = ("wind_north_m2ps2", "wind_east_m2ps2")  # velocity of the air times its speed
_WIND_SCALES = ("wind_surge_scale", "wind_sway_scale", "wind_yaw_scale")
_FORCE = ("north_n", "east_n")
_ASIDE = ("aside_north_n", "aside_east_n")  # what drift by waves adds to the force on the beam
_TWIST = ("twist_sine_nm", "twist_cosine_nm")  # its moment, of twice the heading
_WEATHER_SHARE = 0.1  # of a limit: doubt of a steady force
_CALM_M2PS2 = 0.25  # smooths the root below it, whose slope has no bound at 0
_STANDARD = ("x_u", "x_uu", "y_v", "y_vv", "n_r", "n_rr")  # always fitted
_RESISTING = frozenset({*_STANDARD, "x_uuu"})  # these cannot drive the boat
_LAG_S = 0.3  # start of the fit of the thrusters' lag
_FACTOR_SIGMAS = 0.5  # the factor of a damping that follows from dimensions counts as two sigmas
_FOLLOWED_S = 0.5  # start of the fit
_ANTENNA_DOUBT = 0.1  # of the boat's length
_LEAST_DOUBT = 0.08  # share of an inertia that follows from dimensions
_MOST = 50.0  # largest value, in scales of a quantity
_DRAG_AHEAD, _GRAVITY_AHEAD = 0.1, 0.05  # of the length: doubt of where drag and mass have their centre
_MOST_AHEAD = 0.1  # of the length: farthest centre of mass and added mass


class HullModel:
    """The equations over one manoeuvre, by named quantities. Remembers the manoeuvre and the wrenches of one lag."""

    def __init__(self, log: Log, manoeuvre: Manoeuvre, mounting: bool = False) -> None:
        """`mounting`: the heading may read too much or too little (`HEADING`), which only runs at speed both ways tell
        from a current, and the antenna may be elsewhere (`ANTENNA`), which only spins tell from a current."""
        self.log, self.manoeuvre = log, manoeuvre
        self._factors = {figure.key: figure.factor for figure in figures_of(log.config.hull, log.config.thrusters)}
        self.groups: tuple[Group, ...] = groups_of(log.config.thrusters, apart=not self.scale_known)
        hull, damping, windage = log.config.hull, log.config.hull.damping, log.config.windage
        windy = windage.lateral_m2 > 0.0 and windage.frontal_m2 > 0.0
        self._air: tuple[str, ...] = () if not windy else _WIND if manoeuvre.wind_mps is None else _WIND_SCALES
        self.band = band_of(manoeuvre.wave_s, manoeuvre.stretches, manoeuvre.period_s)
        self.weather = (*self._air, *_FORCE, *((*_ASIDE, *_TWIST) if self.band.waves else ()))
        offered = {name for group in CANDIDATES for name in group}
        own = [name for name in DampingConfig.__slots__ if name in _STANDARD or getattr(damping, name) != 0.0]
        terms = [name for name in DampingConfig.__slots__ if name in own or name in offered]
        self.model: dict[str, float] = {
            **{name: getattr(hull, name) for name in (*INERTIA, COUPLING)},
            **{name: getattr(damping, name) for name in terms},
            **{f"scale {group.name}": 1.0 for group in self.groups},
            **{f"x_m {group.name}": group.x_m for group in self.groups},
            **{name: value for group in self.groups if group.blade for name, value in _rudder(group.blade)},
            LAG: _LAG_S,
            **dict.fromkeys(CURRENT, 0.0),
            **dict.fromkeys(self.weather, 0.0),
            **(dict.fromkeys(_WIND_SCALES, 1.0) if self._air is _WIND_SCALES else {}),
            **({**dict.fromkeys((HEADING, *ANTENNA), 0.0), FOLLOWED: _FOLLOWED_S} if mounting else {}),
        }
        self.terms = tuple(terms)
        fixed = {*own, *((COUPLING,) if hull.m23_kgm != 0.0 else ())}
        groups = (tuple(name for name in group if name not in fixed) for group in CANDIDATES)
        self.candidates = tuple(group for group in groups if group)
        self._skew = hull.yaw_coupling_kgm - hull.m23_kgm
        # Waves carry the hull to and fro, but do not flow past it: forces are those of the calm velocities.
        self.calm = self.band.calm(manoeuvre.velocity)
        self._lag_s = self._axes_at = math.nan
        self._axes: tuple[Array, Array] = manoeuvre.yaw_rad, manoeuvre.yaw_rad
        self._wrenches: list[tuple[Array, Array, Array]] = []

    # --- the quantities --------------------------------------------------------------------------------------------

    @property
    def scale_known(self) -> bool:
        """Whether the thrust is better known than the mass. A boat from dimensions was weighed, and its motors are as
        good as their label."""
        return not self._factors

    def doubt(self, name: str) -> float:
        """One sigma of what is known of a quantity before the fit. Wide for damping without dimensions: a model can
        have it ten times too high."""
        hull = self.log.config.hull
        if name in INERTIA:
            factor = self._factors.get(f"hull.{name}")
            share = 0.15 if factor is None else max(_LEAST_DOUBT, 0.5 * math.log(factor))
            return share * self.model[name]
        if name.startswith("scale"):
            return 0.2 if self.scale_known else 0.35
        if name.startswith("x_m"):
            return 0.15 * self.log.config.length_m
        if any(name in group for group in self.candidates):
            return self._candidate_doubt(name)
        if name in self.terms:
            factor = self._factors.get(f"hull.damping.{name}")
            if factor is not None:
                return _FACTOR_SIGMAS * (factor - 1.0) * abs(self.model[name])
            axis = {"x": hull.m11_kg, "y": hull.m22_kg, "n": hull.m33_kgm2}[name[0]]
            return 3.0 * max(abs(self.model[name]), axis * (1.0 if len(name.split("_")[1]) > 1 else 0.1))
        others = {
            LAG: 0.3,
            FOLLOWED: 0.3,
            LIFT: 0.3,
            RACE: 0.1,
            HEADING: 0.1,
            **dict.fromkeys(ANTENNA, _ANTENNA_DOUBT * self.log.config.length_m),
            **dict.fromkeys(CURRENT, 0.2),
            **dict.fromkeys(_WIND, 20.0),
            **dict.fromkeys(_WIND_SCALES, 0.5),
        }
        limits = self.log.config.limits
        return others.get(name, _WEATHER_SHARE * (limits.yaw_nm if name in _TWIST else limits.surge_n))

    def _candidate_doubt(self, name: str) -> float:
        """One sigma of a term that the file lacks: centres of mass and drag may lie ahead of the middle by some of the
        length, and lift is as that of a slender hull with its added mass (Clarke)."""
        hull, length_m = self.log.config.hull, self.log.config.length_m
        linear = self.model["y_v"] + self.doubt("y_v")
        quadratic = self.model["y_vv"] + self.doubt("y_vv")
        return {
            COUPLING: _GRAVITY_AHEAD * length_m * hull.m22_kg,
            "n_v": _DRAG_AHEAD * length_m * linear,
            "n_vv": _DRAG_AHEAD * length_m * quadratic,
            "y_r": _DRAG_AHEAD * length_m * linear,
            "y_rr": 0.5 * _DRAG_AHEAD * length_m**2 * quadratic,
            "y_rv": 0.5 * length_m * quadratic,  # cross-flow drag by strips
            "n_vr": length_m**2 / 6.0 * quadratic,
            "y_uv": hull.m22_kg / length_m,
            "n_uv": 0.5 * hull.m22_kg,
            "n_ur": 0.25 * hull.m22_kg * length_m,
        }[name]

    def bounds(self, name: str) -> tuple[float, float]:
        """Smallest and largest value that makes sense, and that keeps the equations stable at the tick's step."""
        model = self.model[name]
        if name in INERTIA:
            return min(max(0.3 * model, self._least(name)), model), 3.0 * model
        if name == COUPLING:
            most = _MOST_AHEAD * self.log.config.length_m * self.model["m22_kg"]
            return model - most, model + most
        if name.startswith("scale") or name == LIFT:
            return 0.2, 5.0
        if name in (LAG, FOLLOWED):
            return 0.0, 2.0
        if name == RACE:
            return 0.1, 1.0
        most = _MOST * self.doubt(name) / 3.0
        return (0.0 if name in _RESISTING else -most), most

    def _least(self, name: str) -> float:
        """Inertia without any water: of a boat from dimensions, the mass that was weighed."""
        weighed = self.log.config.hull.mass_kg
        return 0.0 if self.scale_known or weighed is None or name == "m33_kgm2" else weighed

    def hull(self, values: Mapping[str, float]) -> HullConfig:
        """The hull with these values."""
        return replace(
            self.log.config.hull,
            m11_kg=float(values["m11_kg"]),
            m22_kg=float(values["m22_kg"]),
            m33_kgm2=float(values["m33_kgm2"]),
            m23_kgm=float(values[COUPLING]),
            m32_kgm=float(values[COUPLING]) + self._skew if self._skew else None,
            damping=DampingConfig(**{name: float(values[name]) for name in self.terms}),
        )

    def thrusters(self, values: Mapping[str, float]) -> tuple[ThrusterConfig, ...]:
        """The thrusters with these scales in their curves, at these lever arms."""
        thrusters = list(self.log.config.thrusters)
        for group in self.groups:
            k, arm_m = float(values[f"scale {group.name}"]), float(values[f"x_m {group.name}"])
            for i in group.members:
                t = thrusters[i]
                rudder, place_m = t.rudder, arm_m
                if rudder is not None:  # the arm is the blade's; the propeller stands as far ahead of it as before
                    place_m = t.x_m + arm_m - rudder.x_m
                    scale = rudder.lift_scale * float(values[LIFT])
                    rudder = replace(rudder, x_m=arm_m, lift_scale=scale, race_gain=float(values[RACE]))
                thrusters[i] = replace(
                    t,
                    rudder=rudder,
                    x_m=place_m,
                    ahead_n=k * t.ahead_n,
                    astern_n=k * t.astern_n,
                    max_n=k * t.max_n,
                    min_n=k * t.min_n,
                )
        return tuple(thrusters)

    # --- forces: (n, 3) of surge_n, sway_n, yaw_nm -----------------------------------------------------------------

    def thrust(self, values: Mapping[str, float]) -> Array:
        """Of all thrusters: mean between each tick and the next."""
        if values[LAG] != self._lag_s:
            self._lag_s = values[LAG]
            self._wrenches = group_wrenches(self.manoeuvre, self.log, self.groups, self._lag_s)
        total = np.zeros_like(self.manoeuvre.velocity)
        for group, (x, y, n) in zip(self.groups, self._wrenches, strict=True):
            k, arm_m = values[f"scale {group.name}"], values[f"x_m {group.name}"]
            total += k * np.stack([x, y, n + arm_m * y], axis=1)
        for _, arm_m, blade in self._blades(values):
            total += np.stack([blade.surge_n, blade.sway_n, arm_m * blade.sway_n], axis=1)
        return total

    def _blades(self, values: Mapping[str, float]) -> Iterator[tuple[Array, float, BladeForce]]:
        """(relative velocity, lever arm, force) of the rudders of each group."""
        for group, (x, _, _) in zip(self.groups, self._wrenches, strict=True):
            if group.blade is None:
                continue
            moved, arm_m = self._through_water(values), values[f"x_m {group.name}"]
            blades = len(group.members)  # which share thrust and angle
            thrust_n = values[f"scale {group.name}"] * x / blades
            angle_rad = self.manoeuvre.azimuth_rad[:, group.members[0]]
            across = moved[:, 1] + arm_m * moved[:, 2]
            force = group.blade.force(thrust_n, angle_rad, moved[:, 0], across, values[RACE])
            scale = blades * values[LIFT]
            yield moved, arm_m, BladeForce(scale * force.surge_n, scale * force.sway_n, scale * force.fin)

    def _through_water(self, values: Mapping[str, float]) -> Array:
        """(n, 3) calm velocities through the water."""
        return self.turned(self.calm, values) - self.stream(values)

    def weather_force(self, values: Mapping[str, float]) -> Array:
        """Of the weather at each tick, with the wind as in `companion.config.WindageConfig`, relative to the boat."""
        x, y = self._in_body(values["north_n"], values["east_n"], values)
        force = np.stack([x, y, np.zeros_like(x)], axis=1)
        if self.band.waves:
            aside_north_n, aside_east_n = (values[name] for name in _ASIDE)
            force[:, 1] += self._in_body(aside_north_n, aside_east_n, values)[1]
            twice = 2.0 * (self.manoeuvre.yaw_rad - values.get(HEADING, 0.0))
            sine, cosine = (values[name] for name in _TWIST)
            force[:, 2] += sine * np.sin(twice) + cosine * np.cos(twice)
        return force if not self._air else force + self._wind_force(values)

    def _wind_force(self, values: Mapping[str, float]) -> Array:
        if self.manoeuvre.wind_mps is not None:
            air_north, air_east = self.manoeuvre.wind_mps.T
            scales = np.array([values[name] for name in _WIND_SCALES])
        else:
            north, east = (values[name] for name in _WIND)
            root = (north * north + east * east + _CALM_M2PS2**2) ** 0.25
            air_north, air_east, scales = north / root, east / root, np.ones(3)
        x, y = self._in_body(air_north, air_east, values)
        velocity = self.turned(self.calm, values)
        x, y = x - velocity[:, 0], y - velocity[:, 1]
        w, pressure = self.log.config.windage, 0.5 * AIR_KGPM3 * np.hypot(x, y)
        twist = -AIR_KGPM3 * w.cn * w.lateral_m2 * self.log.config.length_m * x * y
        return np.asarray(
            np.stack([pressure * w.cx * w.frontal_m2 * x, pressure * w.cy * w.lateral_m2 * y, twist], axis=1) * scales
        )

    def stream(self, values: Mapping[str, float]) -> Array:
        """(n, 3): the current's velocity in body axes."""
        north, east = (values[name] for name in CURRENT)
        x, y = self._in_body(north, east, values)
        return np.stack([x, y, np.zeros_like(x)], axis=1)

    def reaction(self, values: Mapping[str, float], relative: Array) -> Array:
        """C(ν) ν + D(ν) ν for velocities (n, 3) through the water."""
        u, v, r = relative.T
        lateral = values["m22_kg"] * v + (values[COUPLING] + 0.5 * self._skew) * r
        d = {name: values.get(name, 0.0) for name in DampingConfig.__slots__}
        au, av, ar = np.abs(u), np.abs(v), np.abs(r)
        x = -lateral * r + u * (d["x_u"] + d["x_uu"] * au + d["x_uuu"] * au * au)
        y = values["m11_kg"] * u * r + v * (d["y_v"] + d["y_vv"] * av + d["y_rv"] * ar + d["y_uv"] * au)
        y = y + r * (d["y_r"] + d["y_vr"] * av + d["y_rr"] * ar)
        n = (lateral - values["m11_kg"] * v) * u + v * (d["n_v"] + d["n_vv"] * av + d["n_rv"] * ar + d["n_uv"] * au)
        n = n + r * (d["n_r"] + d["n_vr"] * av + d["n_rr"] * ar + d["n_ur"] * au)
        return np.stack([x, y, n], axis=1)

    def inertia(self, values: Mapping[str, float]) -> Array:
        """M, 3×3."""
        m11, m22, m33 = (values[name] for name in INERTIA)
        m23 = values[COUPLING]
        return np.array([[m11, 0.0, 0.0], [0.0, m22, m23], [0.0, m23 + self._skew, m33]])

    # --- motion ----------------------------------------------------------------------------------------------------

    def imbalance(self, values: Mapping[str, float]) -> Array:
        """(n, 3): estimated velocities less those that the forces give from the start of each stretch.

        The rest is gusts, waves and errors of the estimate. The forces are taken at the calm velocities: M⁻¹∫ of the
        force balance, so that nothing is differentiated.
        """
        manoeuvre = self.manoeuvre
        stream = self.stream(values)
        relative = self.turned(manoeuvre.velocity, values) - stream
        calm = self._through_water(values)
        force = self.reaction(values, calm) - self.weather_force(values)
        rocked = self._rocked(calm)
        thrust = self.thrust(values)
        to_velocity = np.linalg.inv(self.inertia(values)).T
        left = np.zeros_like(relative)
        for first, end in manoeuvre.stretches:
            steps = 0.5 * (force[first : end - 1] + force[first + 1 : end]) - thrust[first : end - 1]
            steps = steps @ to_velocity + 0.5 * (rocked[first : end - 1] + rocked[first + 1 : end])
            gained = np.cumsum(steps, axis=0) * manoeuvre.period_s
            left[first:end] = relative[first:end] - relative[first]
            left[first + 1 : end] += gained
        return left

    def _rocked(self, calm: Array) -> Array:
        """(n, 3): change of velocity, negated, since waves turn the boat's axes and not its way through the water."""
        by_waves = self.manoeuvre.velocity[:, 2] - self.calm[:, 2]
        return np.stack([-by_waves * calm[:, 1], by_waves * calm[:, 0], np.zeros(len(calm))], axis=1)

    def simulate(self, values: Mapping[str, float]) -> Array:
        """(n, 3): velocities from the forces alone; each stretch starts at the estimated velocity. Midpoint rule over
        two ticks."""
        force = self.thrust(values) + self.weather_force(values)
        force[:-1] = 0.5 * (force[:-1] + force[1:])
        fins = self._fins(values)
        forces = np.concatenate([force, fins], axis=1).tolist()
        measured, stream = self.turned(self.manoeuvre.velocity, values), self.stream(values)
        result = measured - stream  # outside the stretches nothing is simulated
        half_s = self.manoeuvre.period_s
        step_s = 2.0 * half_s
        derivative = self._derivative(values)
        for first, end in self.manoeuvre.stretches:
            u, v, r = (measured[first : first + 5] - stream[first : first + 5]).mean(axis=0).tolist()
            rows = []
            for x, y, n, fin, arm_m, across in forces[first:end:2]:
                rows.append((u, v, r))
                aside = fin * (across - v - arm_m * r)
                du, dv, dr = derivative(u, v, r, x, y + aside, n + arm_m * aside)
                half = (u + half_s * du, v + half_s * dv, r + half_s * dr)
                rows.append(half)
                aside = fin * (across - half[1] - arm_m * half[2])
                du, dv, dr = derivative(*half, x, y + aside, n + arm_m * aside)
                u, v, r = _held_in(u + step_s * du), _held_in(v + step_s * dv), _held_in(r + step_s * dr)
            result[first:end] = rows[: end - first]
        return self.turned(np.add(result, stream, dtype=np.float64), values, back=True)

    def _fins(self, values: Mapping[str, float]) -> Array:
        """(n, 3): by how much a rudder's side force falls with its speed to starboard, its arm, and the speed for which
        `thrust` has it; zero without one."""
        result = np.zeros_like(self.calm)
        for moved, arm_m, blade in self._blades(values):
            fin = result[:, 0] + blade.fin
            result = np.stack([fin, np.full_like(fin, arm_m), moved[:, 1] + arm_m * moved[:, 2]], axis=1)
        return result

    def turned(self, vectors: Array, values: Mapping[str, float], back: bool = False) -> Array:
        """(n, 3) velocities of the estimate, or their slopes, as those of the middle of the boat in its true axes;
        `back`: the other way. An estimate that believes the antenna elsewhere is of another point of the boat."""
        angle, (ahead_m, starboard_m) = values.get(HEADING, 0.0), (values.get(name, 0.0) for name in ANTENNA)
        x, y, n = vectors.T
        c, s = math.cos(angle), math.sin(angle)
        late = self._followed(n, values) if ahead_m or starboard_m else n
        if back:
            x, y = x - starboard_m * late, y + ahead_m * late
            return np.stack([c * x + s * y, c * y - s * x, n], axis=1)
        return np.stack([c * x - s * y + starboard_m * late, s * x + c * y - ahead_m * late, n], axis=1)

    def _followed(self, rate: Array, values: Mapping[str, float]) -> Array:
        """The rate of turn behind a first-order lag of `FOLLOWED`."""
        from scipy.signal import lfilter

        keep = math.exp(-self.manoeuvre.period_s / max(values[FOLLOWED], 1e-3))
        late, _ = lfilter([1.0 - keep], [1.0, -keep], rate, zi=[keep * rate[0]])
        return np.asarray(late, dtype=np.float64)

    def _derivative(self, values: Mapping[str, float]) -> Any:
        """`reaction` and `inertia` on plain floats: a hundred times as fast for one velocity."""
        m11, m22, m33 = (values[name] for name in INERTIA)
        m23, m32 = values[COUPLING], values[COUPLING] + self._skew
        coupling = 0.5 * (m23 + m32)
        determinant = m22 * m33 - m23 * m32
        i22, i23, i32, i33 = m33 / determinant, -m23 / determinant, -m32 / determinant, m22 / determinant
        d = [values.get(name, 0.0) for name in DampingConfig.__slots__]
        xu, xuu, xuuu, yv, yvv, yrv, yr, yvr, yrr, nv, nvv, nrv, nr, nvr, nrr, yuv, nuv, nur = d

        def derivative(u: float, v: float, r: float, x: float, y: float, n: float) -> tuple[float, float, float]:
            au, av, ar = abs(u), abs(v), abs(r)
            lateral = m22 * v + coupling * r
            x += lateral * r - u * (xu + au * (xuu + au * xuuu))
            y -= m11 * u * r + v * (yv + yvv * av + yrv * ar + yuv * au) + r * (yr + yvr * av + yrr * ar)
            n -= (
                lateral * u
                - m11 * u * v
                + v * (nv + nvv * av + nrv * ar + nuv * au)
                + r * (nr + nvr * av + nrr * ar + nur * au)
            )
            return x / m11, i22 * y + i23 * n, i32 * y + i33 * n

        return derivative

    def _in_body(self, north: Any, east: Any, values: Mapping[str, float]) -> tuple[Array, Array]:
        error = values.get(HEADING, 0.0)
        if error != self._axes_at:
            yaw_rad = self.manoeuvre.yaw_rad - error
            self._axes_at, self._axes = error, (np.cos(yaw_rad), np.sin(yaw_rad))
        c, s = self._axes
        return north * c + east * s, east * c - north * s


def _rudder(blade: Blade) -> tuple[tuple[str, float], ...]:
    return (LIFT, 1.0), (RACE, blade.rudder.race_gain)


def _held_in(value: float) -> float:
    """Limit a velocity, so that a model that diverges under a trial value stays finite."""
    return min(50.0, max(-50.0, value))


def axis_drag(hull: HullConfig, axis: int, speed: float) -> float:
    """Damping of one axis (0 surge, 1 sway, 2 yaw) at its own speed alone, in N or Nm."""
    d = hull.damping
    linear, quadratic, cubic = ((d.x_u, d.x_uu, d.x_uuu), (d.y_v, d.y_vv, 0.0), (d.n_r, d.n_rr, 0.0))[axis]
    return speed * (linear + abs(speed) * (quadratic + abs(speed) * cubic))
