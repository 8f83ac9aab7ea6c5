"""What the inertial sensor says alone: sums, dead reckoning beside the filter, and the way back."""

from __future__ import annotations

import math

import pytest

from companion.nav.error_state import ErrorStateFilter
from companion.nav.lanes import InertialMemory, InertialSums

G = 9.81
AT_REST = (0.0, 0.0, -G)
NO_TURN = (0.0, 0.0, 0.0)
DT_S = 0.01


def level_filter() -> ErrorStateFilter:
    filter_ = ErrorStateFilter(G)
    sigmas = [0.02] * 3 + [0.05] * 3 + [0.01] * 3 + [0.02] * 3 + [0.001] * 3
    filter_.start((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), sigmas)
    return filter_


def sail(memory: InertialMemory, filter_: ErrorStateFilter, from_s: float, to_s: float, ahead_mps2: float) -> None:
    for k in range(round(from_s * 100), round(to_s * 100)):
        force = (ahead_mps2, 0.0, -G)
        filter_.predict(force, NO_TURN, DT_S)
        memory.sample((k + 1) * DT_S, force, NO_TURN, DT_S)
        if k % 20 == 0:
            memory.keep((k + 1) * DT_S, filter_)


def test_a_lane_is_dead_reckoning_that_no_measurement_reaches() -> None:
    memory, filter_ = InertialMemory(), level_filter()
    sail(memory, filter_, 0.0, 5.0, 0.2)
    filter_.velocity = (9.0, 9.0, 0.0)  # as if a receiver had said so
    (lane,) = memory.lanes
    assert lane.velocity[0] == pytest.approx(1.0, abs=0.01)
    assert lane.sigma_mps(lane.from_s) < lane.sigma_mps(lane.from_s + 5.0)


def test_a_lane_knows_the_velocity_of_the_boats_origin_when_it_began() -> None:
    """The sensor swings round it in a turn."""
    memory, filter_ = InertialMemory(), level_filter()
    filter_.velocity = (1.0, 0.5, 0.0)
    memory.keep(0.0, filter_, (0.3, -0.1))
    assert memory.lanes[0].first == pytest.approx((0.7, 0.6)) and memory.lanes[0].velocity == (1.0, 0.5, 0.0)


def test_two_lanes_at_most_each_for_twelve_seconds() -> None:
    memory, filter_ = InertialMemory(), level_filter()
    for second in range(40):
        sail(memory, filter_, second, second + 1.0, 0.0)
        assert 1 <= len(memory.lanes) <= 2
        assert all(second + 1.0 - lane.from_s <= 12.6 for lane in memory.lanes)


def test_it_goes_back_to_before_a_lie_and_on_by_the_samples() -> None:
    memory, filter_ = InertialMemory(), level_filter()
    sail(memory, filter_, 0.0, 5.0, 0.2)
    sigma = math.sqrt(filter_.covariance[0, 0])
    sail(memory, filter_, 5.0, 6.0, 0.2)
    filter_.position, filter_.velocity = (50.0, 0.0, 0.0), (5.0, 0.0, 0.0)  # the lie
    sail(memory, filter_, 6.0, 8.0, 0.2)
    assert memory.go_back(6.0, 8.0, filter_)
    assert filter_.velocity[0] == pytest.approx(1.6, abs=0.02)
    assert filter_.position[0] == pytest.approx(0.5 * 0.2 * 64.0, abs=0.1)
    assert math.sqrt(filter_.covariance[0, 0]) > sigma, "what was not measured is not known as well"
    assert all(lane.from_s < 6.0 for lane in memory.lanes)


def test_it_does_not_remember_as_far_back_as_one_likes() -> None:
    memory, filter_ = InertialMemory(), level_filter()
    assert not memory.go_back(1.0, 2.0, filter_)
    sail(memory, filter_, 0.0, 30.0, 0.1)
    before = filter_.velocity
    assert not memory.go_back(10.0, 30.0, filter_)
    assert filter_.velocity == before
    memory.clear()
    assert memory.lanes == [] and not memory.go_back(29.0, 30.0, filter_)


def test_the_odometer_turns_by_the_bias_of_ten_seconds_ago() -> None:
    """A heading that creeps teaches the filter a bias; the sum of the turn does not follow."""
    odometer = InertialSums()
    odometer.begin()
    for k in range(200):
        t_s = 0.1 * k
        learnt_radps = 0.001 * max(t_s - 15.0, 0.0)
        odometer.learn(t_s, learnt_radps, 1e-4)
        odometer.add(0.1, 0.1, 0.0, 0.02 - learnt_radps, learnt_radps)
    assert odometer.turned_rad == pytest.approx(0.02 * 20.0)
    assert odometer.north_mps == pytest.approx(20.0) and odometer.bias_sigma_radps == 1e-4
    run = odometer.run
    odometer.begin()
    assert odometer.run == run + 1 and math.isinf(odometer.bias_sigma_radps)


@pytest.mark.parametrize("bias_mps2", [0.0, 0.33])
def test_a_lane_that_has_turned_is_less_sure(bias_mps2: float) -> None:
    """The accelerometer's bias and the tilt hide each other on the old heading, not on the new one; and a gyro's axes
    are never quite square. A bias that no calibrated sensor has may be a tilt itself."""
    straight, round_ = InertialMemory(), InertialMemory()
    filter_ = level_filter()
    filter_.accelerometer_bias = (bias_mps2, 0.0, 0.0)
    straight.keep(0.0, filter_)
    round_.keep(0.0, filter_)
    for k in range(500):
        straight.sample(k * DT_S, AT_REST, NO_TURN, DT_S)
        round_.sample(k * DT_S, AT_REST, (0.0, 0.0, math.pi if k < 100 else 0.0), DT_S)
    further = math.sqrt(round_.lanes[0].sigma_mps(5.0) ** 2 - straight.lanes[0].sigma_mps(5.0) ** 2)
    turn_sigma_mps2 = math.hypot(filter_.bias_sigmas()[0], 0.004 * G, 0.3 * bias_mps2)
    assert further == pytest.approx(2.0 * turn_sigma_mps2 * (4.0 + 2.0 / math.pi), rel=0.02)


def test_a_gyro_that_is_not_yet_known_tilts_a_lane() -> None:
    known, unknown = level_filter(), level_filter()
    unknown.covariance[12, 12] = unknown.covariance[13, 13] = 3.5e-3**2
    lanes = []
    for filter_ in (known, unknown):
        memory = InertialMemory()
        memory.keep(0.0, filter_)
        lanes.append(memory.lanes[0])
    assert lanes[0].sigma_mps(0.0) == lanes[1].sigma_mps(0.0)
    assert lanes[1].sigma_mps(10.0) > 0.5 * G * 3.5e-3 * 100.0
