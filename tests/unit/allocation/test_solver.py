"""The quadratic programme against closed forms, and the allocation problem against an independent optimiser."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from companion.allocation.geometry import column, thrusters_of, wrench_of
from companion.allocation.pseudo_inverse import PseudoInverse
from companion.allocation.solver import AllocationSolver, BoxQuadratic, Problem
from tests.unit.control.simple_boat import REVOLT

THRUSTERS = thrusters_of(REVOLT)
SCALES = (50.0, 20.0, 32.0)


def test_an_unconstrained_quadratic_is_a_linear_system() -> None:
    rng = np.random.default_rng(2)
    for size in (1, 3, 5):
        qp = BoxQuadratic(size)
        root = rng.normal(size=(size, size))
        h, f = root @ root.T + np.eye(size), rng.normal(size=size)
        x = qp.solve(h.ravel().tolist(), f.tolist(), [-1e3] * size, [1e3] * size)
        assert x == pytest.approx(list(np.linalg.solve(h, -f)), abs=1e-9)


def test_a_diagonal_quadratic_in_a_box_is_clipped() -> None:
    x = BoxQuadratic(3).solve([2.0, 0, 0, 0, 4.0, 0, 0, 0, 1.0], [-10.0, 4.0, 0.5], [-1.0] * 3, [1.0, 2.0, 3.0])
    assert x == pytest.approx([1.0, -1.0, -0.5])


def test_a_box_closed_to_a_point() -> None:
    assert BoxQuadratic(2).solve([1.0, 0.5, 0.5, 1.0], [0.0, -3.0], [0.7, -9.0], [0.7, 9.0]) == pytest.approx(
        [0.7, 2.65]
    )


def problem(rng: np.random.Generator, turn_rad: float) -> Problem:
    """A random demand from a random layout with room to move."""
    p = Problem(3)
    p.demand = (float(rng.uniform(-40, 40)), float(rng.uniform(-15, 15)), float(rng.uniform(-25, 25)))
    p.forces_n = [float(rng.uniform(-15, 15)), float(rng.uniform(-15, 15)), float(rng.uniform(-4, 8))]
    p.azimuths_rad = [float(rng.uniform(-3, 3)), float(rng.uniform(-3, 3)), math.pi / 2.0]
    for i, t in enumerate(THRUSTERS):
        p.force_low_n[i], p.force_high_n[i] = max(t.min_n, p.forces_n[i] - 8.0), min(t.max_n, p.forces_n[i] + 8.0)
        p.turn_low_rad[i], p.turn_high_rad[i] = p.azimuths_rad[i] - turn_rad, p.azimuths_rad[i] + turn_rad
    return p


def missed(p: Problem, forces: list[float], azimuths: list[float]) -> float:
    """Weighted square of what the wrench falls short."""
    w = wrench_of(THRUSTERS, forces, azimuths)
    parts = ((p.demand[0] - w.surge_n) / 50.0, (p.demand[1] - w.sway_n) / 20.0, 2.0 * (p.demand[2] - w.yaw_nm) / 32.0)
    return sum(s * s for s in parts)


def test_a_step_is_nearly_as_good_as_an_independent_optimiser() -> None:
    rng = np.random.default_rng(5)
    solver = AllocationSolver(THRUSTERS, SCALES)
    worse = []
    for _ in range(60):
        p = problem(rng, 0.26)
        p.iterations = 6
        forces, azimuths = solver.solve(p)
        bounds = [(p.force_low_n[i], p.force_high_n[i]) for i in range(3)] + [
            (p.turn_low_rad[i], p.turn_high_rad[i]) for i in range(2)
        ]

        def cost(x: np.ndarray, p: Problem = p) -> float:
            return 1.0e3 * missed(p, list(x[:3]), [x[3], x[4], math.pi / 2.0])

        oracle = minimize(
            cost, [*p.forces_n, *p.azimuths_rad[:2]], bounds=bounds, method="SLSQP", options={"maxiter": 300}
        )
        worse.append(math.sqrt(missed(p, forces, azimuths)) - math.sqrt(max(0.0, oracle.fun / 1.0e3)))
    assert np.median(worse) < 1.0e-3, "of the limits of the wrench"
    assert np.quantile(worse, 0.95) < 0.03
    assert max(worse) < 0.15, "both are local: a few problems have two valleys"


def test_with_fixed_azimuths_the_forces_are_least_squares() -> None:
    p = problem(np.random.default_rng(7), 0.0)
    p.w_power = 0.0
    p.forces_n = [0.0, 0.0, 0.0]
    for i in range(3):
        p.force_low_n[i], p.force_high_n[i] = -1e4, 1e4
    forces, azimuths = AllocationSolver(THRUSTERS, SCALES).solve(p)
    matrix = np.array([column(t, a) for t, a in zip(THRUSTERS, azimuths, strict=True)]).T
    assert list(matrix @ np.array(forces)) == pytest.approx(list(p.demand), rel=0.02, abs=0.1)
    assert azimuths == p.azimuths_rad


def test_the_pseudo_inverse_gives_the_wrench_with_least_effort() -> None:
    rng = np.random.default_rng(3)
    inverse = PseudoInverse(THRUSTERS, SCALES)
    for _ in range(20):
        demand = tuple(rng.normal(size=3) * 10.0)
        parts = inverse.forces_n(demand)
        x = parts[0][0] + parts[1][0]
        y = parts[0][1] + parts[1][1] + parts[2][0]
        n = (
            sum(t.x_m * fy - t.y_m * fx for t, (fx, fy) in zip(THRUSTERS[:2], parts[:2], strict=True))
            + 1.15 * parts[2][0]
        )
        assert (x, y, n) == pytest.approx(demand, abs=1e-9)
        matrix = np.array([[1, 0, 1, 0, 0], [0, 1, 0, 1, 1], [0.15, -1.65, -0.15, -1.65, 1.15]]) * np.array(
            [25, 25, 25, 25, 14]
        )
        expected = np.linalg.lstsq(matrix, np.array(demand), rcond=None)[0] * np.array([25, 25, 25, 25, 14])
        assert [*parts[0], *parts[1], parts[2][0]] == pytest.approx(list(expected), abs=1e-9)


def test_a_failed_thruster_is_left_out_of_the_inverse() -> None:
    inverse = PseudoInverse(THRUSTERS, SCALES)
    inverse.refresh(frozenset({2}))
    parts = inverse.forces_n((10.0, 0.0, 0.0))
    assert parts[2] == (0.0, 0.0)
    assert parts[0][0] + parts[1][0] == pytest.approx(10.0)
