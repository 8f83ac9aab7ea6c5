"""How late velocities are, by dead reckoning beside them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
import pytest

from companion.nav.lanes import Lane
from companion.nav.velocity_latency import VelocityLatency


@dataclass
class Reckoned:
    """Dead reckoning as `VelocityLatency` sees it."""

    from_s: float
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)


def velocity(t_s: float, swing_rad: float) -> tuple[float, float]:
    """Of a boat that gathers way and snakes."""
    speed, course = 2.0 * min(t_s / 5.0, 1.0), swing_rad * math.sin(0.4 * t_s)
    return speed * math.cos(course), speed * math.sin(course)


def told(late_s: float, swing_rad: float = 0.6, for_s: float = 40.0, seed: int = 1) -> tuple[float, float] | None:
    """Each stretch of dead reckoning is tilted by 0.3° and turned by 3°."""
    draw, made = np.random.default_rng(seed), VelocityLatency()
    lanes: list[Reckoned] = []
    for k in range(round(for_s * 10)):
        t_s = 0.1 * k
        if k % 60 == 0:
            lanes = [*lanes[-1:], Reckoned(t_s)]
        north, east = velocity(t_s, swing_rad)
        for lane in lanes:
            tilted = 0.05 * (t_s - lane.from_s)
            c, s = math.cos(0.05), math.sin(0.05)
            lane.velocity = c * north - s * east + tilted - 1.0, s * north + c * east - tilted, 0.0
        late = np.array(velocity(max(t_s - late_s, 0.0), swing_rad)) + 0.02 * draw.standard_normal(2)
        made.take(t_s, (float(late[0]), float(late[1])), cast("list[Lane]", lanes), (0.0, 0.0))
    return made.latency_s()


@pytest.mark.parametrize("late_s", [0.0, 0.1, 0.3, -0.2])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_latency_comes_out(late_s: float, seed: int) -> None:
    found = told(late_s, seed=seed)
    assert found is not None
    latency_s, sigma_s = found
    assert latency_s == pytest.approx(late_s, abs=0.015) and 0.01 < sigma_s < 0.03


def test_it_shows_as_soon_as_the_boat_gathers_way() -> None:
    found = told(0.3, swing_rad=0.0, for_s=9.0)
    assert found is not None and found[0] == pytest.approx(0.3, abs=0.05) and found[1] < 0.1


def test_a_boat_that_goes_straight_on_tells_nothing() -> None:
    made = VelocityLatency()
    lane = Reckoned(0.0, (2.0, 0.0, 0.0))
    for k in range(100):
        made.take(0.1 * k, (2.0, 0.0), cast("list[Lane]", [lane]), (0.0, 0.0))
    assert made.latency_s() is None


def test_what_is_too_large_is_no_latency() -> None:
    assert told(0.9) is None


def test_few_velocities_fit_any_latency() -> None:
    """Once a second: three of them left nothing, and a latency was told that was none, sure to the last digit."""
    draw = np.random.default_rng(724050)
    for _ in range(50):
        made, lane = VelocityLatency(), Reckoned(0.0)
        for k in range(12):
            course = 0.6 * math.sin(1.5 * k)
            speed = 2.0 * min(k / 5.0, 1.0)
            north, east = speed * math.cos(course), speed * math.sin(course)
            lane.velocity = north, east, 0.0
            noise = 0.05 * draw.standard_normal(2)
            made.take(float(k), (north + noise[0], east + noise[1]), cast("list[Lane]", [lane]), (0.0, 0.0))
            found = made.latency_s()
            assert found is None or abs(found[0]) < max(0.04, 5.0 * found[1])
