"""The law of path setpoints without a plan."""

from __future__ import annotations

import pytest

from companion.config.vessel import find, load
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.control.path_control import PathControl
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state


def test_a_turn_on_the_spot_carries_no_hull_aside() -> None:
    """The water on a hull whose pressure lies off its middle pushes it aside as it turns: 1.59 N at 0.2 rad/s. A model
    ship of 1.26 m, sent home from its fence, drifted 0.58 m over it while its bow came round."""
    ship = load(find("cybership2"))
    parameters = Parameters(ship.parameters)
    law = PathControl(ship, parameters, YawLoop(ship, parameters))
    rate = -0.2
    setpoint = PathSetpoint(yaw_rad=-2.0, surge_mps=0.0)
    wrench = law.update(setpoint, nav_state(yaw_rate_radps=rate), BiasForce(ship.limits), 0.1)
    assert wrench.sway_n == pytest.approx((7.250 + 3.450 * 0.2) * rate)
