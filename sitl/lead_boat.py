"""A lead boat that follows a script: the Viknes 830 of Loe (2008), an 8 m planing boat, and its own sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from companion.config.devices import SensorConfig
from companion.config.hull import DampingConfig, HullConfig
from companion.config.vessel import HomeConfig
from companion.core.angles import wrap_pi
from sitl.environment import Waves, WindModel
from sitl.hull import Hull, resistance_of
from sitl.leader_script import Order
from sitl.noise import GaussMarkov, Normals, stream
from sitl.sensors import CommonWander, GnssModel
from sitl.wake import Wake

STEP_HZ = 50
LENGTH_M = 8.3

# Mass, inertia and damping as published. The quadratic surge drag would end at 9.7 m/s with the published thrust, so it
# is used up to 8 m/s only. Beyond, the boat planes: resistance equals that thrust at the published top speed of 18 m/s.
_HULL = HullConfig(
    m11_kg=3980.0,
    m22_kg=3980.0,
    m33_kgm2=19703.0,
    damping=DampingConfig(y_v=200.0, y_vv=2000.0, n_r=1281.0),
    resistance=((0.0, 0.0), (2.0, 640.0), (4.0, 2360.0), (6.0, 5160.0), (8.0, 9040.0), (18.0, 13100.0)),
)
_DRAG_N = resistance_of(_HULL.resistance)
_YAW_CUBIC = 3224.0
_SURGE_N = (-6550.0, 13100.0)
_SIDE_N = 645.0
_MOST_RADPS = math.radians(15.0)
_LEVER_M = 4.0

_SPEED_MPS2 = 1.0  # acceleration with which the crew changes speed
_TURN_RADPS2 = 0.1
_SPEED_GAIN_1PS = 1.0
_TURN_GAIN_1PS = 1.5
_COURSE_GAIN_1PS = 0.4

_FIX_HZ = 10
_HEADING_SLOW_RAD, _HEADING_TAU_S, _HEADING_WHITE_RAD = math.radians(2.0), 60.0, math.radians(0.5)
_RATE_WHITE_RADPS, _RATE_BIAS_RADPS = math.radians(0.3), math.radians(0.1)


@dataclass(frozen=True, slots=True)
class LeaderFix:
    """What the module on the lead boat measures at one moment. The position is None without a fix."""

    t_s: float
    lat_deg: float | None
    lon_deg: float | None
    north_mps: float
    east_mps: float
    yaw_rad: float
    yaw_rate_radps: float
    quality: int = 1  # as in GGA
    true_m: tuple[float, float] = (0.0, 0.0)  # north and east of home: what a base's observations stand for


class LeadBoat:
    """Call `depart(t_s)` once, then `step()` at STEP_HZ. `hull`: the truth; `wake`: its wake; `fix`: its sensors, at 10
    Hz.

    Remembers its motion, the speed, turn and course that its crew steers, and the errors of its sensors. It is at rest
    until it departs.
    """

    def __init__(
        self,
        name: str,
        home: HomeConfig,
        script: Sequence[Order],
        *,
        start: tuple[float, float, float] = (0.0, 0.0, 0.0),
        gnss: str = "standalone",
        seed: int = 0,
        common: CommonWander | None = None,
    ) -> None:
        """`start`: north and east of home in m, heading in rad. `common`: the position error that it shares with other
        receivers."""
        self.name = name
        self.script = tuple(script)
        self.hull = Hull(_HULL)
        self.hull.place(*start)
        self.wake = Wake()
        self.faults: set[str] = set()  # as in `sitl.faults`: gnss_lost, gnss_wild, gnss_frozen …
        self.fix: LeaderFix | None = None
        self._fixed_mps = (0.0, 0.0)
        self._departed_s: float | None = None
        self._steps = self._next = 0
        self._wanted_mps = self._speed_mps = 0.0
        self._turn_left_rad = self._rate_radps = self._turn_radps = 0.0
        self._course_rad = start[2]
        self._waves = Waves(WindModel(0.0, 0.0, seed), seed)
        self._gnss = GnssModel(
            SensorConfig(f"{name}_gnss", "nmea0183", "memory:"), home, gnss, 1.0 / _FIX_HZ, seed, common
        )
        rng = self._rng = Normals(stream(seed, f"{name} attitude"))
        self._heading_error = GaussMarkov(rng, _HEADING_SLOW_RAD, _HEADING_TAU_S)
        self._rate_bias = rng.gauss(0.0, _RATE_BIAS_RADPS)

    @property
    def t_s(self) -> float:
        """Time of the last step."""
        return self._steps / STEP_HZ

    @property
    def departed_s(self) -> float | None:
        """When the script began; None before."""
        return self._departed_s

    def depart(self, t_s: float) -> None:
        """Begin the script at `t_s`."""
        self._departed_s, self._next = t_s, 0

    def step(self) -> None:
        """Advance by 1/STEP_HZ s."""
        dt_s = 1.0 / STEP_HZ
        self._steps += 1
        self._take_orders()
        hull = self.hull
        surge_n, turn_nm = self._steer(dt_s)
        hull.step(surge_n, -turn_nm / _LEVER_M, turn_nm - _YAW_CUBIC * hull.yaw_rate_radps**3, dt_s)
        self.wake.leave(hull.north_m, hull.east_m, hull.north_mps, hull.east_mps, dt_s)
        if self._steps % (STEP_HZ // _FIX_HZ) == 0:
            fix = self._measure()
            self._fixed_mps = self.hull.north_mps, self.hull.east_mps
            frozen = self.fix if "gnss_frozen" in self.faults else None
            self.fix = fix if frozen is None else replace(frozen, t_s=fix.t_s)

    @property
    def velocity_gained_mps(self) -> tuple[float, float]:
        """North and east by which its velocity has changed since the last fix: an inertial sensor feels that."""
        north_mps, east_mps = self._fixed_mps
        return self.hull.north_mps - north_mps, self.hull.east_mps - east_mps

    def _take_orders(self) -> None:
        while (
            self._departed_s is not None
            and self._next < len(self.script)
            and self.t_s - self._departed_s >= self.script[self._next].at_s - 1e-9
        ):
            order = self.script[self._next]
            self._next += 1
            self._wanted_mps = order.speed_mps
            self._turn_left_rad, self._rate_radps = order.turn_rad, abs(order.rate_radps)

    def _steer(self, dt_s: float) -> tuple[float, float]:
        """(surge_n, yaw_nm) with which the crew follows its orders."""
        hull = self.hull
        step = _SPEED_MPS2 * dt_s
        self._speed_mps += min(step, max(-step, self._wanted_mps - self._speed_mps))
        ease = (
            self._turn_radps * self._turn_radps / (2.0 * _TURN_RADPS2)
        )  # angle that the boat still turns while its rate falls to 0
        wanted = math.copysign(self._rate_radps, self._turn_left_rad) if abs(self._turn_left_rad) > ease + 1e-3 else 0.0
        step = _TURN_RADPS2 * dt_s
        self._turn_radps += min(step, max(-step, wanted - self._turn_radps))
        turned = self._turn_radps * dt_s
        self._turn_left_rad -= turned
        self._course_rad = wrap_pi(self._course_rad + turned)
        rate = self._turn_radps + _COURSE_GAIN_1PS * wrap_pi(self._course_rad - hull.yaw_rad)
        rate = min(_MOST_RADPS, max(-_MOST_RADPS, rate))
        turn_nm = 1281.0 * rate + _YAW_CUBIC * rate**3 + _HULL.m33_kgm2 * _TURN_GAIN_1PS * (rate - hull.yaw_rate_radps)
        most_nm = _SIDE_N * _LEVER_M
        drag_n = math.copysign(_DRAG_N(abs(self._speed_mps)), self._speed_mps)
        surge_n = drag_n + _HULL.m11_kg * _SPEED_GAIN_1PS * (self._speed_mps - hull.water_surge_mps)
        surge_n -= _HULL.m22_kg * hull.water_sway_mps * hull.yaw_rate_radps
        return min(_SURGE_N[1], max(_SURGE_N[0], surge_n)), min(most_nm, max(-most_nm, turn_nm))

    def _measure(self) -> LeaderFix:
        hull = self.hull
        sample = self._gnss.sample(hull, self._waves, self.faults)
        yaw = hull.yaw_rad + self._heading_error.update(1.0 / _FIX_HZ) + self._rng.gauss(0.0, _HEADING_WHITE_RAD)
        rate = hull.yaw_rate_radps + self._rate_bias + self._rng.gauss(0.0, _RATE_WHITE_RADPS)
        lat_deg, lon_deg = (None, None) if sample.position is None else sample.position[:2]
        return LeaderFix(
            self.t_s,
            lat_deg,
            lon_deg,
            sample.north_mps,
            sample.east_mps,
            wrap_pi(yaw),
            rate,
            sample.grade.quality,
            (hull.north_m, hull.east_m),
        )
