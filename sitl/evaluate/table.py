"""The figures of several runs as one Markdown table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from sitl.evaluate.figures import Figure


def table(runs: Mapping[str, Sequence[Figure]]) -> Iterator[str]:
    """A row a figure, a column a run, and for two or more runs the last divided by the first: above 1 the first is
    better. Every run has the same figures."""
    labels = list(runs)
    ratio = len(labels) > 1
    yield f"| figure | {' | '.join(labels)} |{f' {labels[-1]} / {labels[0]} |' if ratio else ''}"
    yield f"|---|{'---:|' * (len(labels) + ratio)}"
    for figures in zip(*runs.values(), strict=True):
        cells = " | ".join(f"{figure.value:.3g}" for figure in figures)
        yield f"| {figures[0].name}, {figures[0].unit} | {cells} |{_ratio(figures) if ratio else ''}"


def _ratio(figures: Sequence[Figure]) -> str:
    first, last = figures[0].value, figures[-1].value
    return f" {last / first:.2f} |" if first > 0.0 else " – |"
