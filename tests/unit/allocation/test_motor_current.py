"""The current of a motor against its throttle: what is found, how soon, and what is not taken for a fault."""

from __future__ import annotations

import math
import random

import pytest

from companion.allocation.motor_current import CurrentSupervision, LoadFault
from companion.config.vessel import find, load
from sitl.thrusters import ThrusterModel

THRUSTER = load(find("blueboat")).thrusters[0]
FULL_A, TOLERANCE, TIMES_S, STEP_S = 24.0, 1.8, (1.0, 1.5, 60.0), 0.1


class Bench:
    """A thruster as the plant has it, and what supervises its current. `scale`: by how much `full_a` is wrong."""

    def __init__(self, scale: float = 1.0, lag_s: float = 0.3) -> None:
        self.thruster = ThrusterModel(THRUSTER, lag_s)
        self.supervision = CurrentSupervision(FULL_A)
        self.now_s, self.scale = 0.0, scale

    def run(self, seconds: float, throttle: float, armed: bool = True) -> LoadFault | None:
        for _ in range(round(seconds / STEP_S)):
            self.now_s += STEP_S
            self.thruster.drive(throttle if armed and self.supervision.fault is None else 0.0)
            self.thruster.step(STEP_S)
            drawn_a = self.scale * self.thruster.current_a(FULL_A)
            self.supervision.update(throttle, armed, drawn_a, TOLERANCE, TIMES_S, self.now_s)
        return self.supervision.fault


@pytest.mark.parametrize(
    ("kind", "fault", "throttle"),
    [
        *(("fouled", LoadFault.BLOCKED, throttle) for throttle in (0.45, 0.7, 1.0, -0.6)),
        *(("stalled", LoadFault.BLOCKED, throttle) for throttle in (0.45, 0.7, 1.0, -0.6)),
        *(("dead", LoadFault.UNLOADED, throttle) for throttle in (0.5, 0.7, 1.0, -0.6)),
    ],
)
def test_a_propeller_that_goes_wrong_is_found_within_three_seconds(
    kind: str, fault: LoadFault, throttle: float
) -> None:
    bench = Bench()
    assert bench.run(10.0, throttle) is None
    setattr(bench.thruster, kind, True)
    assert bench.run(3.0, throttle) is fault


@pytest.mark.parametrize("scale", [0.6, 0.8, 1.0, 1.3])
@pytest.mark.parametrize("seed", range(3))
def test_a_sound_motor_under_any_throttle_is_no_fault(scale: float, seed: int) -> None:
    bench, rng = Bench(scale), random.Random(seed)
    for _ in range(200):
        assert bench.run(rng.uniform(0.2, 4.0), rng.uniform(-1.0, 1.0)) is None


def test_slow_waves_of_throttle_through_rest_are_no_fault() -> None:
    bench = Bench(lag_s=0.8)
    for k in range(1200):
        assert bench.run(STEP_S, math.sin(0.05 * k)) is None


def test_without_a_measurement_nothing_is_found_and_the_time_begins_anew() -> None:
    supervision = CurrentSupervision(FULL_A)
    for k in range(100):
        current_a = None if k % 10 == 9 else 3.0 * FULL_A
        assert supervision.update(1.0, True, current_a, TOLERANCE, TIMES_S, STEP_S * k) is None


def test_a_fault_lasts_until_it_is_tried_again_or_the_boat_is_armed() -> None:
    bench = Bench()
    bench.run(5.0, 0.8)
    bench.thruster.fouled = True
    assert bench.run(3.0, 0.8) is LoadFault.BLOCKED
    assert bench.run(TIMES_S[2] - 4.0, 0.8) is LoadFault.BLOCKED
    bench.thruster.fouled = False
    assert bench.run(6.0, 0.8) is None
    bench.thruster.fouled = True
    assert bench.run(3.0, 0.8) is LoadFault.BLOCKED
    assert bench.run(0.1, 0.8, armed=False) is None
