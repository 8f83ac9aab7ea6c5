"""Thrusters one by one on a disarmed boat: bounded, and over at once when something speaks against it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.actuation import ThrusterCommand
from companion.core.decision import ModeId, Result
from companion.supervisor.motor_test import LONGEST_S, MOST_POWER, MotorTest

DT_S = 0.1


def run(boat: Any, duration_s: float) -> list[tuple[ThrusterCommand, ...] | None]:
    test: MotorTest = boat.supervisor.motor_test
    found = []
    for _ in range(round(duration_s / DT_S)):
        boat.tick()
        found.append(test.update(boat.now_s, DT_S))
    return found


def throttles(commands: list[tuple[ThrusterCommand, ...] | None], index: int) -> list[float]:
    return [0.0 if one is None else one[index].throttle for one in commands]


def test_one_thruster_ramps_up_runs_and_stops(boat: Any) -> None:
    test = boat.supervisor.motor_test
    assert test.update(boat.now_s, DT_S) is None and not test.running
    assert test.begin(1, 0.2, 2.0, boat.now_s).accepted and test.running
    commands = run(boat, 3.0)
    given = throttles(commands, 1)
    assert given[0] == pytest.approx(0.06) and max(given) == pytest.approx(0.2)
    assert given[:20].count(pytest.approx(0.2)) >= 15 and set(given[20:]) == {0.0}
    assert set(throttles(commands, 0)) == {0.0} == set(throttles(commands, 2))
    assert all(one is None or one[0].azimuth_rad is None for one in commands), "the others keep their azimuth"
    assert commands[-1] is None and not test.running
    assert boat.texts()[-2:] == ["Motor test: stern_starboard at +20%", "Motor test over: stern_starboard"]


def test_a_stream_runs_it_on_and_the_end_of_the_stream_stops_it(boat: Any) -> None:
    test = boat.supervisor.motor_test
    for _ in range(30):
        assert test.begin(0, -0.1, 1.0, boat.now_s).accepted
        assert run(boat, DT_S)[0] is not None
    assert throttles(run(boat, 0.8), 0)[-1] == pytest.approx(-0.1)
    assert run(boat, 0.5)[-1] is None
    assert boat.texts().count("Motor test: stern_port at -10%") == 1


def test_a_sequence_runs_one_after_the_other(boat: Any) -> None:
    assert boat.supervisor.motor_test.begin(0, 0.1, 1.0, boat.now_s, count=2).accepted
    commands = run(boat, 4.0)
    first, second = throttles(commands, 0), throttles(commands, 1)
    assert not any(a and b for a, b in zip(first, second, strict=True))
    assert first.index(pytest.approx(0.1)) < second.index(pytest.approx(0.1))
    assert commands[-1] is None


def test_stopped_by_who_asked(boat: Any) -> None:
    test = boat.supervisor.motor_test
    test.begin(0, 0.2, 5.0, boat.now_s)
    test.begin(1, 0.2, 5.0, boat.now_s)
    run(boat, 1.0)
    assert test.stop(0, boat.now_s).accepted
    commands = run(boat, 0.2)
    assert throttles(commands, 0)[0] == 0.0 < throttles(commands, 1)[0]
    test.begin(1, 0.0, 5.0, boat.now_s)
    assert run(boat, 0.1) == [None]
    assert test.stop(None, boat.now_s).accepted and test.stop(2, boat.now_s).accepted


@pytest.mark.parametrize(
    ("index", "throttle", "duration_s", "count", "text"),
    [
        (3, 0.1, 1.0, 1, "this boat has motors 1 to 3"),
        (-1, 0.1, 1.0, 1, "this boat has motors 1 to 3"),
        (2, 0.1, 1.0, 2, "this boat has motors 1 to 3"),
        (0, 0.31, 1.0, 1, "at most 30%"),
        (0, math.inf, 1.0, 1, "at most 30%"),
        (0, math.nan, 1.0, 1, "at most 30%"),
        (0, 0.1, 11.0, 1, "at most 10 s"),
        (0, 0.1, math.nan, 1, "at most 10 s"),
        (0, 0.1, -1.0, 1, "at most 10 s"),
    ],
)
def test_what_is_wrong_whenever_it_is_asked(
    boat: Any, index: int, throttle: float, duration_s: float, count: int, text: str
) -> None:
    outcome = boat.supervisor.motor_test.begin(index, throttle, duration_s, boat.now_s, count)
    assert outcome.result is Result.DENIED and text in outcome.reason
    assert run(boat, 0.1) == [None]
    assert MOST_POWER == 0.3 and LONGEST_S == 10.0


def test_never_armed(boat: Any) -> None:
    boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s)
    assert boat.supervisor.arm(boat.now_s).accepted
    outcome = boat.supervisor.motor_test.begin(0, 0.1, 1.0, boat.now_s)
    assert outcome.result is Result.TEMPORARILY_REJECTED and outcome.reason == "Motor test refused: disarm first"


@pytest.mark.parametrize("end", ["arm", "disarm", "terminate", "safe switch", "bridge"])
def test_it_stops_at_once(boat: Any, end: str) -> None:
    test = boat.supervisor.motor_test
    assert test.begin(0, 0.2, 5.0, boat.now_s).accepted
    assert throttles(run(boat, 1.0), 0)[-1] == pytest.approx(0.2)
    if end == "arm":
        boat.supervisor.request_mode(ModeId.MANUAL, boat.now_s)
        boat.supervisor.arm(boat.now_s)
    elif end == "disarm":
        boat.supervisor.disarm(boat.now_s)
    elif end == "terminate":
        boat.supervisor.terminate(boat.now_s)
    elif end == "safe switch":
        boat.rc = (0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    else:
        boat.silent.add(boat.config.actuators[0].name)
    assert run(boat, 0.1) == [None] and not test.running
    if end in ("safe switch", "bridge"):
        boat.tick()
        assert any(text.startswith("Motor test stopped: ") for text in boat.texts())
        assert not test.begin(0, 0.2, 5.0, boat.now_s).accepted


def test_a_retracted_thruster_is_lowered_first(boat: Any) -> None:
    bow = next(i for i, thruster in enumerate(boat.config.thrusters) if thruster.retractable)
    boat.supervisor.retraction.see(frozenset({bow}), boat.now_s)
    assert boat.supervisor.motor_test.begin(bow, 0.1, 1.0, boat.now_s).reason == "Motor test refused: lower bow first"


def test_a_thruster_without_reverse(make_boat: Any) -> None:
    boat = make_boat(load(find("rescuerunner")))
    outcome = boat.supervisor.motor_test.begin(0, -0.1, 1.0, boat.now_s)
    assert outcome.result is Result.DENIED and "jet has no reverse" in outcome.reason


def test_the_transmitters_kill_switch_stops_it_and_forbids_more(make_boat: Callable[..., Any]) -> None:
    boat = make_boat(RC_MAP_KILL_SW=5.0)
    boat.rc = (0.0, 0.0, -1.0, 0.0, -1.0, -1.0, -1.0, -1.0)
    boat.step(0.5)
    assert boat.supervisor.motor_test.begin(0, 0.2, 5.0, boat.now_s).accepted
    boat.rc = (0.0, 0.0, -1.0, 0.0, 1.0, -1.0, -1.0, -1.0)
    assert run(boat, 0.2)[-1] is None
    refused = boat.supervisor.motor_test.begin(0, 0.2, 5.0, boat.now_s)
    assert refused.result is Result.TEMPORARILY_REJECTED and "kill switch" in refused.reason
