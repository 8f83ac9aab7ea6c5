"""The figures of `consistency` as a file holds them, and as lines for people."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from sitl.evaluate.consistency import Case, Run, all_innovations, spread, verdicts
from sitl.evaluate.normalised import shown

Figures = Mapping[str, Any]


def figures(case: Case, runs: Sequence[Run]) -> Figures:
    """Of one case: its verdicts by kind and part, RMS errors with RMS sigmas, and the mean of all innovations."""
    return {
        "faults": list(case.faults),
        "instants_s": list(case.instants_s),
        "runs": len(runs),
        "kinds": {
            kind: {part: shown(verdict) for part, verdict in parts.items()} for kind, parts in verdicts(runs).items()
        },
        "spread": {part: [[round(x, 6) for x in pair] for pair in pairs] for part, pairs in spread(runs).items()},
        "innovations": {sense: round(mean, 4) for sense, mean in all_innovations(runs).items()},
    }


def lines(cases: Mapping[str, Figures]) -> Iterator[str]:
    """A block a case: a line a figure with its mean, its band and its means at the instants, then the errors."""
    for name, found in cases.items():
        faults = f", {', '.join(found['faults'])}" if found["faults"] else ""
        yield f"{name}{faults}, {found['runs']} seeds, at {' '.join(f'{t_s:g}' for t_s in found['instants_s'])} s"
        for kind, parts in found["kinds"].items():
            for part, verdict in parts.items():
                yield _line(kind, part, verdict)
        for part, pairs in found["spread"].items():
            yield f"  {part}: RMS error (sigma) {'  '.join(_pair(part, *pair) for pair in pairs)}"
        for sense, mean in found["innovations"].items():
            yield f"  NIS of all measurements, {sense}: {mean:.3f}"


def _line(kind: str, part: str, verdict: Mapping[str, Any]) -> str:
    low, high = verdict["band"]
    means = " ".join(f"{mean:.2f}" for mean in verdict["means"])
    inside = len(verdict["means"]) - verdict["outside"]
    return (
        f"  {kind} {part:14} {verdict['mean']:6.2f} ± {verdict['half']:.2f}, {inside} of {len(verdict['means'])} in "
        f"{low:.2f} to {high:.2f}: {verdict['word']} [{means}]"
    )


def _pair(part: str, error: float, sigma: float) -> str:
    if part == "heading":
        return f"{math.degrees(error):.3f}° ({math.degrees(sigma):.3f}°)"
    return f"{error:.4f} ({sigma:.4f})"
