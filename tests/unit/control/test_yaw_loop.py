"""The heading loop under way: no faster than a jet's nozzle can follow."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.core.actuation import ZERO_WRENCH
from companion.core.setpoint import HeadingSetpoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import REVOLT, SimpleBoat

JET_BOAT = load(find("rescuerunner"))
ERROR_RAD = 0.05


def moment_nm(config: VesselConfig, bandwidth_radps: float) -> float:
    """Against a small error of heading, at rest: Kp = m33 ω² of it."""
    parameters = Parameters({**config.parameters, "PATH_BW_YAW": bandwidth_radps})
    setpoint = HeadingSetpoint(ERROR_RAD, ZERO_WRENCH)
    return YawLoop(config, parameters).moment_nm(setpoint, SimpleBoat().nav(), BiasForce(config.limits), 0.0)


def at_rate(rate_dps: float) -> VesselConfig:
    return replace(JET_BOAT, thrusters=(replace(JET_BOAT.thrusters[0], azimuth_rate_radps=math.radians(rate_dps)),))


@pytest.mark.parametrize("rate_dps", [10.0, 14.0, 20.0])
def test_a_slow_nozzle_limits_the_bandwidth(rate_dps: float) -> None:
    """In 1/bandwidth it gets 0.6 of its way to the stop at 24 degrees."""
    bounded = rate_dps / (0.6 * 24.0)
    assert moment_nm(at_rate(rate_dps), 1.8) == pytest.approx(moment_nm(JET_BOAT, bounded))
    assert moment_nm(at_rate(rate_dps), 1.8) < 0.8 * moment_nm(JET_BOAT, 1.8)
    assert moment_nm(at_rate(rate_dps), 0.5 * bounded) == pytest.approx(moment_nm(JET_BOAT, 0.5 * bounded)), (
        "a slower loop stays as it is"
    )


def test_a_fast_nozzle_and_azimuths_do_not_limit_it() -> None:
    assert moment_nm(at_rate(700.0), 1.8) == pytest.approx(moment_nm(JET_BOAT, 1.8))
    slow = replace(REVOLT, thrusters=tuple(replace(thruster, azimuth_rate_radps=0.01) for thruster in REVOLT.thrusters))
    assert moment_nm(slow, 0.8) == moment_nm(REVOLT, 0.8)
