"""A sensor lies while the boat holds: it is found in time, and the boat stays where it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.lying_senses import PROMISED
from sitl.scenarios.scenario import run
from tests.scenarios.seeds import seeds


@pytest.mark.parametrize("seed", seeds(1, 20))
@pytest.mark.parametrize("lie", [*PROMISED, "gnss_jump=5", "gnss_jump=50"])
def test_a_lie_is_found_in_time(tmp_path: Path, lie: str, seed: int) -> None:
    outcome = run(SCENARIOS["lying_senses"], LockstepRig, tmp_path, seed=100 + seed, changes={"lie": lie})
    assert not outcome.error, outcome.error
    assert outcome.checks and outcome.ok, [check.row() for check in outcome.checks if not check.ok]
