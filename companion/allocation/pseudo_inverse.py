"""Unconstrained allocation by the pseudo-inverse of the extended thrust matrix (ReVolt thesis 4.3.1).

A turning thruster counts as two forces, along and across the hull; a fixed one as one. Least squares of all forces,
each as a share of the thruster's full force.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from companion.allocation.geometry import Thruster


class PseudoInverse:
    """Wrench → force vector (x, y) of each thruster, without limits and rates. `scales`: the wrench limits; an axis
    with 0 is not controlled. Remembers the inverse for the thrusters that work."""

    def __init__(self, thrusters: Sequence[Thruster], scales: tuple[float, float, float]) -> None:
        self._thrusters = tuple(thrusters)
        self._axes = tuple(i for i, scale in enumerate(scales) if scale > 0.0)
        self._rows: list[tuple[tuple[float, float, float], ...]] = []
        self.refresh(frozenset())

    def refresh(self, failed: frozenset[int]) -> None:
        """Compute the inverse anew, without the `failed` thrusters."""
        columns: list[tuple[float, float, float]] = []
        for i, t in enumerate(self._thrusters):
            scale = 0.0 if i in failed else t.max_n
            angles = (0.0, 0.5 * math.pi) if t.turns else (t.rest_rad,)
            for angle in angles:
                c, s = math.cos(angle), math.sin(angle)
                columns.append((scale * c, scale * s, scale * (t.x_m * s - t.y_m * c)))
        matrix = np.array(columns).T[list(self._axes)]
        inverse = np.zeros((len(columns), 3))
        inverse[:, list(self._axes)] = np.linalg.pinv(matrix)
        self._rows = []
        column = 0
        for t in self._thrusters:
            width = 2 if t.turns else 1
            self._rows.append(
                tuple(
                    (float(r[0] * t.max_n), float(r[1] * t.max_n), float(r[2] * t.max_n))
                    for r in inverse[column : column + width]
                )
            )
            column += width

    def forces_n(self, demand: tuple[float, float, float]) -> list[tuple[float, float]]:
        """The force (x, y) of each thruster in N, in body axes; for a fixed one (its force, 0). `demand`: (surge N,
        sway N, yaw Nm)."""
        x, y, n = demand
        result = []
        for rows in self._rows:
            a = rows[0]
            first = a[0] * x + a[1] * y + a[2] * n
            if len(rows) == 1:
                result.append((first, 0.0))
            else:
                b = rows[1]
                result.append((first, b[0] * x + b[1] * y + b[2] * n))
        return result
