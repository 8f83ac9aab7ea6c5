"""The continuous algebraic Riccati equation, by the sign of its Hamiltonian matrix.

numpy suffices for it: to load scipy's solver takes 27 MB, and a tick too long where a parameter chooses the law.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

Floats: TypeAlias = "NDArray[np.float64]"

_STEPS = 50
_SETTLED, _NEARLY = 1.0e-13, 1.0e-4  # relative change of a step; below the second, rounding keeps it from the first
_REFINEMENTS = 2


def stabilising(a: Floats, b: Floats, q: Floats, r: Floats) -> Floats:
    """X (n×n) of aᵀX + Xa − X b r⁻¹ bᵀ X + q = 0, with which a − b r⁻¹ bᵀ X is stable. `a` n×n, `b` n×m, `q` n×n
    and `r` m×m symmetric. Raises ValueError where there is no such X.

    Source: Roberts, *Linear model reduction and solution of the algebraic Riccati equation by use of the sign function*
    (1980); scaled by the determinant after Byers (1987); refined by Newton's method after Kleinman (1968).
    """
    try:
        x = _by_sign(a, b @ np.linalg.solve(r, b.T), q)
        for _ in range(_REFINEMENTS):
            x = _refined(a, b, q, r, x)
    except np.linalg.LinAlgError as error:
        raise ValueError("the Riccati equation has no stabilising solution") from error
    return x


def _by_sign(a: Floats, g: Floats, q: Floats) -> Floats:
    """X, where weights are far apart with few digits. It is sought as a multiple that brings `g` and `q` together."""
    n = len(a)
    eye = np.eye(n)
    size = math.sqrt(np.linalg.norm(q, 1) / np.linalg.norm(g, 1)) if np.any(q) and np.any(g) else 1.0
    sign = _sign(np.block([[a, -size * g], [-q / size, -a.T]]))
    left, right = np.vstack((sign[:n, n:], sign[n:, n:] + eye)), np.vstack((sign[:n, :n] + eye, sign[n:, :n]))
    return _symmetric(size * np.linalg.lstsq(left, -right, rcond=None)[0])


def _sign(matrix: Floats) -> Floats:
    """The matrix with each eigenvalue replaced by the sign of its real part, by Newton's iteration."""
    before = math.inf
    for _ in range(_STEPS):
        inverse = np.linalg.inv(matrix)
        scale = np.exp(-np.linalg.slogdet(matrix)[1] / len(matrix))
        stepped: Floats = 0.5 * (scale * matrix + inverse / scale)
        change = float(np.linalg.norm(stepped - matrix, 1) / np.linalg.norm(stepped, 1))
        if change <= _SETTLED or before <= change <= _NEARLY:
            return stepped
        matrix, before = stepped, change
    raise np.linalg.LinAlgError


def _refined(a: Floats, b: Floats, q: Floats, r: Floats, x: Floats) -> Floats:
    """A step of Newton's method: the linear equation that X solves with the gain of `x` in the loop. Raises LinAlgError
    where that gain leaves the loop unstable."""
    eye, gain = np.eye(len(a)), np.linalg.solve(r, b.T @ x)
    loop = a - b @ gain
    if not np.max(np.linalg.eigvals(loop).real) < 0.0:
        raise np.linalg.LinAlgError
    weight = q + gain.T @ r @ gain
    equation = np.kron(loop.T, eye) + np.kron(eye, loop.T)
    return _symmetric(np.linalg.solve(equation, -weight.reshape(-1)).reshape(a.shape))


def _symmetric(x: NDArray[np.floating[Any]]) -> Floats:
    symmetric: Floats = 0.5 * (x + x.T)
    return symmetric
