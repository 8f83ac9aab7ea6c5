"""The equations of motion of a hull over one recorded manoeuvre, by named quantities: what `hull_fit` fits.

M ν̇ + C(ν) ν + D(ν) ν = Σ scale·wrench(thruster group, lever arm, lag) + weather, with ν through the water of a steady
current.

The weather is the wind on the vessel's windage: the measured wind with a scale on each axis if there is a wind sensor,
else a steady wind. A vessel without windage has a constant force in NED instead. `disturbance` models what varies
beside that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from companion.analysis.log_reader import Log
from companion.analysis.manoeuvre import Array, Group, Manoeuvre, group_wrenches, groups_of
from companion.config.devices import ThrusterConfig
from companion.config.dimensions.completion import figures_of
from companion.config.hull import AIR_KGPM3, DampingConfig, HullConfig

INERTIA = ("m11_kg", "m22_kg", "m33_kgm2")
HEADING = "heading_error_rad"  # by how much the heading reads too much
ANTENNA = ("antenna_ahead_m", "antenna_starboard_m")  # by how much the antenna is further there than in the file
LIFT = "rudder_scale"  # side force of a rudder over what its formula says
CURRENT = ("current_north_mps", "current_east_mps")
_WIND = ("wind_north_m2ps2", "wind_east_m2ps2")  # velocity of the air times its speed
_WIND_SCALES = ("wind_surge_scale", "wind_sway_scale", "wind_yaw_scale")
_FORCE = ("north_n", "east_n")
_CALM_M2PS2 = 0.25  # smooths the root below it, whose slope has no bound at 0
_STANDARD = ("x_u", "x_uu", "y_v", "y_vv", "n_r", "n_rr")  # always fitted
_RESISTING = frozenset({*_STANDARD, "x_uuu"})  # these cannot drive the boat
_LAG_S = 0.3  # start of the fit of the thrusters' lag
_FACTOR_SIGMAS = 0.5  # the factor of a damping that follows from dimensions counts as two sigmas
_ANTENNA_DOUBT = 0.1  # of the boat's length
_LEAST_DOUBT = 0.08  # share of an inertia that follows from dimensions
_MOST = 50.0  # largest value, in scales of a quantity


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
        self.weather = _FORCE if not windy else _WIND if manoeuvre.wind_mps is None else _WIND_SCALES
        terms = [name for name in DampingConfig.__slots__ if name in _STANDARD or getattr(damping, name) != 0.0]
        self.model: dict[str, float] = {
            **{name: getattr(hull, name) for name in INERTIA},
            **{name: getattr(damping, name) for name in terms},
            **{f"scale {group.name}": 1.0 for group in self.groups},
            **{f"x_m {group.name}": group.x_m for group in self.groups},
            **({LIFT: 1.0} if any(group.blade is not None for group in self.groups) else {}),
            "lag_s": _LAG_S,
            **dict.fromkeys(CURRENT, 0.0),
            **dict.fromkeys(self.weather, 1.0 if self.weather is _WIND_SCALES else 0.0),
            **(dict.fromkeys((HEADING, *ANTENNA), 0.0) if mounting else {}),
        }
        self.terms = tuple(terms)
        self._coupling = (hull.m23_kgm, hull.m23_kgm if hull.m32_kgm is None else hull.m32_kgm)
        self._lag_s = math.nan
        self._flow: tuple[float, ...] = ()
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
        if name in self.terms:
            factor = self._factors.get(f"hull.damping.{name}")
            if factor is not None:
                return _FACTOR_SIGMAS * (factor - 1.0) * abs(self.model[name])
            axis = {"x": hull.m11_kg, "y": hull.m22_kg, "n": hull.m33_kgm2}[name[0]]
            return 3.0 * max(abs(self.model[name]), axis * (1.0 if len(name.split("_")[1]) > 1 else 0.1))
        others = {
            "lag_s": 0.3,
            LIFT: 0.3,
            HEADING: 0.1,
            **dict.fromkeys(ANTENNA, _ANTENNA_DOUBT * self.log.config.length_m),
            **dict.fromkeys(CURRENT, 0.2),
            **dict.fromkeys(_WIND, 20.0),
            **dict.fromkeys(_WIND_SCALES, 0.5),
        }
        return others.get(name, 0.1 * self.log.config.limits.surge_n)

    def bounds(self, name: str) -> tuple[float, float]:
        """Smallest and largest value that makes sense, and that keeps the equations stable at the tick's step."""
        model = self.model[name]
        if name in INERTIA:
            return 0.3 * model, 3.0 * model
        if name.startswith("scale") or name == LIFT:
            return 0.2, 5.0
        if name == "lag_s":
            return 0.0, 2.0
        most = _MOST * self.doubt(name) / 3.0
        return (0.0 if name in _RESISTING else -most), most

    def hull(self, values: Mapping[str, float]) -> HullConfig:
        """The hull with these values."""
        return replace(
            self.log.config.hull,
            m11_kg=float(values["m11_kg"]),
            m22_kg=float(values["m22_kg"]),
            m33_kgm2=float(values["m33_kgm2"]),
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
                    rudder = replace(rudder, x_m=arm_m, lift_scale=rudder.lift_scale * float(values[LIFT]))
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
        flow = tuple(values[name] for name in CURRENT) if LIFT in self.model else ()
        if (values["lag_s"], flow) != (self._lag_s, self._flow):
            self._lag_s, self._flow = values["lag_s"], flow
            speed = self._through_water(values)
            self._wrenches = group_wrenches(self.manoeuvre, self.log, self.groups, self._lag_s, speed)
        total = np.zeros_like(self.manoeuvre.velocity)
        for group, (x, y, n) in zip(self.groups, self._wrenches, strict=True):
            k, arm_m = values[f"scale {group.name}"], values[f"x_m {group.name}"]
            y = y if group.blade is None else y * values[LIFT]
            total += k * np.stack([x, y, n + arm_m * y], axis=1)
        return total

    def _through_water(self, values: Mapping[str, float]) -> Array | None:
        """(n,) speed ahead through the water; None where no thrust depends on it."""
        return (self.manoeuvre.velocity - self.stream(values))[:, 0] if LIFT in self.model else None

    def weather_force(self, values: Mapping[str, float]) -> Array:
        """Of the weather at each tick, with the wind as in `companion.config.WindageConfig`, relative to the boat."""
        if self.weather is _FORCE:
            x, y = self._in_body(values["north_n"], values["east_n"], values)
            return np.stack([x, y, np.zeros_like(x)], axis=1)
        if self.manoeuvre.wind_mps is not None:
            air_north, air_east = self.manoeuvre.wind_mps.T
            scales = np.array([values[name] for name in _WIND_SCALES])
        else:
            north, east = (values[name] for name in _WIND)
            root = (north * north + east * east + _CALM_M2PS2**2) ** 0.25
            air_north, air_east, scales = north / root, east / root, np.ones(3)
        x, y = self._in_body(air_north, air_east, values)
        velocity = self.turned(self.manoeuvre.velocity, values)
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
        lateral = values["m22_kg"] * v + 0.5 * sum(self._coupling) * r
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
        return np.array([[m11, 0.0, 0.0], [0.0, m22, self._coupling[0]], [0.0, self._coupling[1], m33]])

    # --- motion ----------------------------------------------------------------------------------------------------

    def imbalance(self, values: Mapping[str, float]) -> Array:
        """(n, 3): estimated velocities less those that the forces give from the start of each stretch.

        The rest is gusts and errors of the estimate. The forces are taken at the estimated velocities: M⁻¹∫ of the
        force balance, so that nothing is differentiated.
        """
        manoeuvre = self.manoeuvre
        relative = self.turned(manoeuvre.velocity, values) - self.stream(values)
        force = self.reaction(values, relative) - self.weather_force(values)
        thrust = self.thrust(values)
        to_velocity = np.linalg.inv(self.inertia(values)).T
        left = np.zeros_like(relative)
        for first, end in manoeuvre.stretches:
            steps = 0.5 * (force[first : end - 1] + force[first + 1 : end]) - thrust[first : end - 1]
            gained = np.cumsum(steps, axis=0) * manoeuvre.period_s @ to_velocity
            left[first:end] = relative[first:end] - relative[first]
            left[first + 1 : end] += gained
        return left

    def simulate(self, values: Mapping[str, float]) -> Array:
        """(n, 3): velocities from the forces alone; each stretch starts at the estimated velocity. Midpoint rule over
        two ticks."""
        force = self.thrust(values) + self.weather_force(values)
        force[:-1] = 0.5 * (force[:-1] + force[1:])
        forces = force.tolist()
        measured, stream = self.turned(self.manoeuvre.velocity, values), self.stream(values)
        result = measured - stream  # outside the stretches nothing is simulated
        half_s = self.manoeuvre.period_s
        step_s = 2.0 * half_s
        derivative = self._derivative(values)
        for first, end in self.manoeuvre.stretches:
            u, v, r = (measured[first : first + 5] - stream[first : first + 5]).mean(axis=0).tolist()
            rows = []
            for x, y, n in forces[first:end:2]:
                rows.append((u, v, r))
                du, dv, dr = derivative(u, v, r, x, y, n)
                half = (u + half_s * du, v + half_s * dv, r + half_s * dr)
                rows.append(half)
                du, dv, dr = derivative(*half, x, y, n)
                u, v, r = _held_in(u + step_s * du), _held_in(v + step_s * dv), _held_in(r + step_s * dr)
            result[first:end] = rows[: end - first]
        return self.turned(np.add(result, stream, dtype=np.float64), values, back=True)

    def turned(self, vectors: Array, values: Mapping[str, float], back: bool = False) -> Array:
        """(n, 3) velocities of the estimate, or their slopes, as those of the middle of the boat in its true axes;
        `back`: the other way. An estimate that believes the antenna elsewhere is of another point of the boat."""
        angle, (ahead_m, starboard_m) = values.get(HEADING, 0.0), (values.get(name, 0.0) for name in ANTENNA)
        x, y, n = vectors.T
        c, s = math.cos(angle), math.sin(angle)
        if back:
            x, y = x - starboard_m * n, y + ahead_m * n
            return np.stack([c * x + s * y, c * y - s * x, n], axis=1)
        return np.stack([c * x - s * y + starboard_m * n, s * x + c * y - ahead_m * n, n], axis=1)

    def _derivative(self, values: Mapping[str, float]) -> Any:
        """`reaction` and `inertia` on plain floats: a hundred times as fast for one velocity."""
        m11, m22, m33 = (values[name] for name in INERTIA)
        m23, m32 = self._coupling
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
        yaw_rad = self.manoeuvre.yaw_rad - values.get(HEADING, 0.0)
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        return north * c + east * s, east * c - north * s


def _held_in(value: float) -> float:
    """Limit a velocity, so that a model that diverges under a trial value stays finite."""
    return min(50.0, max(-50.0, value))


def axis_drag(hull: HullConfig, axis: int, speed: float) -> float:
    """Damping of one axis (0 surge, 1 sway, 2 yaw) at its own speed alone, in N or Nm."""
    d = hull.damping
    linear, quadratic, cubic = ((d.x_u, d.x_uu, d.x_uuu), (d.y_v, d.y_vv, 0.0), (d.n_r, d.n_rr, 0.0))[axis]
    return speed * (linear + abs(speed) * (quadratic + abs(speed) * cubic))
