"""The condition of each thruster, and what is announced of it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from companion.allocation.availability import Availability
from companion.core.actuation import ActuatorCommand, Deployment, ThrusterCommand, ThrusterCondition, ThrusterFeedback
from companion.core.decision import TextKind
from companion.params.store import Parameters
from tests.unit.control.simple_boat import REVOLT

READY, UP, MOVING, FAILED = (
    ThrusterCondition.READY,
    ThrusterCondition.RETRACTED,
    ThrusterCondition.MOVING,
    ThrusterCondition.FAILED,
)
TRAVEL_S = REVOLT.thrusters[2].travel_s


class Bench:
    """Feedback of a board that follows its commands, except where the test changes it."""

    def __init__(self) -> None:
        self.parameters = Parameters()
        self.said: list[tuple[TextKind, str]] = []
        self.availability = Availability(
            REVOLT, self.parameters, lambda t_s, severity, name, text: self.said.append((severity, text))
        )
        self.now_s = 0.0
        self.deployment: Deployment | None = Deployment.LOWERED
        self.lower: bool | None = None
        self.ok = True
        self.throttle = 0.0
        self.measured: Callable[[], float] = lambda: self.throttle
        self.silent: tuple[str, ...] = ()

    def run(self, seconds: float) -> tuple[ThrusterCondition, ...]:
        for _ in range(max(1, round(10 * seconds))):
            self.now_s += 0.1
            reports = [ThrusterFeedback(self.now_s, "board", i, 0.0, 0.0) for i in range(2)]
            bow = ThrusterFeedback(self.now_s, "board", 2, self.measured(), None, self.ok, self.deployment)
            command = ActuatorCommand(
                self.now_s, True, (ThrusterCommand(0.0, 0.0, 0.0),) * 2 + (ThrusterCommand(1.0, self.throttle, None),)
            )
            self.availability.update([*reports, bow], command, self.lower, self.silent, self.now_s)
        return self.availability.conditions


def test_before_the_first_report_a_retractable_thruster_is_not_used() -> None:
    availability = Availability(REVOLT, Parameters(), lambda *_: None)
    assert availability.update([None] * 3, None, None, (), 0.0)
    assert availability.conditions == (READY, READY, UP) and availability.up == {2}
    assert not availability.update([None] * 3, None, None, (), 0.1)


def test_a_fault_that_the_board_reports_counts_at_once() -> None:
    bench = Bench()
    assert bench.run(1.0) == (READY, READY, READY) and bench.said == []
    bench.ok = False
    assert bench.run(0.1) == (READY, READY, FAILED)
    bench.ok = True
    assert bench.run(0.1) == (READY, READY, READY)
    assert [text for _, text in bench.said] == [
        "Thruster bow failed: not used",
        "Thruster bow works again",
    ]


def test_lowered_when_the_board_reports_it_and_not_after_the_order_to_retract() -> None:
    bench = Bench()
    bench.run(0.1)
    bench.lower = False
    assert bench.run(0.1)[2] is MOVING, "before it has begun to move"
    bench.deployment = Deployment.MOVING
    assert bench.run(1.0)[2] is MOVING
    bench.deployment = Deployment.RETRACTED
    assert bench.run(1.0)[2] is UP and bench.availability.up == {2}
    bench.lower, bench.deployment = True, Deployment.MOVING
    assert bench.run(TRAVEL_S)[2] is MOVING
    bench.deployment = Deployment.LOWERED
    assert bench.run(0.1)[2] is READY
    assert [text.removeprefix("Thruster bow ") for _, text in bench.said] == [
        "is being retracted",
        "is retracted",
        "is being lowered",
        "is lowered",
    ]


def test_without_a_reported_position_the_travel_time_counts() -> None:
    bench = Bench()
    bench.deployment = None
    assert bench.run(1.0)[2] is UP
    bench.lower = True
    assert bench.run(TRAVEL_S - 0.2)[2] is MOVING
    assert bench.run(0.4)[2] is READY
    bench.lower = False
    assert bench.run(0.1)[2] is MOVING
    assert bench.run(TRAVEL_S + 0.2)[2] is UP


@pytest.mark.parametrize(
    ("lower", "condition", "severity", "text"),
    [
        (True, FAILED, TextKind.ALARM, "does not lower: not used"),
        (False, MOVING, TextKind.ATTENTION, "does not retract"),
    ],
)
def test_a_jammed_thruster_is_announced_once(
    lower: bool, condition: ThrusterCondition, severity: TextKind, text: str
) -> None:
    bench = Bench()
    bench.deployment = Deployment.MOVING
    bench.lower = lower
    assert bench.run(2.0 * TRAVEL_S)[2] is MOVING and bench.said == []
    assert bench.run(60.0)[2] is condition
    assert bench.said == [(severity, f"Thruster bow {text}")]
    bench.deployment = Deployment.LOWERED if lower else Deployment.RETRACTED
    assert bench.run(0.1)[2] is (READY if lower else UP)


def test_feedback_that_contradicts_the_command_is_a_failure_until_the_retry() -> None:
    bench = Bench()
    bench.throttle, bench.measured = 0.5, lambda: 0.0
    assert bench.run(4.0)[2] is FAILED
    assert bench.said == [(TextKind.ALARM, "Thruster bow not used: propeller stalled")]
    bench.throttle = 0.0
    assert bench.run(60.0)[2] is READY
    assert bench.said[1:] == [(TextKind.ROUTINE, "Thruster bow is tried again")]


def test_a_runaway_is_an_alert_in_one_statustext() -> None:
    bench = Bench()
    bench.run(2.0)
    bench.measured = lambda: 0.6
    assert bench.run(3.0)[2] is FAILED
    ((severity, text),) = bench.said
    assert severity is TextKind.DANGER and len(text.replace("bow", "stern_starboard")) <= 50


def test_feedback_of_a_silent_bridge_does_not_count() -> None:
    bench = Bench()
    bench.run(2.0)
    bench.throttle, bench.measured, bench.silent = 0.9, lambda: 0.0, ("board",)
    assert bench.run(20.0)[2] is READY


def test_supervision_can_be_switched_off_under_way() -> None:
    bench = Bench()
    bench.throttle, bench.measured = 0.5, lambda: 0.0
    assert bench.run(4.0)[2] is FAILED
    bench.parameters.set("THR_WATCH", 0)
    assert bench.run(0.1)[2] is READY
