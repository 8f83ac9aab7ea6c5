"""Samples of a slow inertial sensor, in parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple

import pytest

from companion.core.readings import Imu
from companion.nav.slow_samples import SlowSamples


def imu(t_s: float, value: float = 0.0, source: str = "imu") -> Imu:
    return Imu(t_s, source, value, 2.0 * value, 3.0 * value, 4.0 * value, 5.0 * value, 6.0 * value, 0.1, 0.2, 0.3)


def newest(t_s: float) -> float:
    """Of a sensor that sends what it feels at `t_s`."""
    return 1.0 + 3.0 * t_s


def mean(t_s: float) -> float:
    """Of one that sends the mean of the last 0.1 s."""
    return newest(t_s - 0.05)


@pytest.mark.parametrize(("sends", "averaging"), [(newest, []), (mean, ["imu"])])
def test_parts_have_the_values_of_their_time(sends: Callable[[float], float], averaging: list[str]) -> None:
    """Values that rise along a straight line: no part lags."""
    made = SlowSamples(averaging)
    for k in range(4):
        made.parts(imu(0.1 * k, sends(0.1 * k)))
    parts = made.parts(imu(0.4, sends(0.4)))
    assert [part.t_s for part in parts] == pytest.approx([0.32, 0.34, 0.36, 0.38, 0.4])
    for part in parts:
        assert astuple(part)[2:8] == pytest.approx([n * newest(part.t_s - 0.01) for n in range(1, 7)])


def test_the_parts_of_a_mean_add_up_to_it() -> None:
    made = SlowSamples(["imu"])
    values = [0.0, 0.3, -0.2, 0.5, 0.1, 0.7]
    for k, value in enumerate(values):
        parts = made.parts(imu(0.1 * k, value))
        if k > 3:
            assert sum(part.x_mps2 for part in parts) / len(parts) == pytest.approx(value)


def test_only_the_last_part_has_the_attitude_of_the_device() -> None:
    made = SlowSamples()
    for k in range(4):
        made.parts(imu(0.1 * k))
    *before, last = made.parts(imu(0.4))
    assert all(part.roll_rad is part.pitch_rad is part.yaw_rad is None for part in before)
    assert (last.roll_rad, last.pitch_rad, last.yaw_rad) == (0.1, 0.2, 0.3)


def test_fast_samples_stay_whole_also_around_one_that_was_lost() -> None:
    made = SlowSamples()
    for t_s in (0.0, 0.01, 0.02, 0.03, 0.08, 0.09):
        assert made.parts(imu(t_s)) == [imu(t_s)]
    assert made.period_s("imu") == 0.0


def test_nobody_knows_what_was_in_a_gap() -> None:
    made = SlowSamples()
    for t_s in (0.0, 0.1, 0.2, 0.3):
        made.parts(imu(t_s))
    assert made.parts(imu(1.0)) == [imu(1.0)]
    assert len(made.parts(imu(1.1))) == 5


def test_one_that_comes_twice_or_too_late_stays_as_it_is() -> None:
    made = SlowSamples()
    for t_s in (0.0, 0.1, 0.2, 0.3, 0.4):
        made.parts(imu(t_s))
    assert made.parts(imu(0.4)) == [imu(0.4)]
    assert made.parts(imu(0.2)) == [imu(0.2)]
    assert len(made.parts(imu(0.5))) == 5


def test_the_period_is_the_longest_of_the_last_ones() -> None:
    made = SlowSamples()
    assert made.period_s("imu") == 0.0
    for t_s in (0.0, 0.1, 0.21, 0.3):
        made.parts(imu(t_s))
    assert made.period_s("imu") == pytest.approx(0.11)
    assert made.period_s("other") == 0.0
