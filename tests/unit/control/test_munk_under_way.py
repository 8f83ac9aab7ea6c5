"""Dynamic positioning faster than it positions: the Munk moment is met at the boat's own velocity through the water."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.control.bias import BiasForce
from companion.control.dynamic_positioning import DynamicPositioning
from companion.core.setpoint import PoseSetpoint
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
