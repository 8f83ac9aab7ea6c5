"""The push of wind and current on a boat adrift, and positioning that takes it up."""

import math
from dataclasses import replace

import pytest

from companion.control.controller import Controller
from companion.control.free_drift import FreeDrift
from companion.control.model import damping
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import NavState
from companion.core.setpoint import NEUTRAL_SETPOINT, PoseSetpoint, Setpoint, ThrusterSetpoint
from companion.params.store import Parameters
from sitl.hull import Hull
from tests.unit.control.simple_boat import REVOLT, nav_state

DT_S = 0.1
DRIFT_MPS = 0.2  # to the east, across the bow
IDLE = ThrusterSetpoint(())


def drifting(t_s: float, drift_mps: float = DRIFT_MPS) -> NavState:
    return replace(nav_state(sway_mps=drift_mps), east_mps=drift_mps, north_mps=0.0, t_s=t_s, position_valid=True)


def pushed_n() -> float:
    return damping(REVOLT.hull, 0.0, DRIFT_MPS, 0.0)[1]


def taken_up(
    adrift: Setpoint = NEUTRAL_SETPOINT,
    lasts_s: float = 10.0,
    wind_mps: float | None = None,
    achieved: Wrench = ZERO_WRENCH,
) -> Wrench:
    """The first demand of positioning, at its point and at rest, after a while adrift."""
    controller = Controller(REVOLT, Parameters(REVOLT.parameters))
    steps = round(lasts_s / DT_S)
    for step in range(steps):
        controller.update(adrift, drifting(step * DT_S), achieved, DT_S)
    here = replace(
        drifting(steps * DT_S, 0.0), wind_speed_mps=wind_mps, wind_from_rad=None if wind_mps is None else 0.0
    )
    return controller.update(PoseSetpoint(0.0, 0.0, 0.0), here, ZERO_WRENCH, DT_S)


@pytest.mark.parametrize("adrift", [NEUTRAL_SETPOINT, IDLE])
def test_positioning_begins_with_a_force_against_what_pushed_the_boat(adrift: Setpoint) -> None:
    """The integral had to learn it: in 6 m/s of wind catamarans and launches lay 0.4 m behind their reference, which
    waited for them."""
    wrench = taken_up(adrift)
    assert wrench.sway_n == pytest.approx(-pushed_n(), rel=0.02)
    assert wrench.surge_n == pytest.approx(0.0, abs=0.01)


def test_too_short_a_while_adrift_or_one_with_thrust_tells_nothing() -> None:
    assert taken_up(lasts_s=3.0).sway_n == 0.0
    assert taken_up(IDLE, achieved=Wrench(5.0, 0.0, 0.0)).sway_n == 0.0


def test_a_measured_wind_tells_the_push_itself() -> None:
    assert abs(taken_up(wind_mps=0.0).sway_n) < 0.01


def test_what_a_boat_has_of_its_own_way_is_no_push() -> None:
    hull, drift = Hull(REVOLT.hull), FreeDrift(REVOLT.hull)
    hull.place(0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    for step in range(100):
        nav = replace(
            nav_state(surge_mps=hull.surge_mps), north_mps=hull.surge_mps, t_s=step * DT_S, position_valid=True
        )
        drift.see(nav, ZERO_WRENCH, DT_S)
        hull.step(0.0, 0.0, 0.0, DT_S)
    push = drift.push(9.9)
    assert push is not None and math.hypot(*push) < 0.05 * REVOLT.hull.drag_n(1.0)


def test_it_tells_nothing_of_long_ago_nor_without_a_valid_estimate() -> None:
    drift = FreeDrift(REVOLT.hull)
    for step in range(100):
        drift.see(drifting(step * DT_S), ZERO_WRENCH, DT_S)
    assert drift.push(10.0) == pytest.approx((0.0, pushed_n()))
    assert drift.push(12.0) is None
    drift.see(replace(drifting(10.0), position_valid=False), ZERO_WRENCH, DT_S)
    assert drift.push(10.0) is None
