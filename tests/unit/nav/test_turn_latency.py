"""How late headings are, by the gyro."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.nav.turn_latency import TurnLatency


def told(late_s: float, amplitude_rad: float = 0.5, seed: int = 1, bias_radps: float = 2e-4) -> tuple[float, float]:
    """A boat that snakes for a minute, its gyro with a bias, its headings with noise and a slow error."""
    draw, made = np.random.default_rng(seed), TurnLatency()
    slow_rad = 0.0

    def yaw_rad(t_s: float) -> float:
        return 3.0 + amplitude_rad * math.sin(0.3 * t_s)

    for k in range(1200):
        t_s = 0.05 * k
        slow_rad += 1e-4 * draw.standard_normal()
        heading = yaw_rad(t_s - late_s) + slow_rad + math.radians(0.2) * draw.standard_normal()
        turned, rate = yaw_rad(t_s) + bias_radps * t_s, 0.3 * amplitude_rad * math.cos(0.3 * t_s)
        made.take(t_s, math.remainder(heading, 2.0 * math.pi) - turned, rate)
    found = made.latency_s()
    assert found is not None
    return found


@pytest.mark.parametrize("late_s", [0.0, 0.3, -0.1])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_latency_comes_out_within_its_sigma(late_s: float, seed: int) -> None:
    latency_s, sigma_s = told(late_s, seed=seed)
    assert latency_s == pytest.approx(late_s, abs=3.0 * sigma_s + 0.005) and sigma_s < 0.015


def test_small_turns_tell_less() -> None:
    assert told(0.3, 0.1)[1] > 3.0 * told(0.3, 0.5)[1]


def test_without_turns_nothing_is_told() -> None:
    made = TurnLatency()
    for k in range(1000):
        made.take(0.05 * k, 0.001 * (k % 2), 0.0)
    assert made.latency_s() is None


def test_a_gap_or_a_jump_begins_the_slow_parts_anew() -> None:
    made = TurnLatency()
    for k in range(1200):
        t_s = 0.05 * k
        jump = 2.0 if k > 700 else 0.0
        made.take(t_s, jump - 0.3 * 0.15 * math.cos(0.3 * t_s), 0.15 * math.cos(0.3 * t_s))
    found = made.latency_s()
    assert found is not None and found[0] == pytest.approx(0.3, abs=0.01)
    made.begin()
    assert made.latency_s() is None


def test_a_heading_or_two_in_a_turn_tell_nothing() -> None:
    """Once a second: the first fits a latency without anything left, sure to the last digit."""
    made = TurnLatency()
    for k in range(5):
        made.take(float(k), 0.01 * (k % 2), 0.2 * k)
        assert made.latency_s() is None
