"""Evidence for the tests of the hypotheses: a boat and its sensors, in a few numbers a tick."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable

from companion.core.readings import FixType, Imu
from companion.nav.integrity.evidence import (
    Evidence,
    HeadingSeen,
    Hypothesis,
    InertialStep,
    InertialWay,
    LaneStep,
    LieFound,
    ModelStep,
    PositionSeen,
    VelocitySeen,
)

TICK_S = 0.1
METRE_DEG = 1.0 / 111_000.0


def position(
    t_s: float,
    north_m: float = 0.0,
    east_m: float = 0.0,
    *,
    source: str = "gnss",
    off: tuple[float, float] = (0.0, 0.0),
    velocity: tuple[float, float] = (0.0, 0.0),
    sigma_m: float = 0.02,
    estimate_sigma_m: float = 0.01,
    fix: FixType = FixType.RTK_FIXED,
    inertial: tuple[float, float] | None = (0.0, 0.0),
    carried: tuple[float, float] = (0.0, 0.0),
) -> PositionSeen:
    """A fix there."""
    lat, lon = 60.0 + north_m * METRE_DEG, 10.0 + east_m * METRE_DEG
    way = None if inertial is None else InertialWay(*inertial, *carried)
    return PositionSeen(
        t_s, source, lat, lon, north_m, east_m, *off, *velocity, estimate_sigma_m, sigma_m, fix, way
    )  # fmt: skip


def velocity(
    t_s: float,
    north_mps: float = 0.0,
    east_mps: float = 0.0,
    *,
    source: str = "gnss",
    off: tuple[float, float] = (0.0, 0.0),
    felt: tuple[float, float] | None = (0.0, 0.0),
    sigma_mps: float = 0.03,
) -> VelocitySeen:
    """A velocity, with what the accelerometers have added up to."""
    sums = (None, None) if felt is None else felt
    return VelocitySeen(t_s, source, (north_mps, east_mps), north_mps, east_mps, *off, *sums, sigma_mps)


def heading(
    t_s: float,
    yaw_rad: float,
    turned_rad: float | None = 0.0,
    *,
    source: str = "gnss",
    off_rad: float = 0.0,
    sigma_rad: float = 0.007,
    wander_rad: float = 0.0017,
) -> HeadingSeen:
    """A heading, with what the gyro has added up to."""
    return HeadingSeen(t_s, source, yaw_rad, yaw_rad, off_rad, sigma_rad, wander_rad, turned_rad)


def imu(t_s: float, values: Iterable[float] = (0.0, 0.0, -9.81, 0.0, 0.0, 0.0), source: str = "imu") -> Imu:
    """A sample: force, then rates."""
    x, y, z, p, q, r = values
    return Imu(t_s, source, x, y, z, p, q, r)


def inertial(
    north_mps: float = 0.0,
    east_mps: float = 0.0,
    turned_rad: float = 0.0,
    lanes: tuple[LaneStep, ...] = (),
    run: int = 1,
) -> InertialStep:
    """What the inertial sensor has added up to."""
    return InertialStep(run, north_mps, east_mps, turned_rad, math.radians(0.01), lanes)


def model(north_mps: float = 0.0, east_mps: float = 0.0, turn_radps: float = 0.0) -> ModelStep:
    """What the model has added up to."""
    return ModelStep(1, north_mps, east_mps, turn_radps)


Making = Callable[[int, float, random.Random], Evidence]


def sail(hypothesis: Hypothesis, make: Making, until_s: float = 30.0, seed: int = 1) -> tuple[float, LieFound] | None:
    """Feed the evidence that `make(tick, now_s, random)` gives; the first finding and its time, or None."""
    rng = random.Random(seed)
    for k in range(1, round(until_s / TICK_S) + 1):
        now_s = k * TICK_S
        evidence = make(k, now_s, rng)
        evidence.driven = True
        for found in hypothesis.update(evidence, now_s):
            return now_s, found
    return None
