"""One thruster, commanded against measured. The plant's own model is the thruster here: another piece of code than what
is tested."""

from __future__ import annotations

import math
import random
from collections import deque
from dataclasses import replace

import pytest

from companion.allocation.supervision import FeedbackSupervision, ThrusterFault, Tolerances
from companion.core.actuation import ThrusterCommand, ThrusterFeedback
from sitl.thrusters import ThrusterModel
from tests.unit.control.simple_boat import REVOLT

STERN = REVOLT.thrusters[0]
TOLERANCES = Tolerances(0.15, math.radians(15.0), 1.0, 1.5, 60.0)
DT_S = 0.1


class Bench:
    """A thruster of the plant behind a bridge that is `late_s` late."""

    def __init__(self, lag_s: float = 0.3, late: int = 2, rate_share: float = 1.0) -> None:
        self.thruster = ThrusterModel(replace(STERN, azimuth_rate_radps=rate_share * STERN.azimuth_rate_radps), lag_s)
        self.supervision = FeedbackSupervision(STERN)
        self.now_s = 0.0
        self._late = deque([ThrusterCommand(0.0, 0.0, 0.0)] * late)
        self._command = ThrusterCommand(0.0, 0.0, 0.0)
        self._armed = True
        self.blind = False

    def tick(self, throttle: float, azimuth_rad: float = 0.0, armed: bool = True) -> ThrusterFault | None:
        self.now_s += DT_S
        self._late.append(self._command)
        reached = self._late.popleft()
        self.thruster.demand(reached.throttle if self._armed else 0.0, reached.azimuth_rad if self._armed else None)
        for _ in range(10):
            self.thruster.step(0.1 * DT_S)
        measured = ThrusterFeedback(self.now_s, "board", 0, self.thruster.throttle(), self.thruster.azimuth_rad)
        fault = self.supervision.update(
            self._command, self._armed, None if self.blind else measured, TOLERANCES, self.now_s
        )
        self._command, self._armed = ThrusterCommand(0.0, throttle, azimuth_rad), armed
        return fault

    def run(
        self, seconds: float, throttle: float, azimuth_rad: float = 0.0, armed: bool = True
    ) -> ThrusterFault | None:
        for _ in range(round(seconds / DT_S)):
            fault = self.tick(throttle, azimuth_rad, armed)
        return fault

    def until_fault(self, throttle: float, azimuth_rad: float = 0.0) -> float:
        start_s = self.now_s
        while self.tick(throttle, azimuth_rad) is None:
            assert self.now_s < start_s + 20.0
        return self.now_s - start_s


@pytest.mark.parametrize("lag_s", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("seed", range(3))
def test_no_alarm_however_a_healthy_thruster_is_driven(lag_s: float, seed: int) -> None:
    rng = random.Random(seed)
    bench = Bench(lag_s, late=rng.randrange(4), rate_share=rng.uniform(0.8, 1.1))
    azimuth, target, throttle, aim = 0.0, 0.0, 0.0, 0.0
    for _ in range(6000):
        if rng.random() < 0.05:
            target, aim = rng.uniform(-9.0, 9.0), rng.choice((0.0, rng.uniform(-0.96, 0.96)))
        reach = STERN.azimuth_rate_radps * DT_S  # as allocation and gate see to it
        azimuth += min(reach, max(-reach, target - azimuth))
        throttle += min(0.2, max(-0.2, aim - throttle))
        assert bench.tick(throttle, math.remainder(azimuth, math.tau)) is None


def test_no_alarm_at_arming_and_disarming_with_the_pod_elsewhere() -> None:
    bench = Bench()
    bench.thruster.azimuth_rad = math.pi
    for _ in range(5):
        assert bench.run(3.0, 0.0, 0.0, armed=False) is None
        assert bench.run(4.0, 0.9, 1.5) is None
        assert bench.run(0.3, 0.0, -1.5, armed=False) is None


@pytest.mark.parametrize("throttle", [0.3, -0.3, 0.9])
def test_a_stalled_propeller(throttle: float) -> None:
    bench = Bench()
    assert bench.run(5.0, 0.0) is None
    bench.thruster.stalled = True
    assert bench.until_fault(throttle) < 3.0
    assert bench.supervision.fault is ThrusterFault.STALLED
    assert bench.run(TOLERANCES.retry_s - 5.0, 0.0) is ThrusterFault.STALLED, "nothing tells that it is well"
    assert bench.run(10.0, 0.0) is None, "it is tried again"
    assert bench.until_fault(throttle) < 3.0
    assert bench.run(1.0, 0.0, armed=False) is None, "forgotten with disarming"
    bench.thruster.stalled = False
    assert bench.run(5.0, throttle) is None


def test_a_small_demand_is_not_judged() -> None:
    bench = Bench()
    bench.thruster.stalled = True
    assert bench.run(60.0, 0.1) is None


@pytest.mark.parametrize("armed", [True, False])
def test_a_runaway_lasts_until_it_stops(armed: bool) -> None:
    bench = Bench()
    assert bench.run(3.0, 0.0, armed=armed) is None
    bench.thruster.runaway = True
    assert bench.run(3.0, 0.0, armed=armed) is ThrusterFault.RUNAWAY
    assert bench.run(100.0, 0.0, armed=not armed) is ThrusterFault.RUNAWAY
    bench.thruster.runaway = False
    assert bench.run(3.0, 0.0, armed=armed) is ThrusterFault.RUNAWAY
    assert bench.run(3.0, 0.0, armed=armed) is None


def test_a_wrong_throttle_becomes_a_runaway_once_neutral() -> None:
    bench = Bench()
    assert bench.run(5.0, -0.5) is None
    bench.thruster.runaway = True
    assert bench.until_fault(-0.5) < 4.0
    assert bench.supervision.fault is ThrusterFault.ASTRAY
    assert bench.run(5.0, 0.0) is ThrusterFault.RUNAWAY


def test_a_clogged_propeller_that_stops_is_not_a_runaway() -> None:
    supervision = FeedbackSupervision(STERN)
    measured = 0.0
    for k in range(100):
        commanded = 0.9 if supervision.fault is None else 0.0
        measured = 0.3 if commanded else 0.8 * measured
        report = ThrusterFeedback(0.1 * k, "board", 0, measured, 0.0)
        fault = supervision.update(ThrusterCommand(0.0, commanded, 0.0), True, report, TOLERANCES, 0.1 * k)
        assert fault is not ThrusterFault.RUNAWAY
    assert fault is ThrusterFault.ASTRAY


def test_a_stuck_azimuth() -> None:
    bench = Bench()
    assert bench.run(5.0, 0.5, 0.5) is None
    bench.thruster.stuck = True
    assert bench.until_fault(0.5, 1.0) < 2.5
    assert bench.supervision.fault is ThrusterFault.STUCK
    assert bench.run(10.0, 0.0, 0.5) is ThrusterFault.STUCK, "the command has come to it, it has not moved"
    assert bench.run(TOLERANCES.retry_s, 0.0, 0.5) is None, "it is tried again"
    assert bench.until_fault(0.5, 1.0) < 2.5
    bench.thruster.stuck = False
    bench.run(2.0, 0.0, 1.0)
    assert bench.run(4.0, 0.0, 1.0) is None


def test_without_measurements_nothing_is_judged() -> None:
    bench = Bench()
    assert bench.run(5.0, 0.9, 0.5) is None
    bench.blind = True
    assert bench.run(10.0, -0.9, -2.5) is None
    bench.thruster.force_n, bench.thruster.azimuth_rad = 0.0, 1.0  # its board had gone neutral
    bench.blind = False
    assert bench.run(10.0, 0.9, -2.5) is None


def test_time_that_goes_back_or_jumps_ends_no_fault() -> None:
    supervision = FeedbackSupervision(STERN)
    for now_s in (0.0, 100.0, 50.0, 50.0, 1e6):
        report = ThrusterFeedback(now_s, "board", 0, 0.0, 0.0)
        assert supervision.update(ThrusterCommand(0.0, 0.9, 0.0), True, report, TOLERANCES, now_s) is None


def test_after_a_gap_in_the_commands_the_propeller_may_have_stopped() -> None:
    """Its board went neutral for want of commands, again and again; that is no stalled propeller."""
    bench = Bench()
    bench.run(5.0, 0.8)
    for _ in range(20):
        bench.thruster.demand(0.0, None)
        for _ in range(80):
            bench.thruster.step(0.01)
        bench.now_s += 0.8 - DT_S
        assert bench.run(0.2, 0.8) is None
    assert bench.run(5.0, 0.8) is None
