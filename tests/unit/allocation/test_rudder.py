"""Allocation of a propeller with a rudder: force by flow, thrust added to steer, and what it says that it gives."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.allocation.rudder import RudderAllocator
from companion.allocation.rudder_curve import RudderCurve
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.params.store import Parameters
from tests.unit.rudder_boat import SKIFF

(THRUSTER,) = SKIFF.thrusters
CURVE = RudderCurve(THRUSTER)
STOP_RAD = math.radians(35.0)
DT_S = 0.1
speeds = st.floats(-1.0, 3.0)


def allocator(**parameters: float) -> RudderAllocator:
    return RudderAllocator(SKIFF, Parameters({**SKIFF.parameters, **parameters}))


def settle(a: RudderAllocator, wrench: Wrench, surge_mps: float = 0.0) -> Allocation:
    for _ in range(50):
        result = a.update(wrench, DT_S, surge_mps)
    return result


@given(st.floats(-STOP_RAD, STOP_RAD))
def test_no_force_without_flow(angle_rad: float) -> None:
    assert CURVE.force_n(0.0, angle_rad, 0.0) == (0.0, 0.0)
    assert CURVE.force_n(0.0, angle_rad, -1.0) == (0.0, 0.0)


@given(st.floats(-STOP_RAD, STOP_RAD), st.floats(0.5, 80.0), speeds)
def test_the_angle_undoes_the_force(angle_rad: float, thrust_n: float, surge_mps: float) -> None:
    _, side_n = CURVE.force_n(thrust_n, angle_rad, surge_mps)
    assert CURVE.angle_rad(side_n, thrust_n, surge_mps) == pytest.approx(angle_rad, abs=1e-6)


@given(st.floats(0.1, 30.0), st.floats(0.0, 2.0))
def test_the_least_thrust_gives_the_side_force_at_the_stop(side_n: float, surge_mps: float) -> None:
    thrust_n = CURVE.thrust_n(side_n, surge_mps)
    _, given_n = CURVE.force_n(thrust_n, STOP_RAD, surge_mps)
    assert given_n == pytest.approx(side_n, rel=1e-6) if thrust_n > 0.0 else given_n >= side_n


def test_side_force_at_rest_by_hand() -> None:
    """Race of momentum theory, lift of Whicker and Fehlner, for the blade of the file."""
    blade = THRUSTER.rudder
    assert blade is not None and THRUSTER.propeller_m is not None
    race_mps = 0.6 * math.sqrt(2.0 * 80.0 / (1025.0 * math.pi / 4.0 * THRUSTER.propeller_m**2))
    ratio, angle = blade.span_m / blade.chord_m, 0.3
    lift = 1.8 * math.pi * ratio / (math.sqrt(ratio**2 + 4.0) + 1.8) * angle + 0.8 / ratio * angle**2
    expected = 0.5 * 1025.0 * blade.span_m * blade.chord_m * blade.race_share * race_mps**2 * lift
    assert CURVE.force_n(80.0, angle, 0.0)[1] == pytest.approx(expected, rel=1e-9)


def test_astern_leaves_only_what_stands_beside_the_race() -> None:
    ahead, astern = CURVE.inflow(0.0, 1.5), CURVE.inflow(-20.0, 1.5)
    assert THRUSTER.rudder is not None
    assert astern == pytest.approx((1.0 - THRUSTER.rudder.race_share) * ahead)


@pytest.mark.parametrize(("surge_n", "yaw_nm", "surge_mps"), [(20.0, 5.0, 0.5), (60.0, -12.0, 1.5), (40.0, 8.0, 0.0)])
def test_a_feasible_demand_is_given(surge_n: float, yaw_nm: float, surge_mps: float) -> None:
    result = settle(allocator(), Wrench(surge_n, 0.0, yaw_nm), surge_mps)
    assert result.achieved.yaw_nm == pytest.approx(yaw_nm, rel=1e-6) and not result.limited[2]
    assert surge_n - 10.0 < result.achieved.surge_n <= surge_n  # the drag of the blade


def test_thrust_is_added_to_steer_up_to_its_share() -> None:
    gentle = settle(allocator(), Wrench(0.0, 0.0, 5.0))
    a = allocator()
    for _ in range(25):  # the thrust is there, and a turn may still be quick
        hard = a.update(Wrench(0.0, 0.0, 1000.0), DT_S)
    assert gentle.achieved.yaw_nm == pytest.approx(5.0, rel=1e-6) and gentle.limited[0]
    assert hard.thrusters[0].force_n == pytest.approx(0.35 * 80.0) and hard.limited[2]
    assert settle(allocator(RUD_STEER=0.0), Wrench(0.0, 0.0, 5.0)).thrusters[0].force_n == 0.0


def test_wind_that_holds_the_bow_gets_all_thrust_and_a_turn_that_is_done_gives_it_back() -> None:
    a = allocator()
    held = [settle(a, Wrench(0.0, 0.0, 1000.0)) for _ in range(2)][-1]
    assert held.thrusters[0].force_n == pytest.approx(80.0)
    for _ in range(2):
        settle(a, Wrench(0.0, 0.0, 5.0))
    assert a.update(Wrench(0.0, 0.0, 1000.0), DT_S).thrusters[0].force_n <= 0.35 * 80.0 + 1e-6
    never = allocator(RUD_STEER=0.0)
    assert [settle(never, Wrench(0.0, 0.0, 1000.0)) for _ in range(2)][-1].thrusters[0].force_n == 0.0


def test_it_brakes_or_steers_whichever_is_asked_for_more() -> None:
    limits = SKIFF.limits
    braking = settle(allocator(), Wrench(-limits.surge_n, 0.0, 0.1 * limits.yaw_nm), 0.5)
    steering = settle(allocator(), Wrench(-0.1 * limits.surge_n, 0.0, limits.yaw_nm), 0.5)
    assert braking.thrusters[0].force_n == pytest.approx(THRUSTER.min_n)
    assert steering.thrusters[0].force_n > 0.0


@given(
    st.lists(st.tuples(st.floats(-200, 200), st.floats(-50, 50), speeds), min_size=2, max_size=20),
)
def test_no_demand_leads_out_of_limits_and_rates(demands: list[tuple[float, float, float]]) -> None:
    a, force_n, angle_rad = allocator(), 0.0, 0.0
    for surge_n, yaw_nm, surge_mps in demands:
        (command,) = a.update(Wrench(surge_n, 3.0, yaw_nm), DT_S, surge_mps).thrusters
        assert command.azimuth_rad is not None and abs(command.azimuth_rad) <= STOP_RAD + 1e-9
        assert abs(command.azimuth_rad - angle_rad) <= math.radians(30.0) * DT_S + 1e-9
        assert abs(command.force_n - force_n) <= THRUSTER.force_rate_nps * DT_S + 1e-6
        assert THRUSTER.min_n <= command.force_n <= THRUSTER.max_n
        force_n, angle_rad = command.force_n, command.azimuth_rad


def test_nonsense_counts_as_no_demand_and_a_failed_propeller_stands() -> None:
    a = allocator()
    assert settle(a, Wrench(math.nan, 0.0, 0.0)).achieved == Wrench(0.0, 0.0, 0.0)
    a.set_failed(0, True)
    assert settle(a, Wrench(50.0, 0.0, 5.0)).thrusters[0].force_n == 0.0
    under_way = settle(a, Wrench(50.0, 0.0, 5.0), 1.5)
    assert under_way.achieved.yaw_nm == pytest.approx(5.0, rel=1e-6), "the blade steers while the boat moves"


def test_manual_takes_throttle_and_angle() -> None:
    a = allocator()
    for _ in range(50):
        (command,) = a.direct((ThrusterCommand(0.0, 0.5, -0.4),)).thrusters
    assert command.throttle == pytest.approx(0.5) and command.azimuth_rad == pytest.approx(-0.4)
