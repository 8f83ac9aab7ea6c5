"""`companion scenario run`: what it says of a run."""

from __future__ import annotations

import pytest

from companion.cli.scenario import print_result
from sitl.scenarios import lying_senses
from sitl.scenarios.measure import Check
from sitl.scenarios.scenario import ScenarioResult


@pytest.mark.parametrize("checks", [(), (Check("found after", 0.5, 1.0, "s"),)])
def test_a_run_of_which_nothing_is_asked_says_so(checks: tuple[Check, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert "velocity_off" not in lying_senses.PROMISED, "of such a lie only figures are told"
    print_result(ScenarioResult("lying_senses", True, {"found_s": 0.5}, checks, None))
    assert ("no check: this scenario asks nothing of such a run" in capsys.readouterr().out) == (not checks)
