"""Wind, current and waves, all from the seed. Wind is named by where it comes FROM, current by where it flows TO."""

from __future__ import annotations

import math
from typing import Protocol

from companion.config.hull import WindageConfig
from companion.config.vessel import ConfigError
from companion.core.angles import TWO_PI, wrap_two_pi
from sitl.noise import GaussMarkov, Normals, stream

AIR_DENSITY_KGPM3 = 1.225
UPDATE_S = 0.1  # wind and current are constant in between

_GUST_SHARE = 0.15  # standard deviation of the speed over its mean, as measured over water
_GUST_TAU_S = 10.0
_WANDER_RAD = math.radians(8.0)
_WANDER_TAU_S = 60.0
_CURRENT_TAU_S = 120.0
_PERIOD_S = 1.8  # of roll and pitch without a sea state


def parse_directed(text: str, what: str = "value") -> tuple[float, float | None]:
    """`2@45` → (2 m/s, 45° in radians); `2` → (2, None). Raises ConfigError that names `what`."""
    speed_text, at, direction_text = text.partition("@")
    try:
        speed_mps = float(speed_text)
        direction_deg = float(direction_text) if at else None
    except ValueError as error:
        raise ConfigError([f"{what} '{text}': write MPS@DEG, as 2@45, or MPS alone"]) from error
    if not 0.0 <= speed_mps <= 60.0 or (direction_deg is not None and not abs(direction_deg) <= 720.0):
        raise ConfigError([f"{what} '{text}': the speed must be 0 to 60 m/s, the direction in degrees"])
    return speed_mps, None if direction_deg is None else wrap_two_pi(math.radians(direction_deg))


class GustModel(Protocol):
    """Speed of the wind beside its mean."""

    value: float

    def update(self, dt_s: float) -> float:
        """Advance by `dt_s`; returns the new value."""
        ...


class WindModel:
    """True wind: a mean, gusts (an Ornstein–Uhlenbeck process of the speed, or `gusts`) and a slow change of direction.

    Remembers the present values. `north_mps` and `east_mps` are the velocity of the air over ground.
    """

    __slots__ = ("_gust", "_mean_from_rad", "_mean_mps", "_wander", "east_mps", "from_rad", "north_mps", "speed_mps")

    def __init__(self, mean_mps: float, from_rad: float | None, seed: int, gusts: GustModel | None = None) -> None:
        """`from_rad` None: a direction from the seed."""
        self._mean_mps = mean_mps
        self._mean_from_rad = stream(seed, "wind direction").uniform(0.0, TWO_PI) if from_rad is None else from_rad
        usual = GaussMarkov(Normals(stream(seed, "wind gusts")), _GUST_SHARE * mean_mps, _GUST_TAU_S)
        self._gust: GustModel = usual if gusts is None else gusts
        wander_rad = _WANDER_RAD if mean_mps > 0.0 else 0.0
        self._wander = GaussMarkov(Normals(stream(seed, "wind wander")), wander_rad, _WANDER_TAU_S)
        self.update(0.0)

    @property
    def mean_mps(self) -> float:
        """Mean speed."""
        return self._mean_mps

    @property
    def mean_from_rad(self) -> float:
        """Mean direction."""
        return self._mean_from_rad

    def update(self, dt_s: float) -> None:
        """Advance by `dt_s`."""
        if dt_s > 0.0:
            self._gust.update(dt_s)
            self._wander.update(dt_s)
        self.speed_mps = max(0.0, self._mean_mps + self._gust.value)
        self.from_rad = wrap_two_pi(self._mean_from_rad + self._wander.value)
        self.north_mps, self.east_mps = (
            -self.speed_mps * math.cos(self.from_rad),
            -self.speed_mps * math.sin(self.from_rad),
        )


class CurrentModel:
    """The water's velocity over ground: constant, or with a slow variation of `variation_mps` on each axis."""

    __slots__ = ("_mean_east_mps", "_mean_north_mps", "_vary_east", "_vary_north", "east_mps", "north_mps", "varies")

    def __init__(self, mean_mps: float, towards_rad: float | None, seed: int, variation_mps: float = 0.0) -> None:
        """`towards_rad` None: a direction from the seed."""
        towards = stream(seed, "current direction").uniform(0.0, TWO_PI) if towards_rad is None else towards_rad
        self._mean_north_mps, self._mean_east_mps = mean_mps * math.cos(towards), mean_mps * math.sin(towards)
        self._vary_north = GaussMarkov(Normals(stream(seed, "current north")), variation_mps, _CURRENT_TAU_S)
        self._vary_east = GaussMarkov(Normals(stream(seed, "current east")), variation_mps, _CURRENT_TAU_S)
        self.varies = variation_mps > 0.0
        self.update(0.0)

    def update(self, dt_s: float) -> None:
        """Advance by `dt_s`."""
        if self.varies and dt_s > 0.0:
            self._vary_north.update(dt_s)
            self._vary_east.update(dt_s)
        self.north_mps = self._mean_north_mps + self._vary_north.value
        self.east_mps = self._mean_east_mps + self._vary_east.value


def wind_force(
    windage: WindageConfig, length_m: float, air_surge_mps: float, air_sway_mps: float
) -> tuple[float, float, float]:
    """(surge_n, sway_n, yaw_nm) of air that moves over the boat at this velocity, in body axes.

    Fossen 2011, section 8.1.3, for symmetric ships. The force has the direction of the air. The moment, ½ρ cn A_L L V²
    sin 2γ with γ the angle of attack counter-clockwise from the bow, turns the boat beam to the wind.
    """
    pressure = 0.5 * AIR_DENSITY_KGPM3 * math.hypot(air_surge_mps, air_sway_mps)
    surge_n = pressure * windage.cx * windage.frontal_m2 * air_surge_mps
    sway_n = pressure * windage.cy * windage.lateral_m2 * air_sway_mps
    yaw_nm = -AIR_DENSITY_KGPM3 * windage.cn * windage.lateral_m2 * length_m * air_surge_mps * air_sway_mps
    return surge_n, sway_n, yaw_nm


class Waves:
    """Motion of a boat on water without a sea state: roll and pitch as sums of sinusoids.

    They are kinematic: 0.2° and 0.12° for each m/s of mean wind. `heave_m`, the hull's way down, and its derivatives
    are those of a sea with height, here 0.
    """

    __slots__ = (
        "_pitch",
        "_roll",
        "half_step_s",
        "heave_m",
        "heave_mps",
        "heave_mps2",
        "pitch_rad",
        "pitch_rate_radps",
        "roll_rad",
        "roll_rate_radps",
    )

    def __init__(self, wind: WindModel, seed: int) -> None:
        rng = stream(seed, "waves")
        roll_rad = math.radians(min(0.2 * wind.mean_mps, 15.0))
        pitch_rad = math.radians(min(0.12 * wind.mean_mps, 10.0))
        omegas = [TWO_PI / _PERIOD_S * factor for factor in (0.87, 1.17)]
        self._roll = [
            (roll_rad * share, omega, rng.uniform(0.0, TWO_PI)) for share, omega in zip((0.6, 0.4), omegas, strict=True)
        ]
        self._pitch = [
            (pitch_rad * share, omega, rng.uniform(0.0, TWO_PI))
            for share, omega in zip((0.6, 0.4), omegas, strict=True)
        ]
        self.heave_m = self.heave_mps = self.heave_mps2 = 0.0
        self.half_step_s = 0.0  # by which the rates are older than the attitude
        self.update(0.0)

    def update(self, t_s: float) -> None:
        """Compute attitude and rates at `t_s`."""
        self.roll_rad, self.roll_rate_radps = _sum(self._roll, t_s)
        self.pitch_rad, self.pitch_rate_radps = _sum(self._pitch, t_s)


def _sum(components: list[tuple[float, float, float]], t_s: float) -> tuple[float, float]:
    """(value, rate) of a sum of sinusoids."""
    value = rate = 0.0
    for amplitude, omega, phase in components:
        angle = omega * t_s + phase
        value += amplitude * math.sin(angle)
        rate += amplitude * omega * math.cos(angle)
    return value, rate
