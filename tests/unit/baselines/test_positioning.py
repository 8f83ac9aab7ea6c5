"""The thesis's law against its printed numbers."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from companion.baselines.controller_choice import controller_with_baselines
from companion.baselines.positioning import ThesisPositioning
from companion.config.vessel import VesselConfig
from companion.control.feedforward import FULL, OFF, PRINTED, SCALED, as_printed, feedforward
from companion.control.model import force_for
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.setpoint import PoseSetpoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import REVOLT, nav_state

HERE = PoseSetpoint(0.0, 0.0, 0.0)
MOVING = PoseSetpoint(
    0.0,
    0.0,
    0.0,
    surge_mps=0.3,
    sway_mps=-0.1,
    yaw_rate_radps=0.05,
    surge_mps2=0.02,
    sway_mps2=0.01,
    yaw_radps2=-0.004,
)


def axes(wrench: Wrench) -> tuple[float, float, float]:
    return wrench.surge_n, wrench.sway_n, wrench.yaw_nm


def law(**values: float) -> ThesisPositioning:
    return ThesisPositioning(REVOLT, Parameters({**REVOLT.parameters, "DP_FF_KIND": 0, **values}))


def test_the_gains_are_those_of_the_sea_trial_per_metre_and_radian() -> None:
    wrench = law(DPT_KI_SURGE=0, DPT_KI_SWAY=0, DPT_KI_YAW=0).update(
        HERE, nav_state(0.2, -0.4, 0.0, 0.1, 0.05, 0.02), 0.2
    )
    assert axes(wrench) == pytest.approx((-25 * 0.2 - 75 * 0.1, 25 * 0.4 - 75 * 0.05, -50 * 0.02))
    turned = law(DPT_KI_YAW=0).update(HERE, nav_state(yaw_rad=0.1), 0.2)
    assert turned.yaw_nm == pytest.approx(-30 * 0.1)


def without_saturation(config: VesselConfig) -> VesselConfig:
    assert config.thesis_model is not None
    return replace(config, thesis_model=replace(config.thesis_model, saturation=None))


def test_it_integrates_without_end() -> None:
    thesis = ThesisPositioning(without_saturation(REVOLT), Parameters({**REVOLT.parameters, "DP_FF_KIND": 0}))
    for _ in range(5 * 600):
        wrench = thesis.update(HERE, nav_state(north_m=1.0), 0.2)
    assert wrench.surge_n == pytest.approx(-25.0 - 0.3 * 600.0, rel=1e-3)


def test_it_asks_for_no_more_than_the_thesis_prints() -> None:
    """±[50, 20, 32], whatever the vessel's limits are; the integral behind it goes on."""
    far = nav_state(north_m=10.0, east_m=-10.0, yaw_rad=math.radians(-90.0))
    assert axes(law().update(HERE, far, 0.2)) == pytest.approx((-50.0, -20.0, 32.0))
    wound = law()
    for _ in range(5 * 600):
        wound.update(HERE, nav_state(north_m=1.0), 0.2)
    assert wound.update(HERE, nav_state(north_m=-5.0), 0.2).surge_n == -50.0


def test_it_samples_at_5_hz_in_a_loop_of_10() -> None:
    thesis = law()
    said = [thesis.update(HERE, nav_state(north_m=0.1 * k), 0.1).surge_n for k in range(6)]
    assert said[0] == said[1] != said[2] == said[3] != said[4] == said[5]


def test_the_printed_feedforward_is_equations_8_13_and_8_14() -> None:
    assert REVOLT.thesis_model is not None
    u, v, r = 0.3, -0.1, 0.05
    mass = np.array([[263.93, 0, 0], [0, 306.44, 7.00], [0, 7.03, 322.15]])
    drag = np.array([[50.66, 0, 0], [0, 601.45, 83.05], [0, 83.10, 268.17]])
    c13, c23 = -207.56 * v + 7.0 * r, 250.07 * u
    coriolis = np.array([[0, 0, c13], [0, 0, c23], [-c13, -c23, 0]])
    body_rate = np.array(
        [MOVING.surge_mps2 + 2 * -r * v, MOVING.sway_mps2 + 2 * r * u, MOVING.yaw_radps2]
    )  # +S(r) in place of −S(r)
    expected = mass @ body_rate + (coriolis + drag) @ np.array([u, v, r])
    assert axes(as_printed(REVOLT.hull, REVOLT.thesis_model, MOVING)) == pytest.approx(list(expected), rel=1e-9)


def test_the_kinds_of_feedforward() -> None:
    printed = feedforward(PRINTED, REVOLT, MOVING, 0.0)
    assert axes(feedforward(OFF, REVOLT, MOVING, 0.0)) == (0.0, 0.0, 0.0)
    assert axes(feedforward(SCALED, REVOLT, MOVING, 0.0)) == pytest.approx(
        [s * f for s, f in zip((1.0, 0.05, 0.2), axes(printed), strict=True)]
    )
    full = force_for(REVOLT.hull, 0.3, -0.1, 0.05, 0.02, 0.01, -0.004)
    assert axes(feedforward(FULL, REVOLT, MOVING, 0.0)) == pytest.approx(axes(full))
    assert abs(printed.sway_n) > 5.0 * abs(full.sway_n), "what made it useless at sea"


def test_the_law_changes_live_and_without_a_jump() -> None:
    parameters = Parameters(REVOLT.parameters)
    controller = controller_with_baselines(REVOLT, parameters)
    before = ZERO_WRENCH
    for _ in range(1200):  # a steady push from starboard, learnt while 2 cm off
        before = controller.update(HERE, nav_state(east_m=0.02), before, 0.1)
    learnt = before.sway_n + parameters["DP_BW_SWAY"] ** 2 * REVOLT.hull.m22_kg * 0.02
    assert parameters.set("DP_LAW", 1) is None
    after = controller.update(HERE, nav_state(), before, 0.1)
    assert after.sway_n == pytest.approx(learnt, rel=0.05) and abs(learnt) > 0.5
    parameters.set("DP_LAW", 0)
    assert controller.update(HERE, nav_state(), after, 0.1).sway_n == pytest.approx(learnt, rel=0.05)


def test_a_non_finite_demand_counts_as_none() -> None:
    parameters = Parameters({**REVOLT.parameters, "DP_LAW": 1})
    controller = controller_with_baselines(REVOLT, parameters)
    assert controller.update(HERE, nav_state(north_m=math.nan), ZERO_WRENCH, 0.1) == ZERO_WRENCH
    assert abs(controller.update(HERE, nav_state(north_m=0.1), ZERO_WRENCH, 0.1).surge_n) < 10.0
