"""Model-predictive control of planned paths: its programme against an independent solver, its model against the hull,
and closed loops."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from companion.config.vessel import find, load
from companion.control import predictive
from companion.control.bias import BiasForce
from companion.control.controller import Controller
from companion.control.model import coriolis, damping
from companion.control.planned_steps import planned_steps
from companion.control.predictive import PredictiveControl, solved
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned
from companion.core.setpoint import PATH_STEP_S, PathSetpoint, PlannedPose
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

ABOAT = load(find("aboat"))
NO_WIND = (0.0, 0.0, 0.0)
DT_S = 0.1


def parameters(**values: float) -> Parameters:
    return Parameters({**ABOAT.parameters, "PATH_CTRL": 2, **values})


def arc(t_s: float, speed_mps: float = 1.0, rate_radps: float = 0.1, count: int = 19) -> tuple[PlannedPose, ...]:
    """Poses on a circle that begins at the origin, northwards; a rate of 0 gives a line."""
    poses = []
    for k in range(count):
        yaw = rate_radps * (t_s + k * PATH_STEP_S)
        if rate_radps == 0.0:
            poses.append(PlannedPose(speed_mps * (t_s + k * PATH_STEP_S), 0.0, 0.0))
        else:
            radius = speed_mps / rate_radps
            poses.append(PlannedPose(radius * math.sin(yaw), radius * (1.0 - math.cos(yaw)), yaw))
    return tuple(poses)


class Hull:
    """The controller's own hull with a thrust lag, and a constant force from the north."""

    def __init__(self, nav: NavState, force_n: float = 0.0) -> None:
        self.nav = nav
        self.built = np.zeros(3)
        self._force_n = force_n

    def step(self, wrench: Wrench) -> None:
        hull, inner_s = ABOAT.hull, DT_S / 5
        for _ in range(5):
            nav = self.nav
            demand = np.array([wrench.surge_n, wrench.sway_n, wrench.yaw_nm])
            self.built = self.built + inner_s / 0.4 * (demand - self.built)
            motion = (nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps)
            x, y = -self._force_n * math.cos(nav.yaw_rad), self._force_n * math.sin(nav.yaw_rad)
            acting = self.built + np.array([x, y, 0.0]) - np.array(coriolis(hull, *motion))
            inertia = np.array([[hull.m11_kg, 0, 0], [0, hull.m22_kg, hull.m23_kgm], [0, hull.m23_kgm, hull.m33_kgm2]])
            rate = np.linalg.solve(inertia, acting - np.array(damping(hull, *motion)))
            u, v, r = (float(a + inner_s * b) for a, b in zip(motion, rate, strict=True))
            north, east = body_to_ned(u, v, nav.yaw_rad)
            self.nav = replace(
                nav,
                north_m=nav.north_m + inner_s * north, east_m=nav.east_m + inner_s * east,
                yaw_rad=wrap_pi(nav.yaw_rad + inner_s * r),
                surge_mps=u, sway_mps=v, yaw_rate_radps=r, north_mps=north, east_mps=east,
            )  # fmt: skip


def sailed(hull: Hull, rate_radps: float, duration_s: float) -> tuple[list[float], BiasForce]:
    """Cross-track errors over time."""
    law, bias, errors = PredictiveControl(ABOAT, parameters()), BiasForce(ABOAT.limits), []
    wrench = ZERO_WRENCH
    for i in range(round(duration_s / DT_S)):
        poses = arc(i * DT_S, rate_radps=rate_radps)
        setpoint = PathSetpoint(poses[0].yaw_rad, 1.0, exact=True, ahead=poses)
        found = law.update(setpoint, hull.nav, bias, NO_WIND, wrench, DT_S)
        assert found is not None
        wrench = found
        hull.step(wrench)
        now, yaw = poses[0], poses[0].yaw_rad
        errors.append((hull.nav.east_m - now.east_m) * math.cos(yaw) - (hull.nav.north_m - now.north_m) * math.sin(yaw))
    return errors, bias


def test_the_solver_agrees_with_bounded_least_squares() -> None:
    law = PredictiveControl(ABOAT, parameters())
    rng = np.random.default_rng(4)
    for _ in range(20):
        plan = planned_steps(ABOAT.hull, arc(0.0, rate_radps=float(rng.uniform(-0.2, 0.2))), (0.0, 0.0))
        state = rng.normal(size=9) * np.array([1.0, 1.0, 0.3, 0.3, 0.3, 0.1, 50.0, 30.0, 30.0])
        matrix, vector = law.least_squares(plan, state, np.zeros(3))
        most = np.array([ABOAT.limits.surge_n, ABOAT.limits.sway_n, ABOAT.limits.yaw_nm])
        found = solved(matrix, vector, -most, most)
        assert found is not None
        bounds = np.tile(most, matrix.shape[1] // 3)
        other = lsq_linear(matrix, -vector, (-bounds, bounds), tol=1.0e-13, max_iter=500)
        assert found == pytest.approx(other.x[:3], abs=1.0e-3 * float(most.max()))


def test_a_boat_on_the_plan_is_predicted_to_stay_there_by_the_wrench_of_the_plan() -> None:
    """The hull that turns steadily in a circle needs one wrench; with it, all errors stay 0."""
    law = PredictiveControl(ABOAT, parameters())
    plan = planned_steps(ABOAT.hull, arc(0.0), (0.0, 0.0))
    matrix, vector = law.least_squares(plan, np.array([0.0] * 6 + list(plan.wrench[0])), np.array(plan.wrench[0]))
    steady = np.tile(plan.wrench[0], matrix.shape[1] // 3)
    assert np.abs(matrix @ steady + vector).max() < 0.02


def test_it_keeps_to_a_line_and_a_circle() -> None:
    for rate_radps in (0.0, 0.1, -0.15):
        errors, _ = sailed(Hull(nav_state(east_m=1.0, surge_mps=1.0)), rate_radps, 60.0)
        assert max(map(abs, errors[200:])) < 0.03


def test_the_observer_learns_a_force_that_the_model_leaves_out() -> None:
    errors, bias = sailed(Hull(nav_state(surge_mps=1.0), force_n=40.0), 0.0, 90.0)
    assert bias.in_body(0.0)[0] == pytest.approx(40.0, abs=2.0)
    assert abs(errors[-1]) < 0.02


def test_the_wrench_stays_within_the_limits() -> None:
    law, bias = PredictiveControl(ABOAT, parameters()), BiasForce(ABOAT.limits)
    setpoint = PathSetpoint(0.0, 1.0, exact=True, ahead=arc(0.0))
    far = nav_state(north_m=-20.0, east_m=15.0, yaw_rad=2.0)
    wrench = law.update(setpoint, far, bias, (-50.0, 30.0, 10.0), ZERO_WRENCH, DT_S)
    assert wrench is not None
    assert abs(wrench.surge_n) <= ABOAT.limits.surge_n + 1.0e-6
    assert abs(wrench.sway_n) <= ABOAT.limits.sway_n + 1.0e-6 and abs(wrench.yaw_nm) <= ABOAT.limits.yaw_nm + 1.0e-6


def test_the_loops_take_over_without_poses_ahead_and_where_the_solver_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    nav = nav_state(surge_mps=0.8)
    bare = PathSetpoint(0.0, 1.0, exact=True)
    loops = Controller(ABOAT, parameters(PATH_CTRL=0)).update(bare, nav, ZERO_WRENCH, DT_S)
    assert Controller(ABOAT, parameters()).update(bare, nav, ZERO_WRENCH, DT_S) == loops
    looking = replace(bare, ahead=arc(0.0, rate_radps=0.0))
    assert Controller(ABOAT, parameters()).update(looking, nav, ZERO_WRENCH, DT_S) != loops
    monkeypatch.setattr(predictive, "solved", lambda *_: None)
    fallen_back = Controller(ABOAT, parameters()).update(looking, nav, ZERO_WRENCH, DT_S)
    assert fallen_back.surge_n == pytest.approx(loops.surge_n, rel=0.02)
