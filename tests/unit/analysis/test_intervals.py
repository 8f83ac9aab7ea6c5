"""Covariances of a linear problem: as least squares say with white noise, and wider where the equations lack something."""

from __future__ import annotations

import numpy as np
import pytest

from companion.analysis.disturbance import Array
from companion.analysis.intervals import parts_of, scattered

COUNT, QUANTITIES = 600, 3


def problem(seed: int, lacking: float = 0.0) -> tuple[Array, Array, Array]:
    """(innovations, slopes, error of the result) where the sum of squares is least. `lacking`: size of an effect that
    lasts 60 samples each time."""
    chance = np.random.default_rng(seed)
    slopes = chance.normal(0.0, 1.0, (COUNT, 3, QUANTITIES)) + chance.normal(0.0, 1.0, (10, 3, QUANTITIES)).repeat(
        60, axis=0
    )
    true = chance.normal(0.0, 1.0, QUANTITIES)  # as the prior has it
    effect = lacking * chance.normal(0.0, 1.0, (10, 3)).repeat(60, axis=0)
    seen = slopes @ true + chance.normal(0.0, 1.0, (COUNT, 3)) + effect
    flat = slopes.reshape(-1, QUANTITIES)
    found = np.linalg.solve(flat.T @ flat + np.eye(QUANTITIES), flat.T @ seen.ravel())
    return seen - slopes @ found, -slopes, found - true


def share_covered(lacking: float, own: bool = False) -> float:
    """Of 95 % intervals over many draws. `own`: by the slopes alone."""
    hits = []
    for seed in range(200):
        innovations, slopes, error = problem(seed, lacking)
        flat = slopes.reshape(-1, QUANTITIES)
        by_slopes = np.linalg.inv(flat.T @ flat + np.eye(QUANTITIES))
        spread = by_slopes if own else scattered(innovations, slopes, parts_of(((0, COUNT),), 0.5))
        hits += (np.abs(error) <= 1.96 * np.sqrt(np.diag(spread))).tolist()
    return float(np.mean(hits))


def test_with_white_noise_the_intervals_have_the_truth() -> None:
    assert share_covered(0.0) >= 0.94


def test_what_the_equations_lack_for_a_while_widens_them() -> None:
    assert share_covered(1.0, own=True) < 0.7
    assert share_covered(1.0) > 0.85


def test_the_covariance_is_no_less_than_the_slopes_say() -> None:
    innovations, slopes, _ = problem(1)
    flat = slopes.reshape(-1, QUANTITIES)
    own = np.diag(np.linalg.inv(flat.T @ flat + np.eye(QUANTITIES)))
    spread = scattered(innovations, slopes, ((0, 300), (300, 600)))
    assert (np.diag(spread) >= own * (1.0 - 1e-9)).all()
    assert np.linalg.eigvalsh(spread).min() > 0.0


def test_parts_of_half_a_minute() -> None:
    assert parts_of(((0, 1300), (1300, 1400)), 0.1) == ((0, 325), (325, 650), (650, 975), (975, 1300), (1300, 1400))
    assert parts_of(((0, 40),), 0.1) == ((0, 40),)
    assert sum(end - first for first, end in parts_of(((0, 777),), 0.1)) == pytest.approx(777)
