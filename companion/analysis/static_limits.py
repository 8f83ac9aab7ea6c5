"""What a boat holds in Hold by its file, in the mean: wind, current and waves, from ahead and from any side.

A static balance, as that of the polar: the forces of wind and current by the hull and its windage, the mean drift of
waves, against what the thrusters give together within the limits of the wrench. Gusts, groups of waves and losses of
thrust come on top: `docs/reference/results.md` has how Hold does near the balance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from companion.analysis.polar import can_hold, strongest, wrench_against
from companion.analysis.rudder_turn import room_m
from companion.config.dimensions.form import GRAVITY_MPS2, TRAITS, WATER_KGPM3
from companion.config.vessel import VesselConfig
from companion.control.heading import held_nm_per_rad
from companion.core.actuation import Wrench
from companion.params.store import Parameters
from companion.params.table import table_of

MOST_MPS, MOST_CURRENT_MPS, MOST_HEIGHT_M = 40.0, 5.0, 2.0
_STEPS = 9  # of halving
_DIRECTIONS = 12
_REFLECTED = 0.6  # R² of the waves that a hull does not follow (Faltinsen 1990, 5.4)
_POINTED = 0.3  # of the beam: what of a pointed bow meets waves from ahead as a wall does
_SPREAD = tuple(
    (math.radians(aside), share) for aside, share in ((-50, 0.12), (-25, 0.24), (0, 0.28), (25, 0.24), (50, 0.12))
)
_SHORTER = 1.2  # the mean frequency over that of the peak
# Of a fetch of 1 km: H = 0.0162 U, T = 0.624 U^⅓ (Shore Protection Manual 1984, as the simulator's rough water).
_HEIGHT_S, _PERIOD_SHARE, _PERIOD_POWER = 0.0162, 0.624, 1.0 / 3.0
_AT_TEN_M = 1.5  # wind at 10 m over that at a small boat
_PERIOD_S = 4.2  # of a sea of 1 m; it grows with the root of the height
_WEAK_MPS = 5.5  # a moderate breeze
_OFF_BOW_RAD = math.radians(20.0)
_RUDDER_ROOM = 0.25  # of the watch circle, for a turn by the rudder; gusts and the way back take the rest


Demand = Callable[[float, float], Wrench]
"""The wrench that balances a strength (m/s, or m of height) from a direction clockwise from the bow."""


@dataclass(frozen=True, slots=True)
class Limit:
    """What is held from ahead and from any side. Of a boat that cannot push itself sideways `side` is the most in which
    its bow comes round and stays, by a rudder within a quarter of its watch circle; None where that is not known, or
    nothing turns it away. `most` bounds the search."""

    ahead: float
    side: float | None
    most: float

    @property
    def held(self) -> float:
        """The strength that is held from ahead and from any side; infinite where the search for it ended."""
        least = self.ahead if self.side is None else min(self.ahead, self.side)
        return math.inf if least >= self.most else least


@dataclass(frozen=True, slots=True)
class StaticLimits:
    """`wind` alone in m/s; `with_waves`: with the waves that it raises over 1 km; `current` in m/s; `waves` alone,
    significant height in m."""

    wind: Limit
    with_waves: Limit
    current: Limit
    waves: Limit
    held_sideways: bool
    by_rudder: bool = False


def static_limits(config: VesselConfig) -> StaticLimits | None:
    """The limits of a vessel; None where its file has no windage, and for a sail, which the wind drives."""
    if config.has_sail or config.windage.lateral_m2 <= 0.0 or config.windage.frontal_m2 <= 0.0:
        return None

    def windy(wind_mps: float, from_rad: float) -> Wrench:
        height_m, period_s = wind_sea(wind_mps)
        return _sum(wrench_against(config, wind_mps, from_rad), drift(config, height_m, period_s, from_rad))

    def sea(height_m: float, from_rad: float) -> Wrench:
        return drift(config, height_m, _PERIOD_S * math.sqrt(height_m), from_rad)

    def stream(speed_mps: float, from_rad: float) -> Wrench:
        set_mps = -speed_mps * math.cos(from_rad), -speed_mps * math.sin(from_rad)
        return wrench_against(config, 0.0, from_rad, set_mps)

    return StaticLimits(
        _limit(config, lambda wind_mps, from_rad: wrench_against(config, wind_mps, from_rad), MOST_MPS),
        _limit(config, windy, MOST_MPS),
        _limit(config, stream, MOST_CURRENT_MPS, turns=False),
        _limit(config, sea, MOST_HEIGHT_M, turns=False),
        config.limits.sway_n > 0.0,
        config.has_rudder,
    )


def wind_sea(wind_mps: float) -> tuple[float, float]:
    """(significant height m, period s) of the waves that a wind at the boat raises over 1 km of water."""
    at_ten_m = _AT_TEN_M * wind_mps
    return _HEIGHT_S * at_ten_m, _PERIOD_SHARE * at_ten_m**_PERIOD_POWER


def drift(config: VesselConfig, height_m: float, period_s: float, from_rad: float) -> Wrench:
    """The wrench against the mean drift force of a sea: ½ρg R² (1 − F²) HS²/8 times the width that meets the waves,
    where F is the share of the water's motion that the hull follows (Faltinsen et al. 1980)."""
    if height_m <= 0.0 or period_s <= 0.0:
        return Wrench(0.0, 0.0, 0.0)
    number = (_SHORTER * math.tau / period_s) ** 2 / GRAVITY_MPS2
    length_m, beam_m, draft_m = _box(config)
    bow_m = beam_m * (1.0 if config.hull.form == "barge" else _POINTED)
    deep = -math.expm1(-number * draft_m) / (number * draft_m)
    surge_n = sway_n = 0.0
    for aside_rad, share in _SPREAD:
        ahead, across = math.cos(from_rad + aside_rad), math.sin(from_rad + aside_rad)
        follows = deep * _sinc(0.5 * number * length_m * ahead) * _sinc(0.5 * number * beam_m * across)
        pressure = share * 0.5 * WATER_KGPM3 * GRAVITY_MPS2 * _REFLECTED * height_m**2 / 8.0 * (1.0 - follows**2)
        surge_n += pressure * bow_m * ahead * abs(ahead)
        sway_n += pressure * length_m * across * abs(across)
    return Wrench(surge_n, sway_n, 0.0)


def lines(found: StaticLimits) -> list[str]:
    """Lines for people."""
    side = "from any side" if found.held_sideways else "the bow comes round in up to"
    if found.by_rudder:
        side = "the rudder brings the bow round within the watch circle in up to"
    rows = (
        ("wind", found.wind, "m/s", 1),
        ("wind with the waves that it raises over 1 km", found.with_waves, "m/s", 1),
        ("current", found.current, "m/s", 2),
        ("waves alone, significant height", found.waves, "m", 2),
    )
    return [
        f"holds: {name}: from ahead {_shown(limit.ahead, limit.most, unit, digits)}"
        + (f", {side} {_shown(limit.side, limit.most, unit, digits)}" if limit.side is not None else "")
        for name, limit, unit, digits in rows
    ]


def weakness(config: VesselConfig, found: StaticLimits) -> Iterator[str]:
    """What moves the boat off in weather that people sail in, and what helps."""
    side, ahead = found.with_waves.side, found.with_waves.ahead
    if ahead < _WEAK_MPS:
        yield (
            f"limits.surge_n: wind above {ahead:.1f} m/s with its waves carries it off even bow on. Hold, Missions and "
            "RTL: stay ashore in more. More thrust ahead, or less area above the water"
        )
    if side is not None and side < _WEAK_MPS <= ahead:
        if found.held_sideways:
            yield (
                f"limits.sway_n: wind above {side:.1f} m/s from the side, with its waves, moves it off or turns it. "
                "Hold and Dock: give no heading, DP_WEATHERVANE 1 lets the bow turn to the weather. Missions: legs "
                "across the wind are sailed off the path. More thrust sideways, or less area above the water"
            )
        elif found.by_rudder:
            yield (
                f"limits.yaw_nm: wind above {side:.1f} m/s with its waves carries the boat out of its watch circle "
                "while the rudder brings the bow round. Hold: give it room, DP_WATCH_R. A larger rudder, more thrust "
                "ahead (RUD_STEER for steering), or less area above the water"
            )
        else:
            yield (
                f"limits.yaw_nm: in wind above {side:.1f} m/s with its waves the bow does not come round to it. Hold, "
                "Missions and RTL: it lies beam on and drifts. Thrusters further apart, or less area above the water"
            )


def _limit(config: VesselConfig, demand: Demand, most: float, turns: bool = True) -> Limit:
    """`turns`: whether it turns the bow of a boat that drifts across it. A current carries such a boat along. What a
    jet turns depends on the way through the water."""
    ahead = strongest(lambda value: can_hold(config, demand(value, 0.0)), most, _STEPS)
    if config.has_rudder:
        return Limit(ahead, _rudder_limit(config, demand, ahead) if turns else None, most)
    sideways, yaw_nm = config.limits.sway_n > 0.0, config.limits.yaw_nm
    turns = turns and not any(thruster.kind == "jet" for thruster in config.thrusters)
    loop_nm = held_nm_per_rad(config) * _OFF_BOW_RAD

    def kept() -> float:
        """The most in which the heading loop holds the bow to it: wind turns a bow that is a little off further off."""
        return strongest(lambda value: abs(demand(value, _OFF_BOW_RAD).yaw_nm) <= loop_nm, most, _STEPS)

    def from_side(from_rad: float) -> float:
        if sideways:
            return strongest(lambda value: can_hold(config, demand(value, from_rad)), most, _STEPS)
        return strongest(lambda value: abs(demand(value, from_rad).yaw_nm) <= yaw_nm, most, _STEPS)

    angles = [math.tau * n / _DIRECTIONS for n in range(_DIRECTIONS)]
    sides = [*map(from_side, angles), *(() if sideways else (kept(),))]
    return Limit(ahead, min(sides) if sideways or turns else None, most)


def _rudder_limit(config: VesselConfig, demand: Demand, most: float) -> float:
    """The most in which the rudder brings the bow round with room to spare in the watch circle."""
    within_m = _RUDDER_ROOM * Parameters(config.parameters, table_of(config))["DP_WATCH_R"]
    return strongest(lambda value: room_m(config, lambda from_rad: demand(value, from_rad)) <= within_m, most, _STEPS)


def _box(config: VesselConfig) -> tuple[float, float, float]:
    """Length, beam at the waterline and draft. What the file does not give follows from form and mass."""
    hull = config.hull
    traits = TRAITS[hull.form or "monohull"]
    length_m, over_all_m = hull.length_m or config.length_m, hull.beam_m or config.beam_m
    hulls = 2 if hull.form == "catamaran" else 1
    single_m = hull.hull_beam_m or (0.3 if hulls == 2 else traits.waterline) * over_all_m
    volume_m3 = (hull.mass_kg or hull.m11_kg) / WATER_KGPM3
    beam_m = over_all_m if hulls == 2 else single_m
    return length_m, beam_m, hull.draft_m or volume_m3 / (hulls * length_m * single_m * traits.block)


def _sinc(x: float) -> float:
    return math.sin(x) / x if abs(x) > 1e-9 else 1.0


def _sum(one: Wrench, other: Wrench) -> Wrench:
    return Wrench(one.surge_n + other.surge_n, one.sway_n + other.sway_n, one.yaw_nm + other.yaw_nm)


def _shown(value: float, most: float, unit: str, digits: int) -> str:
    return f"{value:.{digits}f} {unit}{' or more' if value >= most else ''}"
