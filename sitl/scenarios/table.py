"""The thesis's law beside the companion's, on the same seeds, as a Markdown table."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sitl.scenarios.rig import Composer
from sitl.scenarios.scenario import Scenario, run

_COLUMNS = ("north_max_m", "east_max_m", "heading_max_deg", "iae", "iadc", "energy_full_power_s")
_HEAD = "| vessel | conditions | law | north m | east m | heading ° | IAE | IADC | energy s |"


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table: what is set. `spread`: the model error's sign goes with the seed, so that both are sailed."""

    vessel: str
    text: str
    changes: Mapping[str, str]
    spread: float = 0.0


def _both(vessel: str, text: str, changes: Mapping[str, str], spread: float = 0.0) -> list[Row]:
    """The thesis's law knows no model, so the error does not matter to it."""
    return [Row(vessel, text, {**changes, "law": "thesis"}), Row(vessel, text, {**changes, "law": "companion"}, spread)]


ROWS: tuple[Row, ...] = (
    *_both("cybership2", "2 m box, 1.5 N from north", {}),
    *(row for wind in ("0", "2", "3") for row in _both("revolt", f"5 m box, wind {wind} m/s, model ±20 %", {"wind": wind}, 0.2)),
    Row("revolt", "the same, wind 3 m/s, model ±50 %", {"wind": "3", "law": "companion"}, 0.5),
    Row("revolt", "wind 3 m/s, feed-forward as printed", {"wind": "3", "law": "thesis", "feedforward": "thesis"}),
    Row("revolt", "wind 3 m/s, feed-forward scaled at sea", {"wind": "3", "law": "thesis", "feedforward": "tuned"}),
    Row("revolt", "wind 3 m/s, unconstrained allocation", {"wind": "3", "law": "thesis", "allocation": "unconstrained"}),
    Row("revolt", "wind 3 m/s, rotating bow", {"wind": "3", "law": "thesis", "bow": "rotating"}),
)


def lines(scenario: Scenario, compose: Composer, seeds: int, rows: Sequence[Row] = ROWS) -> Iterator[str]:
    """Header and rows as they are sailed: largest errors of all seeds, means of the rest."""
    yield _HEAD
    yield "|---|---|---|" + "---:|" * len(_COLUMNS)
    for row in rows:
        runs = [sailed(scenario, compose, row, seed) for seed in range(seeds)]
        cells = []
        for column in _COLUMNS:
            values = [metrics[column] for metrics in runs]
            value = max(values) if column.endswith(("_m", "_deg")) else sum(values) / len(values)
            cells.append(f"{value:.2f}" if value < 10.0 else f"{value:.0f}")
        yield f"| {row.vessel} | {row.text} | {row.changes['law']} | {' | '.join(cells)} |"


def sailed(scenario: Scenario, compose: Composer, row: Row, seed: int) -> Mapping[str, float]:
    """Metrics of one run. Raises RuntimeError for one that could not be finished."""
    changes = dict(row.changes)
    if row.spread:
        changes["model_error"] = f"{row.spread if seed % 2 else -row.spread:g}"
    with tempfile.TemporaryDirectory() as folder:
        outcome = run(scenario, compose, Path(folder), seed, row.vessel, changes)
    if outcome.error:
        raise RuntimeError(f"{row.vessel}, {row.text}, seed {seed}: {outcome.error}")
    return outcome.metrics
