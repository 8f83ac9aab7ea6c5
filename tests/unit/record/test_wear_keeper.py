"""The wear of the thrusters over restarts."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from companion.allocation.wear import Wear
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import ThrusterCommand
from companion.core.decision import TextKind
from companion.record.state_file import StateFile
from companion.record.wear_keeper import WearKeeper, wear_of
from tests.unit.record.ticks import tick

ABOAT = load(find("aboat"))


class Ashore:
    """A state directory, and what was said and warned."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.said: list[str] = []
        self.warned: list[str] = []
        self.saves = 0

    def keeper(self, config: VesselConfig = ABOAT) -> tuple[WearKeeper, StateFile]:
        state = StateFile(self.folder)
        keeper = WearKeeper(config, state, self.say, self.warned.append)
        return keeper, state

    def say(self, now_s: float, kind: TextKind, name: str, text: str) -> None:
        assert kind is TextKind.ROUTINE
        self.said.append(text)

    def kept(self) -> dict[str, dict[str, float]]:
        thrusters: dict[str, dict[str, float]] = json.loads((self.folder / "wear.json").read_text())["thrusters"]
        return thrusters


def sail(keeper: WearKeeper, from_s: float, seconds: float, armed: bool = True, throttle: float = 0.5) -> None:
    for k in range(round(seconds / 0.1)):
        one = tick(from_s + 0.1 * k)
        thrusters = (ThrusterCommand(10.0, throttle, 0.0), ThrusterCommand(0.0, 0.0, 0.0))
        command = replace(one.command, armed=armed, thrusters=thrusters)
        keeper.record(replace(one, status=replace(one.status, armed=armed), command=command))


def test_it_is_written_when_disarmed_and_goes_on_after_a_restart(tmp_path: Path) -> None:
    shore = Ashore(tmp_path)
    keeper, state = shore.keeper()
    sail(keeper, 0.0, 90.0)
    assert not (tmp_path / "wear.json").exists(), "nothing is written under way"
    sail(keeper, 90.0, 1.0, armed=False)
    assert shore.kept()["bow"]["thrust_s"] == pytest.approx(90.0)
    assert shore.said == ["Thrusters: 0.0 h, 1 starts, 0 reversals"]
    keeper.close()
    state.close()

    keeper, state = shore.keeper()
    sail(keeper, 0.0, 10.0, throttle=-0.5)
    keeper.close()  # the process ends while armed
    state.close()
    assert shore.kept()["bow"] == {"thrust_s": pytest.approx(100.0), "starts": 2, "reversals": 0, "azimuth_turns": 0.0}
    assert shore.kept()["stern"]["starts"] == 0
    assert len(shore.said) == 1, "less than a minute of thrust is not told"


def test_a_thruster_that_another_file_names_is_kept(tmp_path: Path) -> None:
    shore = Ashore(tmp_path)
    (tmp_path / "wear.json").write_text(
        json.dumps(
            {"format": 1, "thrusters": {"pod": {"starts": 7}, "bow": {"starts": 4, "reversals": "x", "thrust_s": -1}}}
        )
    )
    keeper, state = shore.keeper()
    sail(keeper, 0.0, 1.0)
    keeper.close()
    state.close()
    assert shore.kept()["pod"] == {"starts": 7}
    assert shore.kept()["bow"]["starts"] == 5


def test_a_spoilt_file_is_set_aside(tmp_path: Path) -> None:
    shore = Ashore(tmp_path)
    (tmp_path / "wear.json").write_text('{"format": 1, "thrusters": [1]}')
    _, state = shore.keeper()
    assert len(shore.warned) == 1 and "set aside" in shore.warned[0]
    state.close()


def test_what_is_no_number_counts_as_zero() -> None:
    assert wear_of({"starts": True, "reversals": None, "thrust_s": 3.5}) == Wear(thrust_s=3.5)
