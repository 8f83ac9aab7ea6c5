"""Allocation of a water jet: thrust by throttle and speed, steering only by thrust, and what it says that it gives."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from companion.allocation.jet import JetAllocator
from companion.allocation.jet_curve import JetCurve
from companion.config.vessel import find, load
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.estimate import through_water
from companion.params.store import Parameters

VESSEL = load(find("rescuerunner"))
JET = VESSEL.thrusters[0]
DT_S = 0.05
STOP_RAD = math.radians(24.0)


def allocator(**parameters: float) -> JetAllocator:
    return JetAllocator(VESSEL, Parameters({**VESSEL.parameters, **parameters}))


def settle(a: JetAllocator, wrench: Wrench, surge_mps: float, seconds: float = 80 * DT_S) -> Allocation:
    for _ in range(round(seconds / DT_S)):
        result = a.update(wrench, DT_S, surge_mps)
    return result


def momentum_n(throttle: float, surge_mps: float) -> float:
    """T = ρA V_j (V_j − 0.9 U), written out."""
    exit_mps = 6.0 + 27.0 * throttle**1.32
    return 5.125 * exit_mps * (exit_mps - 0.9 * surge_mps)


@pytest.mark.parametrize("surge_mps", [0.0, 4.0, 8.2, 14.0])
@pytest.mark.parametrize("demand", [(800.0, 0.0), (1000.0, 250.0), (1500.0, -500.0), (2500.0, 600.0)])
def test_a_feasible_demand_is_given_at_any_speed(demand: tuple[float, float], surge_mps: float) -> None:
    result = settle(allocator(), Wrench(demand[0], 0.0, demand[1]), surge_mps)
    (command,) = result.thrusters
    assert command.azimuth_rad is not None
    thrust_n = momentum_n(command.throttle, surge_mps)
    assert thrust_n * math.cos(command.azimuth_rad) == pytest.approx(demand[0], rel=1e-6)
    assert -1.6 * thrust_n * math.sin(command.azimuth_rad) == pytest.approx(demand[1], rel=1e-6, abs=1e-6)
    assert (result.achieved.surge_n, result.achieved.yaw_nm) == pytest.approx(demand, rel=1e-6, abs=1e-6)
    assert result.achieved.sway_n == pytest.approx(thrust_n * math.sin(command.azimuth_rad))
    assert result.limited == (False, False, False)


def test_the_same_thrust_takes_more_throttle_at_speed() -> None:
    slow, fast = (settle(allocator(), Wrench(900.0, 0.0, 0.0), u).thrusters[0].throttle for u in (0.0, 8.2))
    assert fast > slow + 0.15


def test_a_turn_without_thrust_raises_the_thrust_to_jet_steer_n() -> None:
    """No thrust, no steering: 300 N m want 461 N at the stop of the nozzle, and 400 N are allowed for that."""
    result = settle(allocator(JET_STEER_N=400.0), Wrench(0.0, 0.0, 300.0), 1.0, 2.9)
    assert math.hypot(result.achieved.surge_n, result.achieved.sway_n) == pytest.approx(400.0, rel=1e-6)
    assert result.thrusters[0].azimuth_rad == pytest.approx(-STOP_RAD)
    assert result.achieved.yaw_nm == pytest.approx(1.6 * 400.0 * math.sin(STOP_RAD), rel=1e-6)
    assert result.limited == (True, False, True)
    none = settle(allocator(JET_STEER_N=0.0), Wrench(0.0, 0.0, 300.0), 0.0)
    assert none.thrusters[0].throttle == 0.0 and none.achieved.yaw_nm == 0.0


def test_at_speed_a_turn_may_take_as_much_thrust_as_the_water_does() -> None:
    """It lets the boat gather no way. Jets that had to turn back before a fence glided on for 3 s instead."""
    drag_n = VESSEL.hull.drag_n(4.0)
    assert drag_n > 400.0
    result = settle(allocator(JET_STEER_N=100.0), Wrench(-500.0, 0.0, 2000.0), 4.0, 1.5)
    assert math.hypot(result.achieved.surge_n, result.achieved.sway_n) == pytest.approx(drag_n, rel=1e-3)
    enough_n = 200.0 / (1.6 * math.sin(STOP_RAD))
    result = settle(allocator(JET_STEER_N=100.0), Wrench(-500.0, 0.0, 200.0), 4.0, 1.5)
    assert math.hypot(result.achieved.surge_n, result.achieved.sway_n) == pytest.approx(enough_n, rel=1e-3)


def test_where_wind_holds_the_bow_the_thrust_for_steering_grows() -> None:
    """A jet of 2.6 m lay 65° off its heading in 10 m/s, with 7 % of its thrust, and drifted 159 m from home. One of
    2.2 m, whose thrust grew to three times as much within 12 s, went on across the wind, 41 m off its point."""
    jet = allocator(JET_STEER_N=250.0)

    def given_n(seconds: float, yaw_nm: float = 1200.0, surge_n: float = 0.0) -> float:
        for _ in range(round(seconds / DT_S)):
            result = jet.update(Wrench(surge_n, 0.0, yaw_nm), DT_S, 2.0)
        return math.hypot(result.achieved.surge_n, result.achieved.sway_n)

    assert given_n(2.9) == pytest.approx(250.0, rel=1e-3), "a turn is over by then"
    assert given_n(2.1) == pytest.approx(500.0, rel=0.02)
    assert given_n(60.0) == pytest.approx(1500.0, rel=1e-3), "the nozzle may be stuck"
    given_n(14.0, yaw_nm=10.0)
    assert given_n(1.0) == pytest.approx(250.0, rel=1e-3), "forgotten once the bow is free"
    enough_n = 500.0 / (1.6 * math.sin(STOP_RAD))
    assert given_n(60.0, yaw_nm=500.0) == pytest.approx(enough_n, rel=1e-3), "no more than gives the moment"
    given_n(14.0, yaw_nm=10.0)
    given_n(60.0, surge_n=3500.0)
    assert given_n(1.0) == pytest.approx(250.0, rel=1e-3), "the thrust ahead has steered it"


def test_a_turn_back_to_the_other_side_begins_with_jet_steer_n() -> None:
    """Wind holds a bow to one side. RescueRunner, sent to and fro among stones, pushed with up to 1300 N each way, to 5
    m/s where 0.5 were asked for."""
    jet = allocator(JET_STEER_N=250.0)
    settle(jet, Wrench(0.0, 0.0, 1200.0), 2.0, 6.0)
    result = settle(jet, Wrench(0.0, 0.0, -1200.0), 2.0, 2.0)
    assert math.hypot(result.achieved.surge_n, result.achieved.sway_n) == pytest.approx(250.0, rel=1e-3)


def test_a_jet_that_was_stopped_begins_with_jet_steer_n() -> None:
    """Disarmed with its bow against a quay, RescueRunner began its next sail with three times JET_STEER_N."""
    jet = allocator(JET_STEER_N=250.0)
    settle(jet, Wrench(0.0, 0.0, 1200.0), 2.0, 60.0)
    jet.neutral()
    result = settle(jet, Wrench(0.0, 0.0, 1200.0), 2.0, 2.0)
    assert math.hypot(result.achieved.surge_n, result.achieved.sway_n) == pytest.approx(250.0, rel=1e-3)


def test_at_speed_what_the_water_takes_does_not_grow() -> None:
    """Grown as well, it drove the boat past a leader at rest at 3.3 m/s."""
    drag_n = VESSEL.hull.drag_n(4.0)
    result = settle(allocator(JET_STEER_N=0.1 * drag_n), Wrench(0.0, 0.0, 5000.0), 4.0, 20.0)
    assert math.hypot(result.achieved.surge_n, result.achieved.sway_n) == pytest.approx(drag_n, rel=1e-3)


def test_a_jet_cannot_brake_or_push_sideways() -> None:
    result = settle(allocator(), Wrench(-800.0, 0.0, 0.0), 8.0)
    assert result.thrusters[0].throttle == 0.0 and result.achieved == Wrench(0.0, 0.0, 0.0)
    assert result.limited == (True, False, False)


def test_an_impeller_starts_and_stops_at_different_demands() -> None:
    a = allocator()
    first_n = momentum_n(0.05, 0.0)
    assert settle(a, Wrench(0.5 * first_n, 0.0, 0.0), 0.0).thrusters[0].throttle == 0.0
    assert settle(a, Wrench(0.7 * first_n, 0.0, 0.0), 0.0).thrusters[0].throttle == pytest.approx(0.05)
    assert settle(a, Wrench(0.5 * first_n, 0.0, 0.0), 0.0).thrusters[0].throttle == pytest.approx(0.05)
    assert settle(a, Wrench(0.2 * first_n, 0.0, 0.0), 0.0).thrusters[0].throttle == 0.0


def test_throttle_and_nozzle_keep_their_rates() -> None:
    a = allocator()
    before_n, before_rad = momentum_n(0.02, 0.0), 0.0
    for _ in range(40):
        (command,) = a.update(Wrench(3000.0, 0.0, -900.0), DT_S, 0.0).thrusters
        assert command.azimuth_rad is not None
        force_n = momentum_n(command.throttle, 0.0)
        assert force_n - before_n <= JET.force_rate_nps * DT_S + 1e-6
        assert abs(command.azimuth_rad - before_rad) <= math.radians(70.0) * DT_S + 1e-9
        before_n, before_rad = force_n, command.azimuth_rad
    assert force_n > 3000.0
    assert a.update(Wrench(0.0, 0.0, 0.0), DT_S, 0.0).thrusters[0].throttle == 0.0  # closing is never held back


def test_a_failed_jet_gives_nothing() -> None:
    a = allocator()
    a.set_failed(0, True)
    result = settle(a, Wrench(1000.0, 0.0, 100.0), 3.0)
    assert result.achieved == Wrench(0.0, 0.0, 0.0) and result.limited == (True, False, True)
    a.set_failed(0, False)
    assert settle(a, Wrench(1000.0, 0.0, 100.0), 3.0).limited == (False, False, False)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_non_finite_input_is_no_demand(bad: float) -> None:
    assert settle(allocator(), Wrench(bad, 0.0, 0.0), 0.0).thrusters[0].throttle == 0.0
    assert settle(allocator(), Wrench(500.0, 0.0, 0.0), bad).thrusters[0].throttle == 0.0
    direct = allocator().direct((ThrusterCommand(0.0, bad, bad),), 1.0)
    assert direct.thrusters[0] == ThrusterCommand(0.0, 0.0, 0.0)


def test_direct_holds_the_demand_to_the_stops() -> None:
    a = allocator()
    for _ in range(60):
        (command,) = a.direct((ThrusterCommand(0.0, 1.4, math.radians(90.0)),), DT_S, 10.0).thrusters
    assert command.throttle == pytest.approx(1.0, abs=1e-4) and command.azimuth_rad == pytest.approx(STOP_RAD)
    assert command.force_n == pytest.approx(momentum_n(command.throttle, 10.0))
    (command,) = a.direct((ThrusterCommand(0.0, -0.5, 0.0),), DT_S).thrusters
    assert command.throttle == 0.0 and a.neutral().thrusters[0].throttle == 0.0


def test_a_curve_needs_a_jet() -> None:
    with pytest.raises(ValueError, match="is not a jet"):
        JetCurve(load(find("revolt")).thrusters[0])


def test_speed_through_the_water_counts() -> None:
    """Heading east at 5 m/s over ground in a current of 1 m/s to the west: 6 m/s through the water."""
    nav = SimpleNamespace(
        surge_mps=5.0, sway_mps=0.0, yaw_rad=math.radians(90.0), current_north_mps=0.3, current_east_mps=-1.0
    )
    assert through_water(nav)[0] == pytest.approx(6.0)  # type: ignore[arg-type]
    nav.current_east_mps = None
    assert through_water(nav)[0] == 5.0  # type: ignore[arg-type]
