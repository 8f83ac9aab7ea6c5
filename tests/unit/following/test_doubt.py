"""A leader whose positions cannot be true is told from one that turns, stops, stands still or has outliers."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.core.geodesy import LocalFrame
from companion.core.readings import LeaderState
from companion.following.doubt import LeaderDoubt
from sitl.noise import stream

FRAME = LocalFrame(63.0, 10.0)
RATE_HZ = 10.0
Motion = Callable[[float], tuple[float, float, float, float]]
"""t_s → north_m, east_m, north_mps, east_mps, as reported."""


def said(motion: Motion, duration_s: float = 20.0, accuracy_m: float | None = 1.0) -> list[tuple[float, str]]:
    """(t_s, text) of each change of its doubt."""
    doubt, found, before = LeaderDoubt(), [], None
    for n in range(round(duration_s * RATE_HZ)):
        t_s = n / RATE_HZ
        north_m, east_m, north_mps, east_mps = motion(t_s)
        lat_deg, lon_deg = FRAME.to_geodetic(north_m, east_m)
        doubt.see(LeaderState(t_s, t_s, "mavlink:7", 7, lat_deg, lon_deg, north_mps, east_mps, accuracy_m=accuracy_m))
        text = doubt.text(t_s)
        if text != before:
            found.append((t_s, text or ""))
        before = text
    return found


def ahead(t_s: float, speed_mps: float = 2.0) -> tuple[float, float, float, float]:
    return speed_mps * t_s, 0.0, speed_mps, 0.0


def test_a_steady_leader_is_believed() -> None:
    assert said(ahead) == []


@pytest.mark.parametrize("radius_m", [3.0, 10.0])
def test_a_leader_that_turns_is_believed(radius_m: float) -> None:
    def circle(t_s: float) -> tuple[float, float, float, float]:
        angle = 1.5 * t_s / radius_m
        return (
            radius_m * math.cos(angle), radius_m * math.sin(angle), -1.5 * math.sin(angle), 1.5 * math.cos(angle),
        )  # fmt: skip

    assert said(circle) == []


@pytest.mark.parametrize("speed_mps", [0.0, 0.5, 8.0])
def test_noise_is_believed(speed_mps: float) -> None:
    draws = stream(5, "leader")

    def noisy(t_s: float) -> tuple[float, float, float, float]:
        north_m, east_m, north_mps, east_mps = ahead(t_s, speed_mps)
        return (
            north_m + draws.gauss(0.0, 1.0), east_m + draws.gauss(0.0, 1.0),
            north_mps + draws.gauss(0.0, 0.1), east_mps + draws.gauss(0.0, 0.1),
        )  # fmt: skip

    assert said(noisy, 120.0) == []


def test_single_wild_positions_are_outliers() -> None:
    assert said(lambda t_s: (1000.0, 0.0, 2.0, 0.0) if round(t_s * RATE_HZ) % 10 == 9 else ahead(t_s)) == []


def test_a_jump_is_told_at_its_fourth_position_and_lasts_ten_seconds() -> None:
    def jumps(t_s: float) -> tuple[float, float, float, float]:
        north_m, east_m, north_mps, east_mps = ahead(t_s)
        return north_m, east_m + (100.0 if t_s >= 5.0 else 0.0), north_mps, east_mps

    assert said(jumps) == [(5.3, "leader jumped 100 m"), (15.4, "")]
    assert said(jumps, accuracy_m=30.0) == [], "a receiver that is no better"


@pytest.mark.parametrize(("speed_mps", "at_most_s"), [(0.7, 9.0), (2.0, 3.6), (8.0, 3.2)])
def test_a_position_that_repeats_is_told_and_forgiven_when_it_moves_again(speed_mps: float, at_most_s: float) -> None:
    def repeats(t_s: float) -> tuple[float, float, float, float]:
        return ahead(5.0 if 5.0 <= t_s < 20.0 else t_s - (15.0 if t_s >= 20.0 else 0.0), speed_mps)

    changes = said(repeats, 40.0)
    assert [text for _, text in changes] == ["leader repeats its position", ""]
    assert changes[0][0] <= 5.0 + at_most_s and changes[1][0] > 20.0


def test_a_leader_without_a_velocity_is_not_judged() -> None:
    doubt = LeaderDoubt()
    for n in range(100):
        doubt.see(LeaderState(n, n, "phone", 7, 63.0 + 0.01 * (n % 2), 10.0))
    assert doubt.text(100.0) is None


def test_after_an_outage_it_may_be_anywhere() -> None:
    doubt = LeaderDoubt()
    for n, lat_deg in ((0, 63.0), (1, 63.0), (8, 63.1), (9, 63.1), (10, 63.1), (11, 63.1), (12, 63.1)):
        doubt.see(LeaderState(n, n, "module", 7, lat_deg, 10.0, 0.0, 0.0))
    assert doubt.text(12.0) is None and doubt.jump_m is None


def test_a_person_may_follow_it_all_the_same() -> None:
    doubt = LeaderDoubt()
    for n in range(8):
        t_s = 0.1 * n
        doubt.see(LeaderState(t_s, t_s, "module", 7, 63.0 if n < 3 else 63.1, 10.0, 0.0, 0.0))
    assert doubt.text(0.8) is not None
    doubt.forget_jump()
    assert doubt.text(0.8) is None and doubt.jump_m is None


def test_a_leader_that_lies_still_for_long_is_believed() -> None:
    """A receiver that holds its position still while its velocity has noise, as many do."""
    draws = stream(6, "leader at rest")

    def at_rest(_: float) -> tuple[float, float, float, float]:
        return 0.0, 0.0, draws.gauss(0.0, 0.05), draws.gauss(0.0, 0.05)

    assert said(at_rest, 300.0) == []
