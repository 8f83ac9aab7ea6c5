"""The Riccati equation, against scipy and against the equation itself."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from companion.control.riccati import stabilising


def test_the_solution_is_scipys_and_the_loop_is_stable() -> None:
    draws = np.random.default_rng(3)
    for n, m in ((1, 1), (2, 1), (6, 2), (8, 3)) * 5:
        a, b = draws.normal(size=(n, n)), draws.normal(size=(n, m))
        q, r = np.diag(draws.uniform(0.1, 10.0, n)), np.diag(draws.uniform(1e-3, 1e3, m))
        x = stabilising(a, b, q, r)
        assert x == pytest.approx(solve_continuous_are(a, b, q, r), rel=1e-6, abs=1e-7)
        gain = np.linalg.solve(r, b.T @ x)
        assert a.T @ x + x @ a - x @ b @ gain + q == pytest.approx(np.zeros((n, n)), abs=1e-7 * np.max(np.abs(x)) ** 2)
        assert np.max(np.linalg.eigvals(a - b @ gain).real) < 0.0


def test_a_double_integrator_has_the_gains_of_the_books() -> None:
    """Kalman 1960: 1 and √3, with all weights 1."""
    a, b = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])
    x = stabilising(a, b, np.eye(2), np.eye(1))
    assert x == pytest.approx(np.array([[3.0**0.5, 1.0], [1.0, 3.0**0.5]]), abs=1e-12)


def test_weights_that_are_far_apart_cost_no_digits() -> None:
    """The solution in units of the states in which all weights are alike, and in others."""
    draws = np.random.default_rng(5)
    a, b = draws.normal(size=(6, 6)), draws.normal(size=(6, 2))
    x = stabilising(a, b, np.eye(6), np.eye(2))
    for most in (1e2, 1e4):
        units = np.geomspace(1.0 / most, most, 6)
        across = np.outer(units, units)
        found = stabilising(a * units / units[:, None], b / units[:, None], np.diag(units**2), np.eye(2))
        assert found / across == pytest.approx(x, rel=1e-8, abs=1e-8)


def test_what_no_input_can_hold_has_no_solution() -> None:
    with pytest.raises(ValueError, match="stabilising"):
        stabilising(np.array([[0.0]]), np.array([[0.0]]), np.array([[0.0]]), np.array([[1.0]]))
