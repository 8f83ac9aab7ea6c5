"""The thruster test on the simulated boat, by the boat's own record: what turns, how far, and that everything ends in
neutral."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path

import pytest

from companion.app import load_vessel
from companion.cli import thruster_test
from companion.cli.main import main
from companion.cli.thruster_test import Trial, TrialError, run_test, run_trials
from companion.clock import SimulatedClock
from companion.config.vessel import bundled
from companion.io.actuators import open_actuator
from companion.loop import RealWorld
from companion.record.state_file import StateFile
from companion.supervisor.motor_test import MOST_POWER
from sitl.world import World, WorldConditions


class Watched(World):
    """A world that remembers the strongest push of each thruster."""

    def __init__(self, vessel: str, faults: tuple[str, ...] = ()) -> None:
        super().__init__(load_vessel(vessel), WorldConditions(faults=faults))
        self.most_n = [0.0] * len(self.thrusters)

    def advance(self, now_s: float) -> None:
        super().advance(now_s)
        self.most_n = [
            max(most, abs(thruster.force_n)) for most, thruster in zip(self.most_n, self.thrusters, strict=True)
        ]


def trial_of(world: Watched, vessel: str) -> tuple[Trial, list[str]]:
    config = load_vessel(vessel)
    actuators = [open_actuator(bridge, config, world.open(bridge.name, bridge.port)) for bridge in config.actuators]
    return Trial(config, actuators, SimulatedClock(0), world), [thruster.name for thruster in config.thrusters]


def answers(*said: str) -> Callable[[str, Callable[[], None]], str]:
    left = list(said)

    def ask(question: str, idle: Callable[[], None]) -> str:
        for _ in range(5):
            idle()
        return left.pop(0) if left else "q"

    return ask


def silent(text: str) -> None:
    pass


@pytest.mark.parametrize("vessel", bundled())
def test_every_thruster_of_every_vessel_does_as_asked_and_no_more(vessel: str) -> None:
    world = Watched(vessel)
    trial, names = trial_of(world, vessel)
    said: list[str] = []
    assert run_trials(load_vessel(vessel), trial, names, 0.2, 3.0, answers(*("y" for _ in names)), said.append), said
    for thruster, most_n in zip(load_vessel(vessel).thrusters, world.most_n, strict=True):
        bound_n = max(thruster.ahead_n, thruster.astern_n) * 0.2**2
        if thruster.jet is not None:
            bound_n = thruster.jet.bollard_n(0.2)
        assert 0.3 * bound_n < most_n < 1.05 * bound_n
    for _ in range(100):
        trial.idle()
    assert all(abs(thruster.force_n) < 0.01 * thruster.max_n for thruster in world.thrusters)


def test_only_the_one_agreed_to_turns() -> None:
    world = Watched("revolt")
    trial, names = trial_of(world, "revolt")
    run_trials(load_vessel("revolt"), trial, names, 0.2, 2.0, answers("n", "y", "n"), silent)
    assert world.most_n[1] > 0.5
    assert world.most_n[0] < 0.01 and world.most_n[2] < 0.01


def test_the_measured_azimuth_rate_is_the_plants() -> None:
    world = Watched("aboat")
    trial, names = trial_of(world, "aboat")
    said: list[str] = []
    run_trials(load_vessel("aboat"), trial, names[:1], 0.1, 2.0, answers("y"), said.append)
    (line,) = (text for text in said if "azimuth_rate_dps" in text)
    true_dps = math.degrees(load_vessel("aboat").thrusters[0].azimuth_rate_radps)
    assert float(line.split()[2]) == pytest.approx(true_dps, rel=0.05)


def test_a_second_is_a_second_at_full_power() -> None:
    world = Watched("revolt")
    trial, names = trial_of(world, "revolt")
    said: list[str] = []
    assert run_trials(load_vessel("revolt"), trial, names[:1], 0.2, 1.0, answers("y"), said.append), said
    reported = [float(line.split("commanded,")[1].split("%")[0]) for line in said if "commanded" in line]
    assert [abs(percent) for percent in reported] == pytest.approx([20.0, 20.0], abs=2.0)


def test_a_dead_propeller_is_found() -> None:
    world = Watched("revolt", faults=("thruster_stern_port_dead@0",))
    trial, names = trial_of(world, "revolt")
    said: list[str] = []
    assert not run_trials(load_vessel("revolt"), trial, names[:1], 0.2, 2.0, answers("y"), said.append)
    assert any("NOT AS COMMANDED" in text for text in said)


def test_an_interruption_leaves_all_neutral() -> None:
    world = Watched("revolt")
    trial, names = trial_of(world, "revolt")

    def interrupt(text: str) -> None:
        if "ahead" in text:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_trials(load_vessel("revolt"), trial, names[:1], 0.2, 2.0, answers("y"), interrupt)
    world.advance(world.t_s + 3.0)
    assert all(abs(thruster.force_n) < 0.05 for thruster in world.thrusters)


def test_a_silent_board_is_an_error_with_its_remedy() -> None:
    world = Watched("revolt")
    config = load_vessel("revolt")
    world.add_fault("microcontroller_unplugged")
    actuators = [open_actuator(bridge, config, world.open(bridge.name, bridge.port)) for bridge in config.actuators]
    world.advance(0.1)
    trial = Trial(config, actuators, SimulatedClock(0), world)
    with pytest.raises(TrialError, match="microcontroller"):
        trial.connect()


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"power": 0.9}, "at most"),
        ({"power": math.nan}, "at most"),
        ({"seconds": 0.2}, "to 30"),
        ({"thruster": ["rudder"]}, "there is stern_port"),
        ({"yes": True, "sitl": False}, "a person must look"),
    ],
)
def test_mistakes_open_nothing(changes: dict[str, object], text: str) -> None:
    class Closed:
        def open(self, name: str, url: str) -> object:
            raise AssertionError("a port was opened")

    given = {"power": 0.15, "seconds": 3.0, "thruster": None, "yes": True, "sitl": True} | changes
    with pytest.raises(TrialError, match=text):
        run_test(load_vessel("revolt"), Closed(), RealWorld(), SimulatedClock(0), argparse.Namespace(**given))  # type: ignore[arg-type]
    assert MOST_POWER <= 0.3


def test_a_running_service_keeps_the_test_from_the_thrusters(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Only this user's own state folder was looked at, and the service's lies elsewhere: both commanded the thrusters."""
    monkeypatch.setattr(thruster_test, "STATE_FOLDER", tmp_path / "service")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "user"))
    monkeypatch.setattr(thruster_test, "run_test", lambda *_: 0)
    assert main(["thruster-test", "otter"]) == 0, "no service has run here"
    service = StateFile(tmp_path / "service")
    assert main(["thruster-test", "otter"]) == 2
    assert "the service runs, and commands the thrusters: `sudo systemctl stop" in capsys.readouterr().err
    service.close()
    assert main(["thruster-test", "otter"]) == 0
