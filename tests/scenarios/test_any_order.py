"""Orders in any order, judged by safety margins, refusals without a reason, and where the boat lies at the end."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.measure import read_events
from sitl.scenarios.orders import CHOICES
from sitl.scenarios.scenario import ScenarioError, run
from tests.scenarios.seeds import seeds


def sail(folder: Path, vessel: str, seed: int, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["any_order"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    failed = [check.row() for check in outcome.checks if not check.ok]
    unsafe = [margin.row() for margin in outcome.margins if margin.value <= 0.0]
    assert outcome.ok, f"{outcome.error or ''} {failed} {unsafe}"
    return dict(outcome.metrics)


@pytest.mark.parametrize(("vessel", "end"), [("revolt", "150"), ("blueboat", "90")])
def test_a_short_watch(tmp_path: Path, vessel: str, end: str) -> None:
    """`end`: it comes home by RTL, and lies there for half a minute."""
    assert sail(tmp_path, vessel, 1, time="150", end=end)["orders"] >= 5.0
    assert any(event.name == "rtl_arrived" for event in read_events(tmp_path))
    table = (tmp_path / "orders.csv").read_text(encoding="utf-8").splitlines()
    assert table[0] == "t_s,result,order,said" and len(table) >= 6


def test_an_order_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="orders=fly: some of hold, "):
        sail(tmp_path, "revolt", 0, orders="hold,fly")


@pytest.mark.sweep
def test_circles_that_meet_stones(tmp_path: Path) -> None:
    """An Otter that a stone had stopped on its circle was carried onto it by the wind."""
    sail(tmp_path, "otter", 714030, orders="orbit", stones="8", time="260")


@pytest.mark.sweep
def test_a_jet_that_a_fence_turns_holds_where_it_has_come_round(tmp_path: Path) -> None:
    """A jet of 4 m, paused at speed, turned at once, and then sailed 160 m to where it would have coasted to."""
    sail(tmp_path, "rescuerunner", 1, orders="mission,speed,pause", time="200")


@pytest.mark.sweep
@pytest.mark.parametrize("order", CHOICES)
def test_each_order_alone(tmp_path: Path, order: str) -> None:
    sail(tmp_path, "aboat", 2, orders=order, time="200")


@pytest.mark.sweep
@pytest.mark.parametrize("seed", seeds(0, 6))
@pytest.mark.parametrize(
    "vessel", ["revolt", "aboat", "cybership2", "rescuerunner", "blueboat", "heron", "otter", "wamv16"]
)
def test_every_vessel_sweep(tmp_path: Path, vessel: str, seed: int) -> None:
    sail(tmp_path, vessel, seed)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", seeds(0, 6))
@pytest.mark.parametrize("vessel", ["aboat", "heron", "otter", "wamv16"])
def test_among_stones_sweep(tmp_path: Path, vessel: str, seed: int) -> None:
    sail(tmp_path, vessel, seed, stones="8")
