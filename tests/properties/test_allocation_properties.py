"""Whatever wrench is asked for, limits and rates are kept and the achieved wrench is told truly; and the gate lets
nothing else through."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.allocation.allocator import Allocator
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.angles import wrap_pi
from companion.params.store import Parameters
from companion.safety import Gate
from tests.unit.control.simple_boat import BOW_DOWN, REVOLT

DT_S = 0.1
PARAMETERS = Parameters()
forces = st.floats(-80.0, 80.0)
wrenches = st.lists(st.builds(Wrench, forces, forces, forces), min_size=1, max_size=25)
anything = st.floats(allow_nan=True, allow_infinity=True)
commands = st.builds(ThrusterCommand, anything, anything, st.one_of(st.none(), anything))


def checked(allocator: Allocator, sequence: list[Wrench]) -> None:
    last = allocator.neutral()
    for wrench in sequence:
        now = allocator.update(wrench, DT_S)
        x = y = n = 0.0
        for t, p, q in zip(REVOLT.thrusters, last.thrusters, now.thrusters, strict=True):
            assert t.min_n - 1e-9 <= q.force_n <= t.max_n + 1e-9
            assert -1.0 <= q.throttle <= 1.0
            assert abs(q.force_n - p.force_n) <= t.force_rate_nps * DT_S + 1e-9
            azimuth = t.azimuth_rad if q.azimuth_rad is None else q.azimuth_rad
            if p.azimuth_rad is not None and q.azimuth_rad is not None:
                assert abs(wrap_pi(q.azimuth_rad - p.azimuth_rad)) <= t.azimuth_rate_radps * DT_S + 1e-9
            c, s = math.cos(azimuth), math.sin(azimuth)
            x, y, n = x + c * q.force_n, y + s * q.force_n, n + (t.x_m * s - t.y_m * c) * q.force_n
        assert math.isclose(x, now.achieved.surge_n, abs_tol=1e-9)
        assert math.isclose(y, now.achieved.sway_n, abs_tol=1e-9)
        assert math.isclose(n, now.achieved.yaw_nm, abs_tol=1e-9)
        last = now


@settings(deadline=None, derandomize=True, max_examples=60)
@given(wrenches)
def test_constrained_allocation_keeps_limits_and_rates(sequence: list[Wrench]) -> None:
    checked(Allocator(REVOLT, PARAMETERS), sequence)


@settings(deadline=None, derandomize=True, max_examples=30)
@given(wrenches)
def test_the_pseudo_inverse_keeps_limits_and_rates(sequence: list[Wrench]) -> None:
    checked(Allocator(REVOLT, Parameters({"ALLOC_KIND": 1})), sequence)


@settings(deadline=None, derandomize=True, max_examples=60)
@given(wrenches)
def test_the_gate_never_touches_what_the_allocation_gives(sequence: list[Wrench]) -> None:
    allocator, gate = Allocator(REVOLT, PARAMETERS), Gate(REVOLT)
    for wrench in sequence:
        allocation = allocator.update(wrench, DT_S)
        command = gate.update(allocation, True, 0.0, DT_S, True, BOW_DOWN)
        assert command.gated == ()
        assert command.thrusters == allocation.thrusters


@settings(deadline=None, derandomize=True, max_examples=100)
@given(st.lists(st.tuples(st.lists(commands, max_size=4), st.booleans(), anything), min_size=1, max_size=8))
def test_the_gate_lets_only_sound_commands_through(sequence: list[tuple[list[ThrusterCommand], bool, float]]) -> None:
    gate = Gate(REVOLT)
    for demand, armed, dt_s in sequence:
        command = gate.update(
            Allocation(tuple(demand), Wrench(0.0, 0.0, 0.0), (False, False, False)), armed, 0.0, dt_s, True, BOW_DOWN
        )
        assert len(command.thrusters) == 3 and command.armed is armed
        for t, c in zip(REVOLT.thrusters, command.thrusters, strict=True):
            assert math.isfinite(c.throttle) and abs(c.throttle) <= 1.0
            assert t.min_n - 1e-9 <= c.force_n <= t.max_n + 1e-9
            assert (c.azimuth_rad is not None) == (t.kind == "azimuth")
            assert c.azimuth_rad is None or math.isfinite(c.azimuth_rad)
            assert armed or c.throttle == 0.0
