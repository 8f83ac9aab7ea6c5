"""The Munk moment is met at the boat's own velocity through the water: on a path, and by dynamic positioning faster than
it positions."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.control.bias import BiasForce
from companion.control.dynamic_positioning import DynamicPositioning
from companion.control.heading import YawLoop
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint, PoseSetpoint
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST


@pytest.mark.parametrize(("speed", "share"), [(0.0, 0.0), (0.5, 0.0), (0.625, 0.5), (1.0, 1.0), (-1.0, 1.0)])
def test_the_boats_own_drift_counts_above_positioning_speeds(speed: float, share: float) -> None:
    """(m22 − m11) u v, with v the drift that the reference does not have."""
    config = load(find("aboat"))
    parameters = Parameters({**config.parameters, "DP_SPEED_AHEAD": 0.5})
    moments = []
    for drift in (0.0, 0.2):
        nav = replace(AT_REST, surge_mps=speed, sway_mps=drift, current_north_mps=0.0, current_east_mps=0.0)
        law = DynamicPositioning(config, parameters)
        setpoint = PoseSetpoint(0.0, 0.0, 0.0, surge_mps=speed)
        moments.append(law.update(setpoint, nav, BiasForce(config.limits), 0.1).yaw_nm)
    hull = config.hull
    assert moments[1] - moments[0] == pytest.approx(share * (hull.m22_kg - hull.m11_kg) * speed * 0.2, abs=1e-6)


@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_the_hulls_lift_counts_against_the_moment_of_the_drift(speed: float) -> None:
    """A vectored boat of 0.9 m turned 10 degrees late: the lift of its hull takes most of the Munk moment off ahead."""
    config = load(find("aboat"))
    lifts = replace(config.hull, damping=replace(config.hull.damping, n_uv=-300.0))
    moments = []
    for hull in (config.hull, lifts):
        nav = replace(AT_REST, surge_mps=speed, sway_mps=0.2, current_north_mps=0.0, current_east_mps=0.0)
        law = DynamicPositioning(replace(config, hull=hull), Parameters(config.parameters))
        setpoint = PoseSetpoint(0.0, 0.0, 0.0, surge_mps=speed)
        moments.append(law.update(setpoint, nav, BiasForce(config.limits), 0.1).yaw_nm)
    assert moments[1] - moments[0] == pytest.approx(-300.0 * 0.2, abs=1e-6)


def on_path_nm(drift_mps: float, current_mps: float = 0.0, speed_mps: float = 1.0) -> float:
    """The moment for a heading that the boat has, at that sideways speed over ground."""
    config = load(find("aboat"))
    law = YawLoop(config, Parameters(config.parameters))
    nav: NavState = replace(
        AT_REST, surge_mps=speed_mps, sway_mps=drift_mps, current_north_mps=0.0, current_east_mps=current_mps
    )
    return law.moment_nm(PathSetpoint(0.0, speed_mps), nav, BiasForce(config.limits), 0.1)


@pytest.mark.parametrize("speed_mps", [1.0, -1.0])
def test_on_a_path_the_moment_of_the_drift_is_met_at_once(speed_mps: float) -> None:
    """Cut at that of 14 degrees of heading, a boat that is unstable on its course weaved."""
    config = load(find("aboat"))
    hull = config.hull
    munk_nm = (hull.m22_kg - hull.m11_kg) * speed_mps + hull.damping.n_uv * abs(speed_mps)
    assert abs(munk_nm) < 0.5 * config.limits.yaw_nm
    assert on_path_nm(1.0, speed_mps=speed_mps) - on_path_nm(0.0, speed_mps=speed_mps) == pytest.approx(munk_nm)
    assert on_path_nm(3.0) - on_path_nm(0.0) == pytest.approx(0.5 * config.limits.yaw_nm)


def test_a_current_that_carries_the_boat_aside_is_no_drift() -> None:
    assert on_path_nm(0.3, current_mps=0.3) == pytest.approx(on_path_nm(0.0), abs=1e-9)
