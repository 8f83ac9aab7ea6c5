"""When control may use position and heading."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.nav.solution import Motion
from companion.nav.validity import Validity
from companion.params.store import Parameters

ZERO = (0.0, 0.0, 0.0)
MOTION = Motion(100.0, ZERO, ZERO, ZERO, ZERO, 0.3, 0.05, math.radians(3.0))
CARRY_S, TOLERATED_S = 20.0, 3.0


@pytest.fixture
def validity() -> Validity:
    made = Validity(Parameters({"NAV_CARRY_T": CARRY_S, "FS_POS_T": TOLERATED_S, "COM_POS_FS_EPH": 5.0}))
    made.position(100.0, 0.4)
    made.velocity(100.0)
    made.heading(100.0, math.radians(4.0))
    return made


def test_slow_errors_are_added(validity: Validity) -> None:
    assert validity.position_sigma_m(MOTION) == pytest.approx(0.5)
    assert validity.yaw_sigma_rad(MOTION) == pytest.approx(math.radians(5.0))
    assert validity.covariance_m2(MOTION) == pytest.approx((0.25, 0.0, 0.25))
    known = replace(MOTION, position_covariance_m2=(0.01, 0.02, 0.09))
    assert validity.covariance_m2(known) == pytest.approx((0.17, 0.02, 0.25))


def test_two_receivers_that_are_apart_leave_the_boat_at_either(validity: Validity) -> None:
    validity.apart_m = 1.2
    assert validity.position_sigma_m(MOTION) == pytest.approx(1.3)
    assert validity.covariance_m2(MOTION) == pytest.approx((1.69, 0.0, 1.69))


def test_a_position_holds_as_long_as_is_tolerated_and_while_it_is_accurate(validity: Validity) -> None:
    assert validity.position_valid(0.5, 100.0 + TOLERATED_S)
    assert not validity.position_valid(0.5, 100.1 + TOLERATED_S)
    assert not validity.position_valid(5.1, 100.0)


def test_velocities_carry_a_position_that_a_lie_left_alone_and_not_for_ever(validity: Validity) -> None:
    now_s = 110.0
    validity.velocity(now_s)
    assert not validity.carried(now_s)
    validity.lied_s = now_s
    assert validity.carried(now_s) and validity.position_valid(0.5, now_s)
    validity.velocity(100.1 + CARRY_S)
    validity.lied_s = 100.1 + CARRY_S
    assert not validity.carried(100.1 + CARRY_S)


def test_an_older_measurement_does_not_turn_time_back(validity: Validity) -> None:
    validity.position(99.0, 0.4)
    validity.velocity(98.0)
    assert validity.unmeasured_s(101.0) == 1.0


@pytest.mark.parametrize(
    ("age_s", "sigma_deg", "by_gyro", "placed", "valid"),
    [
        (3.0, 19.0, False, True, True),
        (3.0, 21.0, True, True, False),
        (3.1, 4.0, True, True, True),
        (3.1, 4.0, False, True, False),
        (3.1, 6.0, True, True, False),
        (3.1, 4.0, True, False, False),
    ],
)
def test_the_gyro_carries_a_heading_that_was_good(
    validity: Validity, age_s: float, sigma_deg: float, by_gyro: bool, placed: bool, valid: bool
) -> None:
    now_s = 100.0 + age_s
    if placed:
        validity.position(now_s, 0.4)
    assert validity.heading_valid(math.radians(sigma_deg), now_s, by_gyro) is valid
