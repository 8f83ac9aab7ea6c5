"""PID and LQR of speed and heading: their gains, when they are computed, and what another load does to them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from companion.baselines.controller_choice import controller_with_baselines
from companion.baselines.tracking import ThesisTracking
from companion.control import lqr
from companion.control.lqr import LqrTracking, gains
from companion.core.actuation import ZERO_WRENCH
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters
from tests.unit.control.load_steps import ABOAT, respond
from tests.unit.control.simple_boat import nav_state

AHEAD = PathSetpoint(yaw_rad=0.0, surge_mps=1.2)


def parameters(**values: float) -> Parameters:
    return Parameters({**ABOAT.parameters, **values})


def test_a_pid_is_its_gains_times_its_errors() -> None:
    law = ThesisTracking(ABOAT.limits, parameters(WPT_KI_SURGE=0, WPT_KI_YAW=0))
    wrench = law.update(AHEAD, nav_state(yaw_rad=0.1, surge_mps=1.0, yaw_rate_radps=0.05), 0.1)
    assert (wrench.surge_n, wrench.sway_n, wrench.yaw_nm) == pytest.approx(
        (200.0 * 0.2, 0.0, -350.0 * 0.1 - 430.0 * 0.05)
    )


def test_integrals_end_at_half_of_the_limits() -> None:
    law = ThesisTracking(ABOAT.limits, parameters())
    for _ in range(5000):
        wrench = law.update(AHEAD, nav_state(yaw_rad=0.2), 0.1)
    assert wrench.surge_n == pytest.approx(200.0 * 1.2 + 0.5 * 400.0)
    assert wrench.yaw_nm == pytest.approx(-350.0 * 0.2 - 0.5 * 350.0)


def test_each_value_that_a_parameter_may_have_gives_gains() -> None:
    """A value without gains would end the companion at each start."""
    names = ("WP_SPEED", "LQR_ERR_SPEED", "LQR_ERR_YAW", "LQR_ERR_RATE", "LQR_INT_T", "LQR_EFFORT")
    specs = [spec for name in names if (spec := parameters().spec(name)) is not None]
    for values in product(*((spec.minimum, spec.maximum) for spec in specs)):
        found = np.array(gains(ABOAT, parameters(**dict(zip(names, values, strict=True)))))
        assert np.all(np.isfinite(found)) and found[0, 1] > 0.0 and found[1, 3] > 0.0


def test_the_gains_are_those_of_the_finite_horizon_far_from_its_end() -> None:
    """Independent of the Riccati solver: the Riccati differential equation, integrated backwards until it rests."""
    table = parameters(PATH_CTRL=1)
    surge, yaw = gains(ABOAT, table)
    h, d, u = ABOAT.hull, ABOAT.hull.damping, table["WP_SPEED"]
    inverse_mass, effort = 1.0 / h.m11_kg, (table["LQR_EFFORT"] * ABOAT.limits.surge_n) ** 2
    a = np.array([[0.0, 1.0], [0.0, -(d.x_u + 2.0 * d.x_uu * u) * inverse_mass]])
    b = np.array([[0.0], [inverse_mass]])
    slow, time = table["LQR_ERR_SPEED"], table["LQR_INT_T"]
    q = np.diag([1.0 / (slow * time) ** 2, 1.0 / slow**2])
    p = np.zeros((2, 2))
    for _ in range(60_000):
        p = p + 0.002 * (a.T @ p + p @ a - effort * p @ b @ b.T @ p + q)
    assert surge[:2] == pytest.approx((effort * b.T @ p)[0], rel=1e-3)
    assert surge[2:] == pytest.approx([0.0] * 4, abs=1e-6) and yaw[:2] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert yaw[2] > 0.0 and yaw[3] > 0.0 and yaw[5] > 0.0


def test_gains_are_computed_when_a_parameter_changes_and_never_in_a_tick(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    real = gains
    monkeypatch.setattr(lqr, "gains", lambda config, table: calls.append(1) or real(config, table))
    table = parameters()
    law = LqrTracking(ABOAT, table)
    assert not law.chosen and not calls
    with pytest.raises(RuntimeError):
        law.update(AHEAD, nav_state(), 0.1)
    table.set("PATH_CTRL", 1)
    assert law.chosen and len(calls) == 1
    before = law.update(AHEAD, nav_state(yaw_rad=0.1), 0.1)
    table.set("LQR_ERR_YAW", 5.0)
    table.set("DP_BW_YAW", 0.5)
    assert len(calls) == 2
    assert abs(law.update(AHEAD, nav_state(yaw_rad=0.1), 0.1).yaw_nm) > 1.5 * abs(before.yaw_nm)
    for _ in range(50):
        law.update(AHEAD, nav_state(), 0.1)
    assert len(calls) == 2


@pytest.mark.parametrize("values", [{"WP_LAW": 1.0}, {"PATH_CTRL": 1.0}, {"WP_LAW": 1.0, "PATH_CTRL": 1.0}])
def test_the_controller_survives_a_non_finite_state(values: dict[str, float]) -> None:
    controller = controller_with_baselines(ABOAT, parameters(**values))
    controller.update(AHEAD, nav_state(surge_mps=1.0), ZERO_WRENCH, 0.1)
    assert controller.update(AHEAD, nav_state(surge_mps=math.nan), ZERO_WRENCH, 0.1) == ZERO_WRENCH
    wrench = controller.update(AHEAD, nav_state(surge_mps=1.0), ZERO_WRENCH, 0.1)
    assert wrench.surge_n > 0.0 and wrench.sway_n == 0.0


def test_effect_of_another_load() -> None:
    """The thesis found its LQR worse with varying mass than its PID, on a model without Coriolis and centripetal
    forces. On this hull, which has them, the heaviest load makes the Munk moment half of the yaw loop's business, and
    the PID suffers more than the LQR, which feeds sway back. Each keeps its gains, tuned for a load of 126 kg; the
    companion's loops are hardly touched."""
    laws = {"pid": {"WP_LAW": 1.0}, "lqr": {"WP_LAW": 1.0, "PATH_CTRL": 1.0}, "companion": {}}
    runs = {name: [respond(load, **values) for load in (34.0, 126.0, 295.0)] for name, values in laws.items()}
    nominal = 1
    worst = {name: max(r.heading_iae for r in rows) / rows[nominal].heading_iae for name, rows in runs.items()}
    assert worst["pid"] > 1.5 * worst["lqr"] > worst["companion"] and worst["companion"] < 1.35
    assert all(r.restless_deg < 1.0 for rows in runs.values() for r in rows)
    assert all(r.overshoot_mps < 0.1 for rows in runs.values() for r in rows)


def test_without_the_munk_moment_the_load_matters_little_to_either_law() -> None:
    """As in the thesis's model, whose finding then comes out in its sign, if not in its size."""
    plain = replace(ABOAT, hull=replace(ABOAT.hull, m22_kg=ABOAT.hull.m11_kg))
    ratios = []
    for values in ({"WP_LAW": 1.0}, {"WP_LAW": 1.0, "PATH_CTRL": 1.0}):
        nominal, laden = (respond(load, plain, **values).heading_iae for load in (126.0, 295.0))
        ratios.append(laden / nominal)
    assert 1.0 < ratios[0] < ratios[1] < 1.15
