"""The supervisor's parts, what they have seen of the boat, and the views that they are given."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from companion.allocation.propulsion import keeps_straight, lost_motions
from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH
from companion.core.decision import ModeId, ModeInputs, Outcome
from companion.core.estimate import NO_ESTIMATE, Contact, Leader
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.ports import Worker
from companion.core.tick import DeviceHealth, Inputs
from companion.fence.guard import FenceGuard
from companion.following.relative_tracker import RelativeTracker
from companion.following.tracker import FORGET_S, LeaderTracker
from companion.guidance.own_track import OwnTrack
from companion.guidance.sailing import Sailor
from companion.mission.executor import MissionExecutor
from companion.mission.plan import Plans
from companion.modes.hold import HoldMode
from companion.modes.mission import MissionMode
from companion.modes.offboard import OffboardMode
from companion.modes.table import build_modes, mode_of
from companion.modes.trial.mode import TrialMode
from companion.obstacles.chart_water import ChartKeeper
from companion.obstacles.charted_fence import ChartedFence
from companion.obstacles.guard import ObstacleGuard
from companion.obstacles.surroundings import Surroundings
from companion.params.store import Parameters
from companion.supervisor.authority import AuthorityRequest, Facts, RequestedAction, refusal
from companion.supervisor.calibration import CalibrationDuty
from companion.supervisor.computer import ComputerWatch
from companion.supervisor.cruise import Cruise
from companion.supervisor.fence_duty import FenceDuty
from companion.supervisor.follow_duty import FollowDuty
from companion.supervisor.ground_stations import GroundStations
from companion.supervisor.helm import Helm
from companion.supervisor.homing import HomeKeeper
from companion.supervisor.hull_watch import HullWatch
from companion.supervisor.mission_actions import MissionActions
from companion.supervisor.mission_duty import MissionDuty
from companion.supervisor.mode_changes import Cause
from companion.supervisor.motor_test import MotorTest
from companion.supervisor.nudges import Nudges
from companion.supervisor.outlook_duty import OutlookDuty
from companion.supervisor.outputs import AuxiliaryOutputs
from companion.supervisor.payload import Payload
from companion.supervisor.range_watch import RangeWatch
from companion.supervisor.responder import Responder
from companion.supervisor.retraction import Retraction
from companion.supervisor.senses import Senses
from companion.supervisor.situation import Situation, Source
from companion.supervisor.standstill import Standstill
from companion.supervisor.sticks import Sticks, is_centred
from companion.supervisor.switch_faults import kill_switch_fault
from companion.supervisor.switches import Switches
from companion.supervisor.trial_duty import TrialDuty
from companion.supervisor.unmeasured import Unmeasured
from companion.traffic.distress import DistressWatch
from companion.traffic.guard import TrafficGuard
from companion.traffic.tracker import TrafficTracker, contact


class SupervisorParts:
    """One of each. Remembers what was seen last: the estimate `nav`, `inputs`, device `health`, the wrenches
    `achieved` and `demanded`, indices of `failed` thrusters, and how many `choices` people have made, `go_tos` in Hold
    among them."""

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        plans: Plans,
        executor: MissionExecutor,
        events: EventLog,
        frame_of: Callable[[], LocalFrame],
        choose: Callable[[ModeId, float, Cause], Outcome],
    ) -> None:
        """`frame_of()`: the local plane of the estimate. `choose(mode, now_s, cause)`: a person's choice of a mode."""
        self.config, self.parameters, self.executor, self.events = config, parameters, executor, events
        self.frame_of = frame_of
        self.nav, self.inputs = NO_ESTIMATE, Inputs()
        self.health: Sequence[DeviceHealth] = ()
        self.achieved, self.demanded = ZERO_WRENCH, ZERO_WRENCH
        self.steers_late_s, self.turn_resistance, self.choices, self.go_tos = 0.0, 1.0, 0, 0
        self.failed: frozenset[int] = frozenset()
        self._bridges = frozenset(bridge.name for bridge in config.actuators)
        self.traffic, self.distress = TrafficTracker(config.mmsi), DistressWatch(events.say)
        self.leader, self.relative = LeaderTracker(), RelativeTracker(config, parameters, events.say)
        self.home = HomeKeeper(events)
        self.fence = FenceGuard(config, parameters, plans, events, frame_of, lambda: self.home.home)
        self.surroundings = around = Surroundings(config, parameters, events, frame_of)
        self.chart = ChartKeeper(config, parameters, frame_of)
        self.obstacles = aside = ObstacleGuard(config, parameters, around, self.fence, events, self.chart)
        clear = around.movers, aside.water.line_refusal
        self.traffic_guard = TrafficGuard(config, parameters, self.traffic, events, frame_of, self.fence, *clear)
        self.sailor = _sailor(config, parameters, events, self.fence)
        self.track = OwnTrack(frame_of)
        self.charted = charted = ChartedFence(config, parameters, plans, frame_of, self.fence, self.chart)
        modes = build_modes(config, parameters, plans, executor, events, frame_of, charted, self.track)
        self.hold = hold = mode_of(modes, HoldMode)
        self.mission = mission = mode_of(modes, MissionMode)
        self.offboard = mode_of(modes, OffboardMode)
        self.trial = mode_of(modes, TrialMode)
        self._with_source = tuple(mode for mode in modes.values() if mode.declaration.failsafe is not None)
        self.computer = ComputerWatch(1.0 / config.control_rate_hz, parameters, events.say)
        self.cruise = Cruise(parameters)
        self.auxiliary = AuxiliaryOutputs(config, events)
        self.payload = Payload(config, parameters, plans, self.auxiliary, events, frame_of)
        self.sticks = Sticks(parameters)
        self.switches = Switches(parameters, events)
        self.ground_stations = GroundStations(config.operators)
        self.helm = helm = Helm(modes, self.sticks, events, self.mode_inputs)
        self.following = FollowDuty(config, parameters, helm, self.sticks, events, choose, self.refusal)
        actions = MissionActions(self.cruise, self.home, self.fence, self.auxiliary, self.following, self.payload)
        self.mission_duty = MissionDuty(parameters, executor, mission, hold, helm, self.following, actions, events)
        self.fence_duty = FenceDuty(self.fence, plans, helm, mission, events)
        self.trial_duty = TrialDuty(parameters, helm, events)
        self.outlook = OutlookDuty(parameters, plans, executor, mission, helm, self.cruise, self.home, events)
        self.nudges = Nudges(config, parameters, helm, hold, events)
        self.retraction = Retraction(config, parameters, helm, events)
        self.senses = Senses(events)
        self.unmeasured, self.standstill = Unmeasured(events), Standstill(events)
        self.hull = HullWatch(config, parameters)
        self.range = RangeWatch(config, parameters, lambda: self.cruise.speed_mps)
        self.calibration = CalibrationDuty(config, parameters, helm, events, lambda: self.nav)
        self.motor_test = MotorTest(config, events, self.motor_objection)
        self.responder = Responder(helm, hold, self.sticks, events, self.situation)

    def work_with(self, worker: Worker) -> None:
        """Let `worker` do what takes longer than a tick."""
        for part in (self.fence, self.chart, self.obstacles, self.charted):
            part.work_with(worker)

    def watch_hull(self, desired_mps: float | None, now_s: float) -> None:
        """Once a tick: hull, range, track. `desired_mps`: speed ahead of the last setpoint of a mode without sticks;
        None where it asks for forces."""
        self.track.update(self.nav, self.helm.armed)
        by_itself = self.helm.armed and not self.helm.mode.by_stick
        wanted_mps = desired_mps if by_itself else 0.0
        self.hull.update(self.nav, self.inputs.depth, wanted_mps, self.achieved.surge_n, now_s)
        self.range.update(self.nav, self.inputs.battery, self.home.home, by_itself, now_s)

    # --- views -----------------------------------------------------------------------------------------------------

    def refusal(self, request: AuthorityRequest, now_s: float) -> str | None:
        """Why `request` is refused now; "" where it is ignored, None where it is obeyed (`authority.py`)."""
        return refusal(request, self.facts(now_s))

    def facts(self, now_s: float) -> Facts:
        """What it depends on now who is obeyed."""
        parameters, sticks, ground_stations = self.parameters, self.sticks, self.ground_stations
        following, mode = self.following, self.helm.mode
        live = sticks.live(now_s) if mode.by_stick else None
        return Facts(
            kill_switch=self.switches.killed,
            safe_switch=sticks.safe_switch,
            transmitter_live=sticks.transmitter_live(now_s),
            operators=ground_stations.operators,
            in_control=ground_stations.in_control,
            takeover=ground_stations.takeover,
            chosen_sticks=int(parameters["MAN_GCS_SYSID"]),
            steering=ground_stations.steering,
            steering_live=now_s - ground_stations.steered_s <= parameters["COM_RC_LOSS_T"],
            remote_system=sticks.remote_system,
            module=following.module,
            lead_boat_decides=bool(parameters["FOLL_AUTH"]),
            wish=following.wish,
            chosen_leader=int(parameters["FOLL_SYSID"]),
            leader=self.leader.system_id,
            leader_silent=self.leader.silent_s(now_s) >= FORGET_S,
            followed=following.followed,
            mode=mode.id,
            intended=self.helm.intended.id,
            sticks_moved=live is not None and not is_centred(live),
        )

    def motor_objection(self, index: int, now_s: float) -> str | None:
        """Why a thruster may not run in a motor test now, or None."""
        thruster = self.config.thrusters[index]
        if self.helm.armed:
            return "disarm first"
        if (reason := self.refusal(AuthorityRequest(RequestedAction.ARM), now_s)) is not None:
            return reason
        if index in self.retraction.up:
            return f"lower {thruster.name} first"
        drives = {bridge.name for bridge in self.config.actuators if thruster.name in bridge.thrusters}
        ill = next((device for device in self.health if device.name in drives and not device.ok), None)
        return None if ill is None else f"{ill.name}: {ill.text or 'no data'}"

    def mode_inputs(self, now_s: float, dt_s: float) -> ModeInputs:
        """What modes see of a tick."""
        return ModeInputs(
            nav=self.nav,
            manual=self.sticks.obeyed(now_s),
            home=self.home.home,
            speed_mps=self.cruise.speed_mps,
            now_s=now_s,
            dt_s=dt_s,
            achieved=self.achieved,
            demanded=self.demanded,
            steers_late_s=self.steers_late_s,
            turn_resistance=self.turn_resistance,
            failed=self.failed,
            up=self.retraction.up,
            leader=self.leader_now(now_s),
            leader_fault=self.following.fault(self.nav, now_s),
            station=self.following.follow_position,
            order=self.helm.order,
            contacts=self._contacts(now_s) if self.helm.mode is self.trial else (),
        )

    def leader_now(self, now_s: float) -> Leader | None:
        """The lead boat, where it is relative to this one."""
        leader = self.leader.leader(self.frame_of(), now_s)
        return None if leader is None else self.relative.placed(leader)

    def see_leader(self, now_s: float) -> None:
        """Once a tick, with the newest estimate: where the lead boat is relative to this one."""
        frame = self.frame_of()
        self.relative.update(self.leader.leader(frame, now_s), self.leader.fix, self.nav, frame, now_s)

    def _contacts(self, now_s: float) -> tuple[Contact, ...]:
        """The vessels around whose place is known."""
        seen = (contact(target, self.frame_of(), now_s) for target in self.traffic.targets)
        return tuple(one for one in seen if one is not None)

    def situation(self, now_s: float) -> Situation:
        """What arming checks and failsafes see."""
        helm, thrusters, facts = self.helm, self.config.thrusters, self.facts(now_s)
        return Situation(
            now_s=now_s,
            nav=self.nav,
            inputs=self.inputs,
            bridges={device.name: device for device in self.health if device.name in self._bridges},
            sensors={device.name: device for device in self.health if device.name not in self._bridges},
            parameters=self.parameters,
            armed=helm.armed,
            mode=helm.mode,
            intended=helm.intended,
            mode_refusal=None if helm.armed else helm.refusal(helm.mode.id, self.nav, now_s),
            sticks_age_s=self.sticks.age_s(now_s) if self.sticks.heard else None,
            ground_station_age_s=self.ground_stations.age_s(now_s),
            authority=facts,
            failed_thrusters=tuple(thrusters[i].name for i in sorted(self.failed)),
            lost_motions=lost_motions(thrusters, self.failed),
            keeps_straight=keeps_straight(thrusters, self.failed),
            kill_switch_fault=kill_switch_fault(self.parameters, self.switches.channels),
            fence=self.fence.cause,
            silent_ranges=self.surroundings.silent,
            ticks_late=self.computer.ticks_late,
            worst_late_s=self.computer.worst_s,
            tilt_rad=self.hull.tilt_rad,
            aground_or_fouled=self.hull.aground_or_fouled,
            depth_m=self.hull.depth_m,
            home_share=self.range.need,
            range_short=self.range.short,
            rests=self.mission_duty.rests,
            fence_preparing=self.fence.preparing,
            sources=self._sources(facts, now_s),
        )

    def _sources(self, facts: Facts, now_s: float) -> dict[ModeId, Source]:
        """What modes steer by. Of the leader the duty knows more than the mode."""
        sources = {mode.id: Source(mode.loss(now_s)) for mode in self._with_source}
        return sources | {ModeId.FOLLOW: self.following.sight(self.nav, facts, now_s)}


def _sailor(config: VesselConfig, parameters: Parameters, events: EventLog, fence: FenceGuard) -> Sailor | None:
    """Who steers a boat with a sail; None for another boat."""
    return Sailor(config, parameters, events.say, fence.may_move_to) if config.has_sail else None
