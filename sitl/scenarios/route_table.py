"""The ÅBOAT thesis's waypoint law and the companion's on its four routes, on the same seeds, as a Markdown table."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from sitl.scenarios.rig import Composer
from sitl.scenarios.scenario import Scenario, run, run_folder

_HEAD = "| route | conditions | law | completed | cross-track RMS m | 95 % m | largest m | time s |"
CONDITIONS: Mapping[str, Mapping[str, str]] = {
    "calm, RTK": {"wind": "", "current": "", "gnss": "rtk"},
    "current 0.3 m/s, wind 6 m/s, RTK": {"wind": "6", "current": "0.3", "gnss": "rtk"},
    "current 0.3 m/s, wind 6 m/s, SBAS": {"wind": "6", "current": "0.3", "gnss": "sbas"},
}
ROUTES = ("1", "2", "3", "4")


def lines(scenario: Scenario, compose: Composer, seeds: int, keep: Path | None = None) -> Iterator[str]:
    """Header, then each row when its runs are done. `keep`: the folder in which the runs' logs stay."""
    yield from head()
    for route in ROUTES:
        for text, conditions in CONDITIONS.items():
            for law in ("thesis", "companion"):
                runs = [
                    _sailed(scenario, compose, {**conditions, "route": route, "law": law}, seed, text, keep)
                    for seed in range(seeds)
                ]
                yield row(route, text, law, runs)


def count(seeds: int) -> int:
    """How many runs `lines` makes."""
    return len(ROUTES) * len(CONDITIONS) * 2 * seeds


def head() -> tuple[str, str]:
    """The two lines of the header."""
    return _HEAD, "|---|---|---|" + "---:|" * 5


def row(route: str, conditions: str, law: str, runs: Sequence[Mapping[str, float]]) -> str:
    """A row: the worst of all runs, and their mean time."""
    worst = (
        max(metrics[name] for metrics in runs)
        for name in ("cross_track_rms_m", "cross_track_95_m", "cross_track_max_m")
    )
    cells = " | ".join(f"{value:.2f}" for value in worst)
    time_s = sum(metrics["time_s"] for metrics in runs) / len(runs)
    completed = sum(metrics["completed"] > 0.0 for metrics in runs)
    return f"| {route} | {conditions} | {law} | {completed} of {len(runs)} | {cells} | {time_s:.0f} |"


def _sailed(
    scenario: Scenario, compose: Composer, changes: Mapping[str, str], seed: int, text: str, keep: Path | None
) -> Mapping[str, float]:
    """Metrics of one run. Raises RuntimeError where it could not be measured."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = (
            Path(temporary)
            if keep is None
            else run_folder(keep, f"route {changes['route']}, {text}, {changes['law']}", seed)
        )
        outcome = run(scenario, compose, folder, seed, changes=changes)
    if outcome.error:
        raise RuntimeError(f"route {changes['route']}, seed {seed}: {outcome.error}")
    return outcome.metrics
