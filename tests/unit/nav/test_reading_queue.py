"""Readings in order of time, taken when the slowest of them has come."""

from __future__ import annotations

from companion.core.readings import FixType, GnssFix, Heading, HeadingBy, Imu, Reading, Wind
from companion.nav.reading_queue import ReadingQueue

LATENCIES_S = {"imu": 0.0, "gnss": 0.1, "spare": 0.3, "wind": 2.0, "slow": 5.0}
LATE_S: dict[str, float] = {}


def queue() -> ReadingQueue:
    LATE_S.clear()
    return ReadingQueue(LATENCIES_S, lambda source: LATE_S.get(source, 0.0))


def imu(t_s: float) -> Imu:
    return Imu(t_s, "imu", 0.0, 0.0, -9.8, 0.0, 0.0, 0.0)


def fix(t_s: float, source: str = "gnss") -> GnssFix:
    return GnssFix(t_s, source, 60.0, 10.0, None, FixType.RTK_FIXED, 12, 0.8, 0.02)


def times(readings: list[Reading]) -> list[float]:
    return [round(reading.t_s, 6) for reading in readings]


def test_nothing_waits_where_nothing_is_late() -> None:
    made = queue()
    made.add([imu(1.0), imu(0.9)])
    assert times(made.due(1.0)) == [0.9, 1.0] and made.lag_s == 0.0


def test_all_wait_for_the_slowest_that_comes() -> None:
    made = queue()
    made.add([imu(1.0), fix(0.9)])
    assert made.lag_s == 0.1
    assert times(made.due(1.0)) == [0.9]
    made.add([imu(1.1)])
    assert times(made.due(1.1)) == [1.0]
    made.add([fix(0.75, "spare")])
    assert made.lag_s == 0.3
    assert times(made.due(1.2)) == [0.75] and times(made.pending) == [1.1]


def test_a_sensor_that_gives_no_motion_holds_up_nothing() -> None:
    made = queue()
    made.add([imu(1.0), Wind(1.0, "wind", 3.0, 0.0)])
    assert made.lag_s == 0.0 and times(made.due(1.0)) == [1.0]


def test_no_sensor_holds_up_the_others_for_longer_than_half_a_second() -> None:
    made = queue()
    made.add([imu(1.0), fix(-4.0, "slow")])
    assert made.lag_s == 0.5


def test_a_receiver_that_is_later_than_its_row_says_is_dated_back() -> None:
    made = queue()
    LATE_S["gnss"] = 0.25
    made.add([imu(1.0), fix(1.0), Heading(1.0, "gnss", 0.5), Heading(1.0, "gnss", 0.5, None, HeadingBy.COMPASS)])
    assert times(made.pending) == [0.75, 0.75, 1.0, 1.0]  # a compass has a latency of its own
    assert made.lag_s == 0.35
    LATE_S["gnss"] = -0.25
    made.add([fix(2.0)])
    assert made.pending[-1].t_s == 2.25 and made.lag_s == 0.1  # that of the compass


def test_a_reading_meets_the_inertial_sample_nearest_to_it() -> None:
    """A velocity that met the sample before it, 10 ms older: in waves the antenna swings otherwise by then."""
    made = ReadingQueue(LATENCIES_S, lambda _: 0.0, {"imu": 0.01})
    made.add([imu(1.0), fix(1.0099, "near"), imu(1.01), fix(1.013, "near"), imu(1.02)])
    assert times(made.due(1.02)) == [1.0, 1.01, 1.0099, 1.013, 1.02]


def test_a_reading_between_two_samples_of_a_slow_sensor_meets_its_part_of_the_step() -> None:
    """It counted as of the sample before it, up to 0.1 s too early."""
    made = ReadingQueue(LATENCIES_S, lambda _: 0.0, {"imu": 0.1})
    for k in range(4):
        made.add([imu(0.1 * k)])
        made.due(0.1 * k)
    made.add([fix(0.35, "near")])
    assert made.lag_s == 0.1 and times(made.due(0.39)) == [0.22, 0.24, 0.26, 0.28]
    made.add([imu(0.4)])
    made.add([imu(0.5), fix(0.45, "near")])
    assert times(made.due(0.5)) == [0.3, 0.32, 0.34, 0.35, 0.36, 0.38, 0.4]
