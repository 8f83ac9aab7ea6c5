"""Arithmetic on square matrices without new ones: what the error-state filter does to its covariance at each sample.

`add_to_diagonal`, `subtract` and `symmetrise` have a second form in C, which takes the flat views
(`sitl.native.operations`).
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Flat: TypeAlias = "memoryview[float]"


def flat(array: Array) -> Flat:
    """The array as a flat memoryview: writing through it costs a third of numpy indexing."""
    return array.data.cast("B").cast("d")


def add_to_diagonal(diagonal: Array, added: Array, matrix_flat: Flat, added_flat: Flat) -> None:
    """Add to the diagonal of a square matrix. `diagonal`: a view of it."""
    diagonal += added


def subtract(matrix: Array, other: Array, matrix_flat: Flat, other_flat: Flat) -> None:
    """Subtract another matrix of the same size."""
    matrix -= other


def symmetrise(matrix: Array, transposed: Array, work: Array, matrix_flat: Flat) -> None:
    """P ← ½ (P + Pᵀ). `work`: another matrix of that size, whose contents are lost."""
    np.add(matrix, transposed, work)
    np.multiply(work, 0.5, matrix)
