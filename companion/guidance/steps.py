"""A piecewise linear line over places at even steps, or at others where even ones would be too many."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Steps:
    """Growing places, of a length or of time. It never changes. `step`: between two of them; None: they are uneven."""

    def __init__(self, places: Floats, step: float | None) -> None:
        self.places, self.step = places, step

    def integral(self, values: Floats, low: Floats, high: Floats) -> Floats:
        """Exact integral of the piecewise linear `values` from `low` to `high`, neither beyond the ends."""
        places, count = self.places, len(self.places)
        steps = np.diff(places) if self.step is None else np.full(count - 1, self.step)
        whole = np.concatenate(([0.0], np.cumsum(0.5 * steps * (values[1:] + values[:-1]))))

        def up_to(at: Floats) -> Floats:
            i = self._index(at)
            x = at - places[i]
            result: Floats = whole[i] + x * (values[i] + 0.5 * x * (values[i + 1] - values[i]) / steps[i])
            return result

        return up_to(high) - up_to(low)

    def _index(self, at: Floats) -> NDArray[np.intp]:
        """Of the places at or before those, never the last."""
        if self.step is None:
            found = np.searchsorted(self.places, at, side="right") - 1
        else:
            found = ((at - self.places[0]) / self.step).astype(np.intp)
        return np.clip(found, 0, len(self.places) - 2)
