"""What a report says of rows: failures, worst runs, pairs."""

from dataclasses import replace
from pathlib import Path

import pytest

from sitl.sweep.statistics import adjusted
from sitl.sweep.summary import compared, compared_by, summaries, values_of
from tests.unit.sitl.sweep.made import rows


def test_a_point_has_its_failures_and_its_worst_runs(tmp_path: Path) -> None:
    (one,) = summaries(rows(8, tmp_path))
    assert (one.point, one.count, one.failures) == ("hold revolt wind=2", 8, 2)
    assert [row.seed for row in one.worst] == [4, 3, 7], "without a result, failed, least margin"
    (position, _) = one.distributions
    assert (len(position.values), position.largest.seed, position.least, position.most) == (
        7,
        7,
        0.5,
        pytest.approx(1.2),
    )


def test_a_sweep_against_itself_differs_in_nothing(tmp_path: Path) -> None:
    made = rows(8, tmp_path)
    (one,) = compared(made, made)
    assert (one.failures.count, one.failures.both, one.failures.p, one.unpaired) == (8, 2, 1.0, 0)
    assert [metric.adjusted for metric in one.metrics] == [1.0, 1.0]


def test_pairs_have_the_same_seed(tmp_path: Path) -> None:
    made = rows(12, tmp_path)
    better = [
        replace(row, ok=True, metrics={name: value - 0.01 for name, value in row.metrics.items()}) for row in made[:10]
    ]
    (one,) = compared(made, list(reversed(better)))
    assert (one.failures.count, one.failures.only_first, one.failures.only_second, one.unpaired) == (10, 2, 0, 2)
    assert one.metrics[0].median.value == pytest.approx(-0.01)
    assert one.metrics[0].adjusted < 0.05


def test_a_run_with_a_fault_is_no_pair_of_one_without_it(tmp_path: Path) -> None:
    """As a hunt has them: the same seed and settings, with and without a fault."""
    made = rows(8, tmp_path)
    faulty = [replace(row, faults=("gnss_lost@9+1",), ok=False) for row in made]
    (one,) = compared([*made, *faulty], [*faulty, *made])
    assert (one.failures.count, one.failures.only_first, one.failures.only_second) == (16, 0, 0)


def test_two_laws_of_one_sweep_are_paired(tmp_path: Path) -> None:
    made = rows(8, tmp_path)
    both = [
        replace(row, settings={**row.settings, "law": law}, point=f"{row.point} law={law}")
        for row in made
        for law in ("companion", "thesis")
    ]
    assert values_of(both, "law") == ["companion", "thesis"]
    of = {law: [row for row in both if row.settings["law"] == law] for law in ("companion", "thesis")}
    assert compared(of["companion"], of["thesis"]) == []
    (one,) = compared(of["companion"], of["thesis"], "law")
    assert (one.point, one.failures.count) == ("hold revolt wind=2", 8)


def test_every_value_of_a_setting_counts_among_the_tests_of_the_page(tmp_path: Path) -> None:
    """Each of four values against the first was adjusted as if there were no others."""
    made = rows(12, tmp_path)
    every = [
        replace(
            row,
            settings={**row.settings, "law": law},
            point=f"{row.point} law={law}",
            metrics={"iae": row.seed + (0.1 * (1 + row.seed % 5) if law == "a" else 0.2 * (-1) ** row.seed)},
        )
        for row in made
        for law in ("first", "a", "b", "c", "d")
    ]
    found = compared_by(every, "law")
    assert list(found) == [(law, "first") for law in "abcd"]
    metrics = [metric for comparisons in found.values() for one in comparisons for metric in one.metrics]
    assert [metric.adjusted for metric in metrics] == pytest.approx(adjusted([metric.p for metric in metrics]))
    assert metrics[0].adjusted > metrics[0].p
