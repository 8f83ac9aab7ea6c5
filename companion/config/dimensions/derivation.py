"""Everything that follows from the dimensions of a vessel, figure by figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from companion.config.devices import SensorConfig, ThrusterConfig
from companion.config.dimensions import added_mass, bandwidths, cross_damping, limits, surge_damping, windage
from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import Dimensions
from companion.config.dimensions.steady_course import steady_mps
from companion.config.hull import DampingConfig, HullConfig

LAG_S = 0.3  # time constant of thrust of a small electric drive
_SEARCH_STEPS = 50
# Forms that end in a transom where a jet drives them. With the damping of their whole draft they turned in circles of
# 10 to 40 lengths with the nozzle at its stop.
_TRANSOMS = ("catamaran", "inflatable")


def hull_figures(
    boat: Dimensions, thrusters: Sequence[ThrusterConfig], given: Mapping[str, Any] | None = None
) -> tuple[Figure, ...]:
    """Inertia, damping and windage. `given`: the raw `[hull]` table, of whose inertia in yaw the damping follows."""
    inertias = added_mass.figures(boat)
    m33 = next(figure.value for figure in inertias if figure.key == "hull.m33_kgm2")
    by_hand = (given or {}).get("m33_kgm2")
    if isinstance(by_hand, (int, float)):
        m33 = float(by_hand)
    jet = any(thruster.kind == "jet" for thruster in thrusters)
    by_transom = surge_damping.planes(boat, thrusters) or (jet and boat.form in _TRANSOMS)
    return (
        *inertias,
        *surge_damping.figures(boat, thrusters),
        *cross_damping.figures(boat, m33, by_transom),
        *windage.figures(boat),
    )


def hull_of(figures: Sequence[Figure], resistance: Sequence[tuple[float, float]] = ()) -> HullConfig:
    """The hull of these figures."""
    values = {figure.key: figure.value for figure in figures}
    damping = {
        key.removeprefix("hull.damping."): value for key, value in values.items() if key.startswith("hull.damping.")
    }
    return HullConfig(
        m11_kg=values["hull.m11_kg"],
        m22_kg=values["hull.m22_kg"],
        m33_kgm2=values["hull.m33_kgm2"],
        damping=DampingConfig(**damping),
        resistance=tuple(resistance),
    )


def parameter_figures(
    hull: HullConfig,
    limit: tuple[float, float, float],
    length_m: float,
    sensors: Sequence[SensorConfig],
    thrusters: Sequence[ThrusterConfig],
    lag_s: float = LAG_S,
    needs_flow: bool = False,
    drifts: bool = False,
) -> tuple[Figure, ...]:
    """Defaults of parameters for a hull. `limit`: surge N, sway N, yaw Nm; `needs_flow`: it steers by a
    rudder or a nozzle; `drifts`: it has no way astern."""
    top_mps = top_speed_mps(hull, limit[0])
    speeds = bandwidths.Speeds(top_mps, steady_mps(hull, thrusters, limit[2], top_mps))
    return bandwidths.figures(hull, limit, length_m, sensors, lag_s, speeds, needs_flow, drifts)


def top_speed_mps(hull: HullConfig, thrust_n: float) -> float:
    """Speed at which the hull's drag takes all of `thrust_n`; infinite without damping."""
    low, high = 0.0, 1.0
    while hull.drag_n(high) < thrust_n:
        low, high = high, 2.0 * high
        if high > 128.0:
            return math.inf
    for _ in range(_SEARCH_STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if hull.drag_n(middle) < thrust_n else (low, middle)
    return low


def limit_figures(thrusters: Sequence[ThrusterConfig]) -> tuple[Figure, ...]:
    """The limits of the wrench."""
    return limits.figures(tuple(thrusters))
