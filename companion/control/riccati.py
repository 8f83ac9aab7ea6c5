"""The continuous algebraic Riccati equation, by the sign of its Hamiltonian matrix.

numpy suffices for it: to load scipy's solver takes 27 MB, and a tick too long where a parameter chooses the law.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

Floats: TypeAlias = "NDArray[np.float64]"

_STEPS = 50
_SETTLED = 1.0e-13  # relative change of a step


def stabilising(a: Floats, b: Floats, q: Floats, r: Floats) -> Floats:
    """X (n×n) of aᵀX + Xa − X b r⁻¹ bᵀ X + q = 0, with which a − b r⁻¹ bᵀ X is stable. `a` n×n, `b` n×m, `q` n×n
    and `r` m×m symmetric. Raises ValueError where there is no such X.

    Source: Roberts, *Linear model reduction and solution of the algebraic Riccati equation by use of the sign function*
    (1980); scaled by the determinant after Byers (1987).
    """
    n = len(a)
    eye = np.eye(n)
    try:
        sign = _sign(np.block([[a, -b @ np.linalg.solve(r, b.T)], [-q, -a.T]]))
        left, right = np.vstack((sign[:n, n:], sign[n:, n:] + eye)), np.vstack((sign[:n, :n] + eye, sign[n:, :n]))
        x = np.linalg.lstsq(left, -right, rcond=None)[0]
    except np.linalg.LinAlgError as error:
        raise ValueError("the Riccati equation has no stabilising solution") from error
    symmetric: Floats = 0.5 * (x + x.T)
    return symmetric


def _sign(matrix: Floats) -> Floats:
    """The matrix with each eigenvalue replaced by the sign of its real part, by Newton's iteration."""
    for _ in range(_STEPS):
        inverse = np.linalg.inv(matrix)
        scale = np.exp(-np.linalg.slogdet(matrix)[1] / len(matrix))
        stepped: Floats = 0.5 * (scale * matrix + inverse / scale)
        if np.linalg.norm(stepped - matrix, 1) <= _SETTLED * np.linalg.norm(stepped, 1):
            return stepped
        matrix = stepped
    raise np.linalg.LinAlgError
