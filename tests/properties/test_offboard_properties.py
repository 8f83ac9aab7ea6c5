"""Whatever another computer sends, in whatever mask, frame and numbers: nothing raises, a disarmed boat stays still, an
armed one keeps its limits."""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import Any

from hypothesis import example, given, settings
from hypothesis import strategies as st

from companion.config.vessel import VesselConfig, find, load
from companion.core.decision import ModeId
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.setpoint import NeutralSetpoint, PoseSetpoint, desired_motion
from companion.core.tick import DeviceHealth, Inputs
from companion.io.mavlink.services.offboard_codec import read_global, read_local
from companion.io.mavlink.wire import messages as mavlink
from companion.mission.executor import MissionExecutor
from companion.mission.plan import PlanItem, PlanKind, Plans
from companion.params.store import Parameters
from companion.supervisor.supervisor import Supervisor
from tests.properties.test_supervisor_requests import NAV

VESSELS = [load(find(name)) for name in ("revolt", "aboat", "rescuerunner")]
FRAME = LocalFrame(63.4389, 10.399)

number = st.one_of(st.floats(width=32), st.floats(-20.0, 20.0, width=32), st.just(0.0))
usual = st.sampled_from((0x9F8, 0x9C7, 0x5C7, 0xC3F, 0x9C0, 0x800, 0x5F8, 3576, 4039, 0x9FF, 0x5FF))
mask = st.one_of(usual, usual, st.integers(0, 0xFFFF))
numbers = st.tuples(*[number] * 11)
local = st.builds(
    lambda frame, mask, values: mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *values),
    st.one_of(st.sampled_from((1, 7, 8, 9, 12)), st.integers(0, 255)), mask, numbers,
)  # fmt: skip
degrees = st.one_of(st.integers(-(2**31), 2**31 - 1), st.integers(-9000, 9000))
world = st.builds(
    lambda frame, mask, lat, lon, values: mavlink.MAVLink_set_position_target_global_int_message(
        0,
        1,
        1,
        frame,
        mask,
        lat if abs(lat) > 9000 else 634389000 + lat,
        lon if abs(lon) > 9000 else 103990000 + lon,
        *values[:9],
    ),
    st.sampled_from((0, 3, 5, 6, 11)),
    mask,
    degrees,
    degrees,
    numbers,
)
steps = st.lists(st.tuples(st.one_of(local, local, world), st.integers(1, 6)), min_size=1, max_size=12)


class World:
    def __init__(self, config: VesselConfig, fenced: bool) -> None:
        self.parameters = Parameters(config.parameters)
        self.plans = Plans()
        self.events = EventLog()
        self.supervisor = Supervisor(
            config, self.parameters, self.plans, MissionExecutor(self.plans), self.events, lambda: FRAME
        )
        self.health = [DeviceHealth(device.name, True, 0.0) for device in (*config.sensors, *config.actuators)]
        self.now_s = 0.0
        if fenced:
            self.plans.replace(PlanKind.FENCE, [PlanItem(0, 5003, 0, 30.0, 0.0, 0.0, 0.0, 634389000, 103990000, 0.0)])

    def tick(self) -> Any:
        self.now_s += 0.1
        self.supervisor.update(NAV, Inputs(), self.health, self.now_s)
        setpoint = self.supervisor.guide(NAV, self.now_s, 0.1)
        failed = [event.text for event in self.events.drain() if event.name in ("mode_failed", "guard_failed")]
        assert not failed
        return setpoint

    def give(self, message: Any) -> None:
        sent = message.get_type() == "SET_POSITION_TARGET_LOCAL_NED"
        target = read_local(message) if sent else read_global(message, FRAME)
        if not isinstance(target, str):
            self.supervisor.offboard_setpoint(target, self.now_s)


@settings(deadline=None, derandomize=True, max_examples=120)
@given(st.sampled_from(VESSELS), st.booleans(), st.booleans(), steps)
@example(
    VESSELS[0],
    True,
    False,
    [(mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, 1, 0x9C7, *[3e38] * 11), 3)],
)
@example(
    VESSELS[2],
    True,
    False,
    [(mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, 8, 0x5C7, *[-3e38] * 11), 3)],
)
def test_any_setpoint(config: VesselConfig, armed: bool, fenced: bool, sequence: list[tuple[Any, int]]) -> None:
    there = World(config, fenced)
    there.tick()
    if armed:
        assert there.supervisor.arm(there.now_s, force=True).accepted
    for message, ticks in sequence:
        there.give(message)
        there.supervisor.request_mode(ModeId.OFFBOARD, there.now_s)
        for _ in range(ticks):
            setpoint = there.tick()
            if not armed:
                assert isinstance(setpoint, NeutralSetpoint) and not there.supervisor.status(there.now_s).armed
            motion = desired_motion(setpoint)
            place = () if motion.place is None else astuple(motion.place)
            for value in (*place, motion.yaw_rad, motion.surge_mps2, motion.sway_mps2, motion.yaw_radps2):
                assert value is None or math.isfinite(value)
            assert math.hypot(motion.surge_mps, motion.sway_mps) <= there.parameters["MPC_XY_VEL_MAX"] + 1e-6
            if isinstance(setpoint, PoseSetpoint):
                assert math.hypot(setpoint.north_m, setpoint.east_m) < 4.0, (
                    "the boat stands: its reference waits for it"
                )
