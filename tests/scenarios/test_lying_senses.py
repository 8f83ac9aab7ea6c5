"""A sensor lies while the boat holds: it is found in time, and the boat stays where it is."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.control.wind import wind_force
from sitl.fault_matrix.branch import branch
from sitl.scenarios import SCENARIOS
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.lying_senses import PROMISED, lie, settle
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import run
from tests.scenarios.seeds import seeds

BROKEN = "broken.json"
WATCH = "20"  # seconds: the slowest is found after 4, and none of those with a limit moves on after 10
FIRST, *OTHERS = (*PROMISED, "gnss_jump=5", "gnss_jump=50")


def found(station: GroundStation, told: str, folder: Path) -> None:
    """The lie, in a copy of the process that writes into `folder`, and what is not as promised as a file there."""
    asked = lie(station, {"lie": told, "watch": WATCH, "gnss": "rtk"})
    station.rig.close()
    _, checks = SCENARIOS["lying_senses"].measure(folder, asked, {"lie": told})
    broken = [check.row() for check in checks if not check.ok] if checks else ["nothing is promised"]
    (folder / BROKEN).write_text(json.dumps(broken), encoding="utf-8")


@pytest.mark.parametrize("seed", seeds(1, 20))
def test_each_of_the_other_lies_is_found_in_time(tmp_path: Path, seed: int) -> None:
    """They go on from the same settled boat."""
    settled = tmp_path / "settled"
    station = GroundStation(LockstepRig(Conditions("revolt", seed=100 + seed, wind="3", gnss="rtk"), settled))
    settle(station)
    broken: dict[str, object] = {}
    for told in OTHERS:
        done = branch(settled, tmp_path / told, functools.partial(found, station, told, tmp_path / told))
        broken[told] = json.loads((tmp_path / told / BROKEN).read_text(encoding="utf-8")) if done else "it broke off"
    station.rig.close()
    assert not any(broken.values()), {told: what for told, what in broken.items() if what}


@pytest.mark.parametrize("seed", seeds(1, 20))
def test_a_lie_is_found_in_time(tmp_path: Path, seed: int) -> None:
    outcome = run(
        SCENARIOS["lying_senses"], LockstepRig, tmp_path, seed=100 + seed, changes={"lie": FIRST, "watch": WATCH}
    )
    assert not outcome.error, outcome.error
    assert outcome.checks and outcome.ok, [check.row() for check in outcome.checks if not check.ok]


@pytest.mark.parametrize("seed", seeds(0, 10))
@pytest.mark.parametrize("vessel", ["aboat", "rescuerunner"])
def test_a_compass_that_creeps_is_found_before_it_is_10_degrees_off(tmp_path: Path, vessel: str, seed: int) -> None:
    lie = {"lie": "heading_creep=1"}
    outcome = run(SCENARIOS["lying_senses"], LockstepRig, tmp_path, seed=5000 + seed, vessel=vessel, changes=lie)
    assert not outcome.error, outcome.error
    assert outcome.metrics["found_s"] < 10.0 and outcome.metrics["heading_error_deg"] < 10.0, outcome.metrics


@pytest.mark.parametrize("seed", seeds(1, 5))
def test_a_spoof_that_was_found_is_not_believed_again(tmp_path: Path, seed: int) -> None:
    """The boat is carried off in the first seconds, and drifts then. With SBAS so slow a one is not found in all runs."""
    changes = {"lie": "gnss_spoof=0.3", "gnss": "sbas", "wind": "2"}
    outcome = run(SCENARIOS["lying_senses"], LockstepRig, tmp_path, seed=5000 + seed, vessel="heron", changes=changes)
    assert not outcome.error, outcome.error
    assert outcome.metrics["found_s"] > 60.0 or outcome.metrics["kept_m"] < 9.0, outcome.metrics


@pytest.mark.parametrize("seed", seeds(1, 10))
def test_a_wind_that_repeats_is_said_and_no_longer_fed_forward(tmp_path: Path, seed: int) -> None:
    rig = LockstepRig(Conditions("aboat", seed=5000 + seed, wind="4"), tmp_path / "log")
    station = GroundStation(rig)
    vessel = rig.vessel

    def fed_forward() -> bool:
        tick = vessel.last_tick
        assert tick is not None
        return any(wind_force(rig.config.windage, rig.config.length_m, tick.nav))

    station.hold_at_home(15.0)
    assert fed_forward() and "wind repeats: not used" not in station.texts
    rig.world.add_fault("wind_frozen")
    station.sail(12.5)  # a steady wind may repeat for 10 s, and what is known of it is used for 2 s
    assert "wind repeats: not used" in station.texts and not fed_forward()
    rig.close()
