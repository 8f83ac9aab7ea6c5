"""Whatever the estimate, the thrusters and the operator do, docking gives a finite setpoint and never pushes without
contact."""

from __future__ import annotations

import math
from dataclasses import astuple, replace
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.config.vessel import find, load
from companion.core.actuation import Wrench
from companion.core.decision import ModeInputs
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.readings import FixType
from companion.core.setpoint import PoseSetpoint, desired_motion
from companion.modes.parts.berth import Berth
from companion.modes.parts.docking import Docking, DockingPhase
from companion.params.store import Parameters

REVOLT = load(find("revolt"))
NAV = NavState(
    0.0, True, True, 63.4389, 10.399, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    0.02, 0.02, 0.01, 0.0, 0.0, 0.0, FixType.RTK_FIXED, 14, 0.7, None,
)  # fmt: skip
TOWARDS = ((0.0, -1.0), (0.0, 1.0), (1.0, 0.0), (-1.0, 0.0))

metre = st.floats(-8.0, 8.0)
steps = st.one_of(
    st.tuples(st.just("follow"), st.integers(1, 400)),
    st.tuples(st.just("stuck"), st.integers(1, 100)),
    st.tuples(
        st.just("jump"),
        st.tuples(metre, metre, st.floats(-math.pi, math.pi), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
    ),
    st.tuples(st.just("accuracy"), st.sampled_from((0.02, 0.1, 0.5, math.inf))),
    st.tuples(st.just("thrusters"), st.frozensets(st.integers(0, 2))),
    st.tuples(st.just("achieved"), st.tuples(st.floats(-60.0, 60.0), st.floats(-30.0, 30.0), st.floats(-40.0, 40.0))),
    st.tuples(st.just("start"), st.none()),
)


def at_setpoint(nav: NavState, setpoint: Any) -> NavState:
    if isinstance(setpoint, PoseSetpoint):
        return replace(
            nav, north_m=setpoint.north_m, east_m=setpoint.east_m, yaw_rad=setpoint.yaw_rad, surge_mps=0.0, sway_mps=0.0
        )
    c, s = math.cos(setpoint.yaw_rad), math.sin(setpoint.yaw_rad)
    way_m = 0.1 * setpoint.surge_mps
    return replace(nav, north_m=nav.north_m + c * way_m, east_m=nav.east_m + s * way_m, yaw_rad=setpoint.yaw_rad)


@settings(deadline=None, derandomize=True, max_examples=60)
@given(st.sampled_from(TOWARDS), st.floats(-math.pi, math.pi), st.lists(steps, min_size=3, max_size=12))
def test_any_sequence(towards: tuple[float, float], yaw_rad: float, sequence: list[tuple[str, Any]]) -> None:
    docking = Docking(REVOLT, Parameters(), EventLog())
    berth = Berth(3.0, -2.0, yaw_rad, towards, 0.5, 2.0)
    north_m, east_m, _ = berth.pose(6.0)
    inputs = ModeInputs(replace(NAV, north_m=north_m, east_m=east_m), None, None, 0.6, 0.0, 0.1)
    assert docking.start(berth, inputs) is None
    for name, value in sequence:
        if name == "jump":
            north, east, yaw, surge, sway = value
            inputs = replace(
                inputs, nav=replace(inputs.nav, north_m=north, east_m=east, yaw_rad=yaw, surge_mps=surge, sway_mps=sway)
            )
        elif name == "accuracy":
            inputs = replace(inputs, nav=replace(inputs.nav, position_accuracy_m=value))
        elif name == "thrusters":
            inputs = replace(inputs, failed=value)
        elif name == "achieved":
            inputs = replace(inputs, achieved=Wrench(*value))
        elif name == "start":
            refused = docking.start(berth, inputs)
            assert (refused is not None) == (
                bool(inputs.failed) or berth.place(inputs.nav.north_m, inputs.nav.east_m)[0] < -0.5
            )
        for _ in range(value if name in ("follow", "stuck") else 1):
            before = docking.phase
            inputs = replace(inputs, now_s=inputs.now_s + 0.1)
            setpoint = docking.update(inputs)
            motion = desired_motion(setpoint)
            place = (None, None) if motion.place is None else astuple(motion.place)
            parts = (*place, motion.yaw_rad, motion.surge_mps, motion.sway_mps, motion.yaw_rate_radps)
            assert all(part is not None and math.isfinite(part) for part in parts)
            if inputs.failed or before is DockingPhase.ABORTED:
                assert docking.phase in (DockingPhase.ABORTED, DockingPhase.PUSH)
            if docking.phase is DockingPhase.PUSH and before is not DockingPhase.PUSH:
                assert berth.place(inputs.nav.north_m, inputs.nav.east_m)[0] < 0.4
            if name == "follow":
                inputs = replace(inputs, nav=at_setpoint(inputs.nav, setpoint))
