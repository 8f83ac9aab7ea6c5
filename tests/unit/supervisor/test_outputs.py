"""Servo and relay outputs: set, repeated, at rest while disarmed, refused where they are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import Auxiliary
from companion.core.decision import Result, Severity
from companion.core.events import EventLog
from companion.mission.plan import PlanItem
from companion.mission.tasks import SetActuators, SetRelay, SetServo
from companion.supervisor.outputs import AuxiliaryOutputs
from tests.unit.conftest import Boat

WINCH, FLAP = ServoConfig("winch", rest_us=1500.0), ServoConfig("flap", 900.0, 2100.0)
PUMP, LAMP = RelayConfig("pump"), RelayConfig("lamp", while_disarmed=True)


@pytest.fixture
def config(revolt: VesselConfig) -> VesselConfig:
    bridge = replace(revolt.actuators[0], servos=("winch", "flap"), relays=("pump", "lamp"))
    return replace(revolt, servos=(WINCH, FLAP), relays=(PUMP, LAMP), actuators=(bridge,))


@pytest.fixture
def outputs(config: VesselConfig) -> AuxiliaryOutputs:
    found = AuxiliaryOutputs(config, EventLog())
    found.update(True, 0.0)
    return found


def test_they_rest_until_asked(outputs: AuxiliaryOutputs) -> None:
    assert outputs.update(True, 0.0) == Auxiliary((1500.0, None), (False, False))
    assert outputs.request(SetServo(2, 2000.0), 1.0).accepted and outputs.request(SetRelay(0, True), 1.0).accepted
    assert outputs.update(True, 1.0) == Auxiliary((1500.0, 2000.0), (True, False))
    assert outputs.request(SetActuators((-1.0, 0.5)), 2.0).accepted
    assert outputs.update(True, 2.0).servos_us == (1000.0, pytest.approx(1800.0))
    assert outputs.request(SetActuators((None, None)), 2.0).accepted
    assert outputs.update(True, 2.0).servos_us[0] == 1000.0


def test_disarmed_all_rest_but_what_may_move_then(outputs: AuxiliaryOutputs) -> None:
    for action in (SetServo(1, 1900.0), SetRelay(0, True), SetRelay(1, True), SetServo(2, 2000.0, 100, 1.0)):
        assert outputs.request(action, 1.0).accepted
    assert outputs.update(False, 1.1) == Auxiliary((1500.0, None), (False, True))
    refused = outputs.request(SetRelay(0, True), 1.2)
    assert refused.result is Result.TEMPORARILY_REJECTED and "pump moves only while the boat is armed" in refused.reason
    assert not outputs.request(SetActuators((0.0,)), 1.2).accepted
    assert outputs.request(SetRelay(1, False), 1.2).accepted
    assert outputs.update(True, 1.3) == Auxiliary((1500.0, None), (False, False)), "arming brings nothing back"


def test_repetitions(outputs: AuxiliaryOutputs) -> None:
    outputs.request(SetServo(1, 1900.0, 2, 1.0), 10.0)
    outputs.request(SetRelay(0, None, 2, 1.0), 10.0)
    seen = [outputs.update(True, 10.0 + 0.25 * k) for k in range(12)]
    up = [True, True, False, False, True, True] + [False] * 6
    assert [value.servos_us[0] == 1900.0 for value in seen] == up
    assert [value.relays[0] for value in seen] == up
    outputs.request(SetRelay(0, True), 20.0)
    outputs.request(SetRelay(0, None, 1, 1.0), 20.0)
    assert [outputs.update(True, t_s).relays[0] for t_s in (20.1, 20.6, 21.5)] == [False, True, True], (
        "it ends as it was"
    )
    outputs.request(SetRelay(0, None, 50, 1.0), 30.0)
    outputs.request(SetRelay(0, False), 30.1)
    assert not any(outputs.update(True, 30.0 + 0.3 * k).relays[0] for k in range(10)), "setting it ends the repetition"


def test_a_repetition_within_another_returns_to_where_all_began(outputs: AuxiliaryOutputs) -> None:
    outputs.request(SetServo(1, 1900.0, 10, 2.0), 0.0)
    outputs.update(True, 0.5)
    outputs.request(SetServo(1, 1100.0, 1, 1.0), 0.5)
    assert [outputs.update(True, t_s).servos_us[0] for t_s in (0.6, 1.1, 5.0)] == [1100.0, 1500.0, 1500.0]


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (SetServo(0, 1500.0), "No servo output 0: this boat has 1 to 2"),
        (SetServo(3, 1500.0), "No servo output 3"),
        (SetServo(1, 2050.0), "Servo 1 (winch) takes 1000 to 2000 µs"),
        (SetServo(1, float("nan")), "takes 1000 to 2000"),
        (SetRelay(2, True), "No relay 2: this boat has 0 to 1"),
        (SetRelay(-1, True), "No relay -1"),
        (SetActuators((None, None, 0.0)), "No servo output 3"),
    ],
)
def test_refused(outputs: AuxiliaryOutputs, action: Any, words: str) -> None:
    outcome = outputs.request(action, 0.0)
    assert outcome.result is Result.DENIED and words in outcome.reason
    assert outputs.update(True, 0.0) == Auxiliary((1500.0, None), (False, False))


def test_a_mission_sets_them_and_conditions_hold_back(make_boat: Callable[..., Boat], config: VesselConfig) -> None:
    boat = make_boat(config)
    boat.upload(
        (10.0, 0.0),
        (40.0, 0.0),
        commands={
            1: PlanItem(0, 181, 2, 0.0, 1.0, 0.0, 0.0, 0, 0, 0.0),
            2: PlanItem(0, 112, 2, 10.0, 0.0, 0.0, 0.0, 0, 0, 0.0),
            3: PlanItem(0, 183, 2, 1.0, 1900.0, 0.0, 0.0, 0, 0, 0.0),
            4: PlanItem(0, 114, 2, 12.0, 0.0, 0.0, 0.0, 0, 0, 0.0),
            5: PlanItem(0, 181, 2, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0),
        },
    )
    outputs = boat.supervisor.auxiliary
    boat.step()

    def run(condition: Callable[[Auxiliary], bool]) -> float:
        boat.until(lambda: condition(outputs.update(boat.status.armed, boat.now_s)))
        return float(boat.now_s)

    assert boat.supervisor.start_mission(None, boat.now_s).accepted and boat.supervisor.arm(boat.now_s).accepted
    passed_s = run(lambda now: now.relays[0])
    assert boat.executor.progress.seq == 6 and boat.nav.north_m == pytest.approx(10.0, abs=2.0)
    assert run(lambda now: now.servos_us[0] == 1900.0) - passed_s == pytest.approx(10.0, abs=0.3)
    run(lambda now: not now.relays[0])
    assert boat.away_m(40.0, 0.0) == pytest.approx(12.0, abs=0.3), (
        "12 m before the next waypoint, and not before the delay is over"
    )
    assert any("Servo 1 (winch): 1900 µs" in text for text in boat.texts())


def test_a_refusal_in_mid_mission_is_said_and_the_boat_sails_on(
    make_boat: Callable[..., Boat], config: VesselConfig
) -> None:
    boat = make_boat(config)
    boat.upload((10.0, 0.0), (20.0, 0.0), commands={1: PlanItem(0, 183, 2, 1.0, 2400.0, 0.0, 0.0, 0, 0, 0.0)})
    boat.supervisor.start_mission(None, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.until(lambda: boat.executor.progress.reached_seq == 2)
    assert boat.severities["auxiliary_refused"] is Severity.ERROR
