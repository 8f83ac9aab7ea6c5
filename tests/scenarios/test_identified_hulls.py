"""Stated intervals have the truth: see `identified_hulls`. `make scenarios` sails all."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scenarios.identified_hulls import study, table


@pytest.mark.sweep
def test_nine_of_ten_intervals_have_the_truth(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = [study(seed, tmp_path / f"seed{seed}", track=False) for seed in range(200, 250)]
    with capsys.disabled():
        print(f"\n{table(found)}")
    stated = [one for boat in found for one in boat.quantities if one.interval is not None]
    assert sum(one.covered for one in stated) >= 0.9 * len(stated)
    assert len(stated) >= 0.6 * sum(len(boat.quantities) for boat in found)
    assert sum(boat.predicted[1] < boat.predicted[0] for boat in found) >= 0.9 * len(found)
