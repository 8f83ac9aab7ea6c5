"""How far a log leaves the quantities of a fit open: their covariance.

Innovations that are white tell it by their slopes. But equations lack something, and what they lack lasts as long as a
manoeuvre. So the log is also asked in parts of half a minute: how far the result moves when each is left out (the
jackknife of Quenouille and Tukey, linear about the result). The greater of both counts. It is widened by `WIDER`, and
beside it stands an error of `UNMODELLED` of the thrust that lasts as long as the log.

Both numbers were chosen on hidden hulls of other seeds than those that the documentation reports.
"""

from __future__ import annotations

import itertools

import numpy as np

from companion.analysis.disturbance import Array, Stretches
from companion.analysis.force_balance import equivalents
from companion.analysis.hull_search import Search

WIDER = 1.5
UNMODELLED = 0.02
_PART_S = 30.0


def covariance(search: Search) -> Array:
    """(quantities, quantities) of `search.names`, in their units. Needs the slopes of where the search is."""
    innovations, slopes = search.innovations()
    band = search.model.band
    spread = scattered(innovations, slopes, parts_of(band.stretches, band.period_s))
    lasting = equivalents(search.model, search.values, search.names, UNMODELLED)
    return np.asarray(WIDER**2 * spread * np.outer(search.doubts, search.doubts) + np.diag(lasting**2))


def scattered(innovations: Array, slopes: Array, parts: Stretches) -> Array:
    """Covariance of quantities whose prior is one, for innovations (n, axes) and slopes (n, axes, quantities) where the
    sum of squares is least. `parts`: of the rows."""
    count = slopes.shape[2]
    flat = slopes.reshape(-1, count)
    information = flat.T @ flat + np.eye(count)
    told = np.linalg.inv(information)
    moved = []
    for first, end in parts:
        part = slopes[first:end].reshape(-1, count)
        moved.append(np.linalg.solve(information - part.T @ part, part.T @ innovations[first:end].ravel()))
    by_part = np.stack(moved)
    jackknife = (len(parts) - 1.0) / len(parts) * by_part.T @ by_part + told @ told
    own = np.diag(jackknife)
    wider = np.sqrt(np.maximum(np.diag(told) / own, 1.0))
    return np.asarray(jackknife * np.outer(wider, wider), dtype=np.float64)


def parts_of(stretches: Stretches, period_s: float) -> Stretches:
    """Each stretch in equal parts of about `_PART_S`, (first, end) of its rows."""
    found: list[tuple[int, int]] = []
    for first, end in stretches:
        count = max(1, round((end - first) * period_s / _PART_S))
        edges = np.linspace(first, end, count + 1).astype(int).tolist()
        found += itertools.pairwise(edges)
    return tuple(found)
