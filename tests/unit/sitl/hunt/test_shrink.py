"""The smallest case of a violation."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from sitl.hunt.search import fault_names
from sitl.hunt.shrink import shrunk, smaller
from sitl.scenarios import SCENARIOS
from sitl.sweep.plan import Run
from tests.unit.sitl.hunt.made import margin_m

DEFAULTS = SCENARIOS["hold"].defaults
LARGE = Run(
    "hold",
    "revolt",
    7,
    (("current", "0.17@215"), ("model_error", "-0.28"), ("waves", "0.08@35"), ("wind", "6.7@125")),
    "hold revolt",
    {},
    ("gnss_lost@173+9", "thruster_bow_stuck@94+211"),
)


def test_what_does_not_matter_goes_and_the_rest_is_small_and_round() -> None:
    asked: list[Run] = []

    def lasts(runs: Sequence[Run]) -> list[bool]:
        asked.extend(runs)
        return [margin_m(run) < 1.0 for run in runs]

    least = shrunk(LARGE, DEFAULTS, lasts, 2)
    assert least.command == (
        "companion scenario run hold --vessel revolt --seed 0 --set wind=4@135 --fault gnss_lost@180+1"
    ) or (fault_names(least) == {"gnss_lost"} and margin_m(least) < 1.0 and "model_error" not in dict(least.settings))
    assert least.seed == 0 and len(least.faults) == 1 and [key for key, _ in least.settings] == ["wind"]
    assert len(asked) <= 60


def test_a_violation_that_nothing_smaller_has_stays_as_it_is() -> None:
    assert shrunk(LARGE, DEFAULTS, lambda runs: [run == LARGE for run in runs], 2) == LARGE


def test_a_calm_is_asked_for_where_the_scenario_has_wind() -> None:
    commands = [run.command for run in smaller(LARGE, DEFAULTS)]
    assert any("--set wind= " in command or command.endswith("--set wind=") for command in commands)


@given(
    st.lists(st.sampled_from(["gnss_lost@7+3", "imu_lost@31+20", "rtk_lost@90+60"]), max_size=3, unique=True),
    st.floats(0.1, 8.0),
    st.integers(0, 71),
    st.integers(0, 9),
)
def test_it_always_ends(faults: list[str], wind_mps: float, direction: int, seed: int) -> None:
    """Where every candidate has the violation."""
    settings = (("wind", f"{wind_mps:.1f}@{5 * direction}"),)
    run = Run("hold", "revolt", seed, settings, "hold revolt", {}, tuple(sorted(faults)))
    least = shrunk(run, DEFAULTS, lambda runs: [True for _ in runs], 1)
    assert not least.faults and dict(least.settings)["wind"] == "" and least.seed == 0
