"""The course of a boat that pushes astern is no heading."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.core.actuation import Wrench
from companion.core.geodesy import LocalFrame
from companion.core.readings import Heading, Imu, Reading
from companion.nav.estimator import Estimator
from companion.nav.sternway import Sternway
from companion.params.store import Parameters
from tests.unit.nav.boat_truth import Voyage, config_of, readings_of, sail

ASTERN, AHEAD, NEUTRAL = Wrench(-20.0, 0.0, 0.0), Wrench(20.0, 0.0, 0.0), Wrench(0.0, 0.0, 0.0)


def test_a_boat_may_go_astern_until_it_has_pushed_ahead_for_some_seconds() -> None:
    sternway, possible = Sternway(), {}
    for k in range(201):
        now_s = 0.1 * k
        thrust = AHEAD if now_s < 5.0 else ASTERN if now_s < 7.0 else NEUTRAL if now_s < 12.0 else AHEAD
        sternway.update(thrust if k % 7 else None, now_s)
        possible[k] = sternway.possible
    assert [possible[k] for k in (10, 49, 51, 69, 90, 119, 121)] == [False, False, True, True, True, True, True]


def test_thrust_ahead_without_a_break_ends_it() -> None:
    sternway = Sternway()
    sternway.update(ASTERN, 0.0)
    for k in range(1, 40):
        sternway.update(AHEAD, 0.1 * k)
        assert sternway.possible is (k <= 30)


def astern(says: Callable[[Reading], bool], duration_s: float = 30.0, thrust: Wrench = ASTERN) -> tuple[bool, float]:
    """1.5 m/s stern first, straight on: whether there is a heading in the end, and how far it is off in degrees."""
    voyage = Voyage(duration_s=duration_s, speed_mps=-1.5, radius_m=500.0)
    config, truth = config_of(voyage), sail(voyage)
    estimator = Estimator(config, Parameters())
    batch: list[Reading] = []
    frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
    for k, row in enumerate(readings_of(voyage, truth, frame)):
        batch += [reading for reading in row if says(reading)]
        if k % 10 == 0:
            state, batch = estimator.update(batch, float(truth.t_s[k]), thrust), []
    return state.heading_valid, abs(math.degrees(math.remainder(state.yaw_rad - truth.attitude[k, 2], math.tau)))


@pytest.mark.parametrize("inertial", [False, True])
def test_a_boat_that_never_had_a_heading_gets_none_by_its_course_astern(inertial: bool) -> None:
    """It got one, 180° off and valid: Hold would have pushed it away from its place."""
    valid, _ = astern(lambda reading: not isinstance(reading, Heading) and (inertial or not isinstance(reading, Imu)))
    assert not valid


def test_a_heading_that_is_lost_astern_is_kept_by_the_course() -> None:
    """It turned round after some seconds."""
    valid, off_deg = astern(
        lambda reading: not isinstance(reading, Imu) and not (isinstance(reading, Heading) and reading.t_s > 10.0)
    )
    assert valid and off_deg < 10.0


def test_the_course_of_a_boat_that_pushes_ahead_is_its_heading() -> None:
    """Whatever it does."""
    valid, off_deg = astern(lambda reading: not isinstance(reading, Heading | Imu), 5.0, AHEAD)
    assert valid and off_deg > 170.0
