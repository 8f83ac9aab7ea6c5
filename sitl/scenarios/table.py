"""The thesis's law of dynamic positioning and the companion's, on the same seeds, as a Markdown table."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sitl.scenarios.rig import Composer
from sitl.scenarios.scenario import Scenario, run, run_folder

_COLUMNS = ("north_max_m", "east_max_m", "heading_max_deg", "iae", "iadc", "energy_full_power_s")
_HEAD = "| vessel | conditions | law | north m | east m | heading ° | IAE | IADC | energy s |"


@dataclass(frozen=True, slots=True)
class TableRow:
    """One line of the table: its settings. `spread`: the model error; its sign alternates with the seed."""

    vessel: str
    text: str
    changes: Mapping[str, str]
    spread: float = 0.0


def _both(vessel: str, text: str, changes: Mapping[str, str], spread: float = 0.0) -> list[TableRow]:
    """A row for each law. The thesis's law uses no model, so a model error does not affect it."""
    return [
        TableRow(vessel, text, {**changes, "law": "thesis"}),
        TableRow(vessel, text, {**changes, "law": "companion"}, spread),
    ]


ROWS: tuple[TableRow, ...] = (
    *_both("cybership2", "2 m box, 1.5 N from north", {}),
    *(
        row
        for wind in ("0", "2", "3")
        for row in _both("revolt", f"5 m box, wind {wind} m/s, model ±20 %", {"wind": wind}, 0.2)
    ),
    TableRow("revolt", "the same, wind 3 m/s, model ±50 %", {"wind": "3", "law": "companion"}, 0.5),
    TableRow("revolt", "wind 3 m/s, feed-forward as printed", {"wind": "3", "law": "thesis", "feedforward": "thesis"}),
    TableRow(
        "revolt", "wind 3 m/s, feed-forward scaled at sea", {"wind": "3", "law": "thesis", "feedforward": "tuned"}
    ),
    TableRow(
        "revolt", "wind 3 m/s, unconstrained allocation", {"wind": "3", "law": "thesis", "allocation": "unconstrained"}
    ),
    TableRow("revolt", "wind 3 m/s, rotating bow", {"wind": "3", "law": "thesis", "bow": "rotating"}),
)


def lines(
    scenario: Scenario, compose: Composer, seeds: int, rows: Sequence[TableRow] = ROWS, keep: Path | None = None
) -> Iterator[str]:
    """Header, then each row when its runs are done: largest errors of all seeds, means of the rest. `keep`: the folder
    in which the runs' logs stay."""
    yield _HEAD
    yield "|---|---|---|" + "---:|" * len(_COLUMNS)
    for row in rows:
        runs = [sailed(scenario, compose, row, seed, keep) for seed in range(seeds)]
        cells = []
        for column in _COLUMNS:
            values = [metrics[column] for metrics in runs]
            value = max(values) if column.endswith(("_m", "_deg")) else sum(values) / len(values)
            cells.append(f"{value:.2f}" if value < 10.0 else f"{value:.0f}")
        yield f"| {row.vessel} | {row.text} | {row.changes['law']} | {' | '.join(cells)} |"


def count(seeds: int, rows: Sequence[TableRow] = ROWS) -> int:
    """How many runs `lines` makes."""
    return len(rows) * seeds


def sailed(
    scenario: Scenario, compose: Composer, row: TableRow, seed: int, keep: Path | None = None
) -> Mapping[str, float]:
    """Metrics of one run. Raises RuntimeError where it could not be finished."""
    changes = dict(row.changes)
    if row.spread:
        changes["model_error"] = f"{row.spread if seed % 2 else -row.spread:g}"
    with tempfile.TemporaryDirectory() as temporary:
        folder = (
            Path(temporary)
            if keep is None
            else run_folder(keep, f"{row.vessel}, {row.text}, {row.changes['law']}", seed)
        )
        outcome = run(scenario, compose, folder, seed, row.vessel, changes)
    if outcome.error:
        raise RuntimeError(f"{row.vessel}, {row.text}, seed {seed}: {outcome.error}")
    return outcome.metrics
