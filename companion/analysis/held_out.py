"""How well a model predicts a part of a log that it was not fitted to: velocities over windows, from forces alone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from companion.analysis.hull_model import LAG, HullModel
from companion.analysis.log_reader import Log
from companion.analysis.manoeuvre import Array, Manoeuvre
from companion.analysis.trial_log import Ran

_WINDOW_S = 10.0
_SHARE = 0.25  # of the log that is held out where no trial says which part
AROUND = ("current_", "wind_", "north_n", "east_n", "aside_", "twist_", "heading_", "antenna_")
"""Beginnings of quantities that are no property of the hull."""
HELD_OUT = ("zig-zag 20/20", "turning circle port", "spin 80%", "surge +60% coast", "sway 90%")
"""Manoeuvres that are not fitted to: each motion is in another one, too."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """RMS error of the velocities predicted over windows of `_WINDOW_S`, before and after: surge m/s, sway m/s, yaw
    rate rad/s. `before`, `after`: the whole, each axis over the RMS of its motion."""

    axes_before: tuple[float, float, float]
    axes_after: tuple[float, float, float]
    before: float
    after: float

    @property
    def ratio(self) -> float:
        """Error after over before."""
        return self.after / self.before if self.before > 0.0 else math.inf


def split(manoeuvre: Manoeuvre, ran: Sequence[Ran]) -> tuple[Manoeuvre, Manoeuvre]:
    """(to fit, to predict): the same arrays, with other stretches. Where no manoeuvre held out has a window, the last
    part of the log is."""
    named = [(one.from_s, one.to_s) for one in ran if one.name in HELD_OUT]
    fitted, held_out = _parted(manoeuvre, named)
    if held_out.stretches:
        return fitted, held_out
    t_s = manoeuvre.t_s
    return _parted(manoeuvre, [(float(t_s[0] + (1.0 - _SHARE) * (t_s[-1] - t_s[0])), float(t_s[-1]) + 1.0)])


def _parted(manoeuvre: Manoeuvre, spans: Sequence[tuple[float, float]]) -> tuple[Manoeuvre, Manoeuvre]:
    """(what is outside the spans, windows inside)."""
    outside: list[tuple[int, int]] = []
    inside: list[tuple[int, int]] = []
    for first, end in manoeuvre.stretches:
        held = np.zeros(end - first, dtype=bool)
        for from_s, to_s in spans:
            held |= (manoeuvre.t_s[first:end] >= from_s) & (manoeuvre.t_s[first:end] < to_s)
        edges = [0, *(np.flatnonzero(np.diff(held)) + 1).tolist(), len(held)]
        for a, b in itertools.pairwise(edges):
            (inside if held[a] else outside).append((first + a, first + b))
    least = round(2.0 / manoeuvre.period_s)
    return (
        replace(manoeuvre, stretches=tuple((a, b) for a, b in outside if b - a >= least)),
        replace(manoeuvre, stretches=_windows(inside, manoeuvre.period_s)),
    )


def _windows(stretches: Sequence[tuple[int, int]], period_s: float) -> tuple[tuple[int, int], ...]:
    size = round(_WINDOW_S / period_s)
    return tuple((a, a + size) for first, end in stretches for a in range(first, end - size + 1, size))


def prediction(
    log: Log, held_out: Manoeuvre, before: Mapping[str, float], after: Mapping[str, float]
) -> Prediction | None:
    """Errors of both sets of quantities over the windows; None without a window. Both get the current, the weather and
    the lag of `after`: what is compared is what an overlay has."""
    if not held_out.stretches:
        return None
    model = HullModel(log, held_out, mounting=True)
    around = {name: after[name] for name in after if name.startswith((*AROUND, LAG))}
    rows = np.concatenate([np.arange(a, b) for a, b in held_out.stretches])
    measured = held_out.velocity[rows]
    size = np.maximum(np.sqrt((measured**2).mean(axis=0)), (0.02, 0.02, 0.01))

    def errors(values: Mapping[str, float]) -> Array:
        rest: Array = model.simulate(values)[rows] - measured
        return np.asarray(np.sqrt((rest**2).mean(axis=0)), dtype=np.float64)

    old, new = errors({**before, **around}), errors(after)
    return Prediction(
        (float(old[0]), float(old[1]), float(old[2])),
        (float(new[0]), float(new[1]), float(new[2])),
        float(np.sqrt(((old / size) ** 2).mean())),
        float(np.sqrt(((new / size) ** 2).mean())),
    )
