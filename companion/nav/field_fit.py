"""Hard and soft iron from turns: an ellipsoid, or a flat circle where the boat did not tilt.

Model: mag_matrix · (measured − mag_offset), levelled, has a horizontal length equal to the cosine of the dip, and the
sine as its vertical part. The World Magnetic Model gives the dip of the place. So the field has length 1 at any
attitude, and the horizontal part, which gives the heading, keeps its weight.

The matrix is symmetric. A rotation of the whole sensor about its vertical axis cannot be seen; `heading_offset_deg`
corrects it. Least squares by scipy with a soft L1 loss, since waves and passing iron are not noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SECTORS = 24
_OUTLIER = 0.02  # share of the field above which a residual has less weight
_DETERMINED = (
    0.01  # one sigma of vertical offset and scale, as shares of the field, up to which they count as determined
)
_VERTICAL_FLAT = 0.1  # weight of the vertical part where only its mean can be fitted
_NEIGHBOURS = 10.0  # neighbouring samples that share one error
_MOST_STEPS = 50  # of the whole ellipsoid; where the samples determine it, it takes fewer than 20


@dataclass(frozen=True, slots=True)
class FieldFit:
    """`offset`: in the magnetometer's unit; `matrix`: 3×3, to a field of length 1.

    `flat`: only the horizontal part was fitted; the vertical part is from the model of the Earth's field with the mean
    scale of the others. `deviation_rad`, one per sector of heading: residual of the horizontal length, as the heading
    error of that size. `residual`: RMS error of the strength, as a share; `before`: the same of the measured field.
    """

    offset: Array
    matrix: Array
    flat: bool
    residual: float
    before: float
    deviation_rad: Array
    deviation_before_rad: Array
    offset_sigma: float  # of the worst axis, as a share of the field

    def before_turn(self, turn: Sequence[float]) -> FieldFit:
        """The fit for a field that was turned by `turn`, a 3×3 rotation row by row, before it was fitted."""
        matrix = np.reshape(turn, (3, 3))
        return replace(self, offset=matrix.T @ self.offset, matrix=matrix.T @ self.matrix @ matrix)


def fit(field: Array, tilt: Array, dip_rad: float) -> FieldFit:
    """Fit `field`, N×3 as measured, with `tilt`, N×2 (roll, pitch in rad) at the same times. Raises ValueError where
    there is nothing to fit."""
    from scipy.optimize import least_squares

    if len(field) < 100 or not np.ptp(field, axis=0).max() > 0.0:
        raise ValueError("too few samples of the magnetic field")
    level, vertical = math.cos(dip_rad), math.sin(dip_rad)
    down = np.stack(
        [-np.sin(tilt[:, 1]), np.sin(tilt[:, 0]) * np.cos(tilt[:, 1]), np.cos(tilt[:, 0]) * np.cos(tilt[:, 1])], axis=1
    )

    def residuals(flat: bool) -> Any:
        def of(p: Array) -> Array:
            true = (field - p[:3]) @ _matrix(p[3:], flat)
            found = (true * down).sum(axis=1)
            rest = np.sqrt(np.maximum((true * true).sum(axis=1) - found * found, 1e-12))
            return np.concatenate([rest - level, (_VERTICAL_FLAT if flat else 1.0) * (found - vertical)])

        return of

    start = _start(field, dip_rad)
    flat_fit = least_squares(residuals(True), start[:6], loss="soft_l1", f_scale=_OUTLIER, x_scale="jac")
    a, b, c = flat_fit.x[3:]
    begin = np.array([*flat_fit.x[:3], a, b, 0.0, c, 0.0, 0.5 * (a + c)])
    full_fit = least_squares(
        residuals(False), begin, loss="soft_l1", f_scale=_OUTLIER, x_scale="jac", max_nfev=_MOST_STEPS
    )
    sigma = _sigmas(full_fit, len(field))
    scale = full_fit.x[8]
    determined = full_fit.success and sigma[2] * scale < _DETERMINED and sigma[8] / scale < _DETERMINED
    found, flat = (full_fit, False) if determined else (flat_fit, True)
    if flat:
        sigma = _sigmas(flat_fit, len(field))
    matrix = _matrix(found.x[3:], flat)
    true = (field - found.x[:3]) @ matrix
    raw = field / np.median(np.linalg.norm(field, axis=1))
    return FieldFit(
        found.x[:3],
        matrix,
        flat,
        float(np.sqrt(np.mean((np.linalg.norm(true, axis=1) - 1.0) ** 2))),
        float(np.std(np.linalg.norm(raw, axis=1))),
        _deviation(true, tilt, level),
        _deviation(raw, tilt, level),
        float(np.max(sigma[:3]) * scale),
    )


def headings(true: Array, tilt: Array) -> tuple[Array, Array]:
    """(magnetic heading in rad, horizontal length) of fields in body axes."""
    (cr, cp), (sr, sp) = np.cos(tilt).T, np.sin(tilt).T
    x, y, z = true.T
    ahead, aside = cp * x + sp * (sr * y + cr * z), cr * y - sr * z
    return np.arctan2(-aside, ahead), np.hypot(ahead, aside)


def sectors_seen(heading: Array) -> NDArray[np.intp]:
    """Number of samples in each sector of heading, from magnetic north on."""
    return np.bincount(
        (np.mod(heading, 2.0 * math.pi) * SECTORS / (2.0 * math.pi)).astype(int) % SECTORS, minlength=SECTORS
    )


def _deviation(true: Array, tilt: Array, level: float) -> Array:
    heading, length = headings(true, tilt)
    at = (np.mod(heading, 2.0 * math.pi) * SECTORS / (2.0 * math.pi)).astype(int) % SECTORS
    return np.array([np.mean(length[at == k]) / level - 1.0 if np.any(at == k) else math.nan for k in range(SECTORS)])


def _matrix(p: Array, flat: bool) -> Array:
    if flat:
        a, b, c = p
        return np.array([[a, b, 0.0], [b, c, 0.0], [0.0, 0.0, 0.5 * (a + c)]])
    a, b, c, d, e, f = p
    return np.array([[a, b, c], [b, d, e], [c, e, f]])


def _start(field: Array, dip_rad: float) -> Array:
    """The middle of the circle, and the scale from its radius."""
    low, high = np.percentile(field, 2, axis=0), np.percentile(field, 98, axis=0)
    middle = 0.5 * (low + high)
    scale = math.cos(dip_rad) / max(float(np.max(0.5 * (high - low)[:2])), 1e-12)
    return np.array([middle[0], middle[1], middle[2] - math.sin(dip_rad) / scale, scale, 0.0, scale])


def _sigmas(found: Any, samples: int) -> Array:
    """One sigma of each parameter; infinite where the samples do not determine it."""
    variance = 2.0 * found.cost / max(2 * samples - len(found.x), 1) * _NEIGHBOURS
    information = found.jac.T @ found.jac
    scale = np.sqrt(np.diag(information))
    if not np.all(scale > 0.0):
        return np.full(len(found.x), math.inf)
    correlation = information / np.outer(scale, scale)
    if np.linalg.cond(correlation) > 1e12:
        return np.full(len(found.x), math.inf)
    return np.asarray(np.sqrt(variance * np.diag(np.linalg.inv(correlation))) / scale)
