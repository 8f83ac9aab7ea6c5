"""Whatever is asked in whatever order, with whatever the sensors say: the supervisor never raises, and a disarmed boat
is neutral."""

from __future__ import annotations

import math
from dataclasses import astuple, replace
from typing import Any

from hypothesis import example, given, settings
from hypothesis import strategies as st

from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import Wrench
from companion.core.decision import Home, ModeId, Outcome
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.readings import Battery, FixType, Leak, ManualInput, RcInput
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint, desired_motion
from companion.core.tick import DeviceHealth, Inputs
from companion.mission.executor import MissionExecutor
from companion.mission.plan import PlanItem, PlanKind, Plans
from companion.params.store import Parameters
from companion.supervisor.supervisor import Supervisor

REVOLT, ABOAT = load(find("revolt")), load(find("aboat"))
NAV = NavState(
    0.0, True, True, 63.4389, 10.399, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    0.02, 0.02, 0.01, 0.0, 0.0, 0.0, FixType.RTK_FIXED, 14, 0.7, None,
)  # fmt: skip

any_number = st.floats(allow_nan=True, allow_infinity=True, width=32)
offset_m = st.floats(-60.0, 60.0)
stick = st.one_of(st.none(), st.floats(-1.0, 1.0), any_number)
switch = st.sampled_from((-1.0, 0.0, 1.0))

steps = st.one_of(
    st.tuples(st.just("mode"), st.sampled_from(ModeId)),
    st.tuples(st.just("arm"), st.booleans()),
    st.tuples(st.just("arm"), st.just(True)),
    st.tuples(st.just("disarm"), st.booleans()),
    st.tuples(st.just("go_to"), offset_m, offset_m, st.one_of(st.none(), any_number), st.one_of(st.none(), any_number)),
    st.tuples(st.just("go_anywhere"), any_number, any_number),
    st.tuples(st.sampled_from(("hold_here", "pause", "resume", "terminate"))),
    st.tuples(st.just("start_mission"), st.one_of(st.none(), st.integers(-2, 6))),
    st.tuples(st.just("nudge"), st.floats(-4.0, 4.0), any_number, st.floats(-1.0, 1.0)),
    st.tuples(st.just("set_heading"), any_number),
    st.tuples(st.just("thrusters"), st.integers(0, 2), st.booleans(), st.floats(-30.0, 30.0)),
    st.tuples(st.just("lower"), st.booleans(), st.booleans()),
    st.tuples(st.just("set_current"), st.integers(-2, 6), st.booleans()),
    st.tuples(st.just("change_speed"), st.one_of(st.none(), any_number)),
    st.tuples(st.just("set_home"), st.one_of(st.none(), st.tuples(any_number, any_number))),
    st.tuples(st.just("sticks"), stick, stick, stick),
    st.tuples(
        st.just("upload"),
        st.lists(st.tuples(st.sampled_from((16, 17, 19, 20, 21, 93, 115, 178, 179)), offset_m, offset_m), max_size=4),
    ),
    st.tuples(
        st.just("parameter"),
        st.sampled_from(("MIS_DONE_ACT", "FS_POS_ACT", "NAV_DLL_ACT", "FS_LEAK_ACT", "ARM_CHECKS", "WP_YAW_MODE")),
        st.integers(0, 3),
    ),
    st.tuples(
        st.just("parameter"),
        st.sampled_from(("WP_LAW", "PATH_CTRL", "DP_LAW", "PATH_KIND", "GF_ACTION", "FENCE_GROUP0", "FENCE_MARGIN")),
        st.integers(0, 3),
    ),
    st.tuples(st.just("world"), st.booleans(), st.booleans(), st.booleans(), st.booleans(), st.floats(0.0, 1.0)),
    st.tuples(st.just("rc"), st.one_of(st.none(), st.tuples(stick, stick, stick, stick, switch))),
    st.tuples(st.just("move"), offset_m, offset_m, st.floats(-math.pi, math.pi), st.floats(-3.0, 3.0)),
    st.tuples(st.just("broken_estimate")),
    st.tuples(st.just("ticks"), st.integers(1, 30)),
    st.tuples(st.just("silence"), st.floats(0.5, 20.0)),
)

zones = st.lists(st.tuples(st.booleans(), offset_m, offset_m, st.floats(0.5, 50.0)), max_size=3)
fenced_steps = st.one_of(steps, steps, steps, st.tuples(st.just("fence"), zones))


class World:
    def __init__(self, config: VesselConfig) -> None:
        self.config = config
        self.frame = LocalFrame(63.4389, 10.399)
        self.parameters = Parameters()
        self.plans = Plans()
        events = EventLog()
        self.supervisor = Supervisor(
            config, self.parameters, self.plans, MissionExecutor(self.plans), events, lambda: self.frame
        )
        self.now_s = 0.0
        self.nav = NAV
        self.inputs = Inputs()
        self.ok = True

    def do(self, name: str, *values: Any) -> None:
        supervisor, now = self.supervisor, self.now_s
        before = (supervisor.status(now).mode, supervisor.status(now).armed, supervisor.version)
        outcome: Any = None
        match name:
            case "mode":
                outcome = supervisor.request_mode(values[0], now)
            case "arm" | "disarm":
                outcome = getattr(supervisor, name)(now, values[0])
            case "go_to":
                outcome = supervisor.go_to(*self.frame.to_geodetic(values[0], values[1]), values[2], values[3], now)
            case "go_anywhere":
                outcome = supervisor.go_to(values[0], values[1], None, None, now)
            case "hold_here" | "pause" | "resume" | "terminate":
                outcome = getattr(supervisor, name)(now)
            case "start_mission" | "change_speed":
                outcome = getattr(supervisor, name)(values[0], now)
            case "nudge":
                outcome = supervisor.nudge(*values, now)
            case "set_heading":
                outcome = supervisor.set_heading(values[0], now)
            case "thrusters":
                supervisor.thruster_failed(values[0] % len(self.config.thrusters), values[1])
                supervisor.thrust_achieved(Wrench(values[2], -values[2], values[2]))
            case "lower":
                outcome = supervisor.lower_thrusters(values[0], now)
                up = {i for i, thruster in enumerate(self.config.thrusters) if thruster.retractable}
                supervisor.retraction.see(frozenset(up) if values[1] else frozenset(), now)
            case "set_current":
                outcome = supervisor.set_current(values[0], values[1], now)
            case "set_home":
                outcome = supervisor.set_home(None if values[0] is None else Home(*values[0], 0.0), now)
            case "sticks":
                supervisor.manual_input(ManualInput(now, "gcs", *values))
            case "upload":
                self.plans.replace(PlanKind.MISSION, [self.item(seq, *row) for seq, row in enumerate(values[0])])
            case "fence":
                zones = [
                    replace(self.item(seq, 5003 if keep else 5004, *row), frame=0, param1=row[2])
                    for seq, (keep, *row) in enumerate(values[0])
                ]
                self.plans.replace(PlanKind.FENCE, zones)
            case "parameter":
                self.parameters.set(values[0], values[1])
            case "world":
                self.nav = replace(self.nav, position_valid=values[0], heading_valid=values[1])
                self.ok = values[2]
                self.inputs = replace(
                    self.inputs, leak=Leak(now, "l", values[3]), battery=Battery(now, "b", 12.0, None, values[4])
                )
            case "rc":
                channels = None if values[0] is None else tuple(0.0 if v is None else v for v in values[0])
                self.inputs = replace(
                    self.inputs, rc=None if channels is None else RcInput(now, "rc", channels, lost=False)
                )
            case "move":
                north, east, yaw, surge = values
                self.nav = replace(self.nav, north_m=north, east_m=east, yaw_rad=yaw, surge_mps=surge)
            case "broken_estimate":
                self.nav = replace(self.nav, north_m=math.nan, yaw_rad=math.inf, surge_mps=math.nan)
            case "ticks":
                for _ in range(values[0]):
                    self.tick(0.1)
            case "silence":
                self.tick(values[0])
        if outcome is not None:
            assert isinstance(outcome, Outcome) and (outcome.accepted or outcome.reason)
        if name != "arm":
            assert before[1] or not supervisor.status(now).armed, f"{name} armed the boat"
        after = supervisor.status(now)
        assert (after.mode, after.armed) == before[:2] or supervisor.version > before[2]

    def item(self, seq: int, command: int, north_m: float, east_m: float, *_: float) -> PlanItem:
        lat, lon = self.frame.to_geodetic(north_m, east_m)
        x, y = (round(lat * 1e7), round(lon * 1e7)) if command in (16, 17, 19, 21, 179, 5003, 5004) else (0, 0)
        param1 = 1.0 if command == 178 else 2.0 if command in (19, 93) else 0.0
        return PlanItem(seq, command, 3, param1, 0.5 if command == 178 else 0.0, 0.0, 0.0, x, y, 0.0)

    def tick(self, dt_s: float) -> None:
        self.now_s += dt_s
        if dt_s <= 0.1:
            self.supervisor.ground_station_heard(self.now_s)
            if self.inputs.rc is not None:
                self.inputs = replace(self.inputs, rc=replace(self.inputs.rc, t_s=self.now_s))
        health = [DeviceHealth("microcontroller", self.ok, 0.0), DeviceHealth("gnss", True, 0.0)]
        status = self.supervisor.update(replace(self.nav, t_s=self.now_s), self.inputs, health, self.now_s)
        if (
            status.armed
            and status.mode is not ModeId.MANUAL
            and any(thruster.retractable for thruster in self.config.thrusters)
        ):
            assert self.supervisor.retraction.lower is True
        setpoint = self.supervisor.guide(self.nav, self.now_s, 0.1)
        if not status.armed or not self.supervisor.status(self.now_s).armed:
            assert isinstance(setpoint, NeutralSetpoint)
        following = status.armed and status.mode is ModeId.FOLLOW
        assert status.mode is not ModeId.OFFBOARD
        if following and not self.supervisor.following.awaits:  # there is no leader
            assert isinstance(setpoint, NeutralSetpoint), "a more severe failsafe has stopped it"
        motion = desired_motion(setpoint)
        place = () if motion.place is None else astuple(motion.place)
        for value in (*place, motion.yaw_rad, motion.surge_mps, motion.sway_mps):
            assert value is None or math.isfinite(value)
        if isinstance(setpoint, PoseSetpoint | PathSetpoint):
            assert not status.mode.value.startswith(("Manual", "Forces", "Heading"))


@settings(deadline=None, derandomize=True, max_examples=100)
@given(st.lists(steps, min_size=20, max_size=60))
@example([("mode", ModeId.FOLLOW), ("world", True, True, False, True, 0.0), ("silence", 10.0)])
@example([("mode", ModeId.FOLLOW), ("world", False, True, True, False, 1.0), ("silence", 10.0), ("ticks", 5)])
def test_any_sequence_of_requests(sequence: list[tuple[Any, ...]]) -> None:
    carry_out(REVOLT, sequence)


@settings(deadline=None, derandomize=True, max_examples=12)
@given(st.lists(fenced_steps, min_size=20, max_size=40))
def test_any_sequence_of_requests_to_a_boat_with_a_fence_and_no_berth(sequence: list[tuple[Any, ...]]) -> None:
    carry_out(ABOAT, sequence)


def carry_out(config: VesselConfig, sequence: list[tuple[Any, ...]]) -> None:
    world = World(config)
    world.tick(0.1)
    world.do("upload", [(16, 20.0, 0.0), (19, 20.0, 20.0), (16, 0.0, 20.0)])
    world.do("arm", False)
    for name, *values in sequence:
        world.do(name, *values)
        world.tick(0.1)
