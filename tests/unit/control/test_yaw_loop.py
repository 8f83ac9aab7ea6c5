"""The heading loop under way: no faster than a jet's nozzle can follow."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config import VesselConfig, find, load
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.core.types import Setpoint, SetpointKind
from companion.params import Parameters
from tests.unit.control.simple_boat import REVOLT, SimpleBoat

JET_BOAT = load(find("rescuerunner"))
ERROR_RAD = 0.05


def moment_nm(config: VesselConfig, bandwidth_radps: float) -> float:
    """Against a small error of heading, at rest: Kp = m33 ω² of it."""
    parameters = Parameters({**config.parameters, "PATH_BW_YAW": bandwidth_radps})
    setpoint = Setpoint(SetpointKind.HEADING, yaw_rad=ERROR_RAD)
    return YawLoop(config, parameters).moment_nm(setpoint, SimpleBoat().nav(), BiasForce(config.limits), 0.0)


def at_rate(rate_dps: float) -> VesselConfig:
    return replace(JET_BOAT, thrusters=(replace(JET_BOAT.thrusters[0], azimuth_rate_radps=math.radians(rate_dps)),))


@pytest.mark.parametrize("rate_dps", [10.0, 14.0, 20.0])
def test_a_slow_nozzle_bounds_the_bandwidth(rate_dps: float) -> None:
    """In 1/bandwidth it gets 0.6 of its way to the stop at 24 degrees."""
    bounded = rate_dps / (0.6 * 24.0)
    assert moment_nm(at_rate(rate_dps), 1.8) == pytest.approx(moment_nm(JET_BOAT, bounded))
    assert moment_nm(at_rate(rate_dps), 1.8) < 0.8 * moment_nm(JET_BOAT, 1.8)
    assert moment_nm(at_rate(rate_dps), 0.5 * bounded) == pytest.approx(moment_nm(JET_BOAT, 0.5 * bounded)), "a slower loop stays as it is"


def test_a_quick_nozzle_and_azimuths_do_not() -> None:
    assert moment_nm(at_rate(700.0), 1.8) == pytest.approx(moment_nm(JET_BOAT, 1.8))
    slow = replace(REVOLT, thrusters=tuple(replace(thruster, azimuth_rate_radps=0.01) for thruster in REVOLT.thrusters))
    assert moment_nm(slow, 0.8) == moment_nm(REVOLT, 0.8)
