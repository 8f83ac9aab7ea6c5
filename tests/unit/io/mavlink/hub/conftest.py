"""A hub on memory links with a vessel that writes down what it is asked, and ground stations that speak and hear
bytes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import pytest

from companion.config.payload import CameraConfig
from companion.core.actuation import ZERO_WRENCH, ActuatorCommand, Allocation, ThrusterCommand
from companion.core.arming import ArmingCheck, ArmingFinding, ArmingReport
from companion.core.decision import ACCEPTED, Home, MissionProgress, MissionState, ModeId, Order, Outcome, Status
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.readings import AisTarget, LeaderState, ManualInput
from companion.core.setpoint import NEUTRAL_SETPOINT
from companion.core.tick import Inputs, Tick
from companion.core.work import AtOnce
from companion.io.mavlink.assembly import default_services
from companion.io.mavlink.telemetry.streams import Telemetry
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, frame, pack
from companion.io.mavlink.wire.hub import Copies, Hub
from companion.io.mavlink.wire.links import MemoryLink
from companion.loop import NoStorage
from companion.mission.plan import Plans
from companion.modes.table import DECLARATIONS
from companion.params.store import Parameters
from companion.supervisor.authority import AuthorityRequest, Facts, refusal
from companion.supervisor.calibration import CalibrationKind, CalibrationState
from companion.supervisor.ground_stations import GroundStations
from companion.supervisor.outputs import AuxiliaryOutputs
from companion.supervisor.payload import Payload
from tests.unit.estimates import AT_REST

UNIX_NS = 1_780_000_000_000_000_000


class FakeMode:
    def __init__(self, mode: ModeId, selectable: bool = True) -> None:
        self.declaration = replace(DECLARATIONS[mode], selectable=selectable)
        self.text = ""


def still(t_s: float) -> NavState:
    return replace(
        AT_REST,
        t_s=t_s,
        lat_deg=63.44,
        lon_deg=10.4,
        altitude_m=1.5,
        north_m=3.0,
        east_m=-4.0,
        roll_rad=0.01,
        pitch_rad=-0.02,
        yaw_rad=1.0,
        surge_mps=0.5,
        sway_mps=0.1,
        north_mps=0.3,
        east_mps=0.4,
        roll_rate_radps=0.001,
        pitch_rate_radps=0.002,
        yaw_rate_radps=0.003,
        position_accuracy_m=0.05,
        position_age_s=0.05,
        heading_age_s=0.05,
        imu_age_s=0.01,
        satellites=17,
        hdop=0.8,
    )


class FakeCalibration:
    """Keeps what is asked of it; `state` is what it shows."""

    def __init__(self, take: Callable[..., Outcome]) -> None:
        self._take = take
        self.state: CalibrationState | None = None

    def request(self, kind: CalibrationKind, now_s: float, save: bool = True, bits: int = 0) -> Outcome:
        return self._take("calibrate", kind, save, *([bits] if bits else []))

    def accept(self, now_s: float) -> Outcome:
        return self._take("accept")

    def cancel(self, now_s: float) -> Outcome:
        return self._take("cancel")


class FakeSupervisor:
    """Accepts everything, or answers with `outcome`; keeps (name, arguments) in `asked`. Authority is the real one."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.ground_stations = GroundStations()
        self.version = 0
        self.modes: tuple[FakeMode, ...] = tuple(map(FakeMode, DECLARATIONS))
        self.outcome: Outcome = ACCEPTED
        self.asked: list[tuple[Any, ...]] = []
        self.sticks: list[ManualInput] = []
        self.heard = 0
        self.remote_system: int | None = None
        self.module: int | None = None
        self.setpoints_refused: str | None = None
        self.setpoints_missing: str | None = "no setpoint"
        self.reports: list[AisTarget] = []
        self.calibration = FakeCalibration(self._take)
        self.senses = SimpleNamespace(request=lambda accept, now_s: self._take("senses", accept))
        self.findings: tuple[ArmingFinding, ...] = ()
        self.landing = SimpleNamespace(
            take_off=lambda now_s: self._take("take_off"), land=lambda place, now_s: self._take("land", place)
        )
        self.guided = SimpleNamespace(choose=lambda now_s: self.request_mode(ModeId.HOLD, now_s))
        self.payload: Payload
        self.mission_edits = SimpleNamespace(under_way=False, due=lambda: None)
        self.surroundings = SimpleNamespace(on=False)
        self.now = Status(
            0.0,
            ModeId.HOLD,
            ModeId.HOLD,
            False,
            (),
            (),
            Home(63.44, 10.4, 1.0, 0.5),
            MissionProgress(MissionState.NOT_STARTED, 0, 3),
        )

    @property
    def armed(self) -> bool:
        return self.now.armed

    def status(self, now_s: float) -> Status:
        return replace(self.now, t_s=now_s)

    def arming_report(self, now_s: float) -> ArmingReport:
        free = frozenset(ModeId) if not any(finding.blocks for finding in self.findings) else frozenset()
        return ArmingReport(self.findings, free, frozenset(ModeId), frozenset(ArmingCheck))

    def change(self, **changes: Any) -> None:
        self.now = replace(self.now, **changes)
        self.version += 1

    def leader_heard(self, state: LeaderState) -> None:
        self._take("leader_heard", state)

    def _take(self, *asked: Any, **changes: Any) -> Outcome:
        self.asked.append(asked)
        if self.outcome.accepted and changes:
            self.change(**changes)
        return self.outcome

    def request_mode(self, mode: ModeId, now_s: float, order: Order | None = None) -> Outcome:
        how = () if order is None else (order,)
        return self._take("request_mode", mode, *how, mode=mode, intended_mode=mode)

    def give_order(self, order: Order, now_s: float) -> Outcome:
        return self._take("give_order", order, mode=order.mode, intended_mode=order.mode)

    def arm(self, now_s: float, force: bool = False) -> Outcome:
        return self._take("arm", force, armed=True)

    def disarm(self, now_s: float, force: bool = False) -> Outcome:
        return self._take("disarm", force, armed=False)

    def go_to(
        self, lat_deg: float, lon_deg: float, yaw_rad: float | None, speed_mps: float | None, now_s: float
    ) -> Outcome:
        return self._take("go_to", lat_deg, lon_deg, yaw_rad, speed_mps)

    def hold_here(self, now_s: float) -> Outcome:
        return self._take("hold_here")

    def nudge(self, forward_m: float, starboard_m: float, turn_rad: float, now_s: float) -> Outcome:
        return self._take("nudge", forward_m, starboard_m, turn_rad)

    def set_heading(self, yaw_rad: float, now_s: float) -> Outcome:
        return self._take("set_heading", yaw_rad)

    def lower_thrusters(self, lower: bool, now_s: float) -> Outcome:
        return self._take("lower_thrusters", lower)

    def start_mission(self, first: int | None, now_s: float) -> Outcome:
        return self._take("start_mission", first)

    def pause(self, now_s: float) -> Outcome:
        return self._take("pause")

    def resume(self, now_s: float) -> Outcome:
        return self._take("resume")

    def set_current(self, seq: int, reset: bool, now_s: float) -> Outcome:
        return self._take("set_current", seq, reset)

    def change_speed(self, speed_mps: float | None, now_s: float) -> Outcome:
        return self._take("change_speed", speed_mps)

    @property
    def auxiliary(self) -> FakeSupervisor:
        return self

    @property
    def following(self) -> FakeSupervisor:
        return self

    def refusal(self, request: AuthorityRequest, now_s: float) -> str | None:
        stations, parameters = self.ground_stations, self._parameters
        facts = Facts(
            operators=stations.operators,
            in_control=stations.in_control,
            takeover=stations.takeover,
            chosen_sticks=int(parameters["MAN_GCS_SYSID"]),
            steering=stations.steering,
            steering_live=now_s - stations.steered_s <= parameters["COM_RC_LOSS_T"],
            remote_system=self.remote_system,
            module=self.module,
            chosen_leader=int(parameters["FOLL_SYSID"]),
        )
        return refusal(request, facts)

    def set_follow_position(self, bearing_rad: float | None, distance_m: float | None, now_s: float) -> Outcome:
        return self._take("set_follow_position", bearing_rad, distance_m)

    def limit_offboard(self, most_s: float | None, most_m: float | None) -> Outcome:
        return self._take("limit_offboard", most_s, most_m)

    def follow(self, system_id: int | None, now_s: float) -> Outcome:
        return self._take("follow", system_id)

    def request(self, action: object, now_s: float) -> Outcome:
        return self._take("auxiliary", action)

    def set_home(self, home: Home | None, now_s: float) -> Outcome:
        return self._take("set_home", home)

    def manual_input(self, manual: ManualInput) -> None:
        self.sticks.append(manual)

    def traffic_heard(self, report: AisTarget, now_s: float) -> None:
        self.reports.append(report)

    def offboard_setpoint(self, target: Any, now_s: float, guided: bool = False) -> str | None:
        self.asked.append(("offboard_setpoint", target))
        return self.setpoints_refused

    def offboard_fault(self, now_s: float) -> str | None:
        return self.setpoints_missing

    def ground_station_heard(self, now_s: float) -> None:
        self.heard += 1

    def terminate(self, now_s: float) -> Outcome:
        return self._take("terminate", armed=False)


class FakeVessel:
    cameras: tuple[CameraConfig, ...] = ()

    def __init__(self) -> None:
        self.parameters = Parameters()
        self.supervisor = FakeSupervisor(self.parameters)
        self.plans = Plans()
        self.executor = None
        self.events = EventLog()
        self.config: Any = SimpleNamespace(
            name="revolt",
            title="ReVolt 1:20 model ship",
            length_m=3.0,
            operators=(),
            sensors=(),
            actuators=(),
            corrections=(),
            cameras=self.cameras,
            thrusters=(),
            servos=(),
            relays=(),
            limits=SimpleNamespace(surge_n=40.0, sway_n=20.0),
        )
        auxiliary = AuxiliaryOutputs(self.config, self.events)
        self.supervisor.payload = Payload(
            self.config, self.parameters, self.plans, auxiliary, self.events, lambda: LocalFrame(63.43, 10.39)
        )
        self.last_tick: Tick | None = None
        self.frame: LocalFrame | None = LocalFrame(63.43, 10.39)
        self.restarts = 0
        self.storage: Any = NoStorage()
        self.worker = AtOnce()
        self.waker = None

    def request_restart(self) -> None:
        self.restarts += 1


@dataclass
class Desk:
    """One ground station at the end of a memory link."""

    link: MemoryLink
    system: int = 255
    component: int = 190
    framer: Framer = field(default_factory=Framer)

    def send(self, *messages: Any) -> None:
        for message in messages:
            self.link.to_vessel(frame(pack(message), 0, self.system, self.component))

    def hear(self) -> list[Any]:
        return self.framer.feed(self.link.from_vessel())

    @property
    def endpoint(self) -> Any:
        return self.link.endpoints[0]


class Rig:
    """A hub with its vessel and one desk a link."""

    def __init__(
        self, urls: Sequence[str], tap: Callable[[Sequence[bytes]], None] | None = None, services: Any = None
    ) -> None:
        self.vessel = FakeVessel()
        self.desks = [Desk(MemoryLink(url), 255 - i) for i, url in enumerate(urls)]
        links = [desk.link for desk in self.desks]
        self.hub = Hub(
            self.vessel, links, "0.1.0", telemetry=Telemetry, services=services or default_services, copies=Copies(tap)
        )
        self.now_s = 0.0
        self.changes: dict[str, Any] = {}

    @property
    def supervisor(self) -> FakeSupervisor:
        return self.vessel.supervisor

    @property
    def desk(self) -> Desk:
        return self.desks[0]

    def tick(self, **changes: Any) -> Tick:
        """One tick a tenth of a second later; `changes` are fields of Tick."""
        self.now_s = round(self.now_s + 0.1, 9)
        self.hub.serve(self.now_s)
        thrusters = (ThrusterCommand(1.0, 0.2, 0.5), ThrusterCommand(1.0, -0.4, None))
        tick = Tick(
            t_s=self.now_s,
            time_unix_ns=UNIX_NS + round(self.now_s * 1e9),
            nav=still(self.now_s),
            status=self.supervisor.status(self.now_s),
            setpoint=NEUTRAL_SETPOINT,
            wrench=ZERO_WRENCH,
            allocation=Allocation(thrusters, ZERO_WRENCH, (False, False, False)),
            command=ActuatorCommand(self.now_s, self.supervisor.now.armed, thrusters),
            inputs=Inputs(),
            feedback=(None, None),
            health=(),
            events=self.vessel.events.drain(),
        )
        tick = replace(tick, **changes)
        self.vessel.last_tick = tick
        self.hub.publish(tick)
        return tick

    def run(self, duration_s: float, **changes: Any) -> None:
        for _ in range(round(duration_s * 10)):
            self.tick(**changes)

    def serve(self) -> None:
        self.hub.serve(self.now_s)

    def ask(self, *messages: Any, desk: int = 0) -> list[Any]:
        """Send, let the hub answer between two ticks, and what came back."""
        self.desks[desk].hear()
        self.desks[desk].send(*messages)
        self.serve()
        return self.desks[desk].hear()

    def command(self, number: int, *params: float, desk: int = 0, target: tuple[int, int] = (1, 1)) -> list[Any]:
        padded = (*params, *(0.0 for _ in range(7 - len(params))))
        return self.ask(mavlink.MAVLink_command_long_message(*target, number, 0, *padded), desk=desk)

    def command_int(
        self, number: int, params: Sequence[float], x: int, y: int, z: float = 0.0, *, the_frame: int = 0
    ) -> list[Any]:
        return self.ask(mavlink.MAVLink_command_int_message(1, 1, the_frame, number, 0, 0, *params, x, y, z))


@pytest.fixture
def make_rig() -> type[Rig]:
    return Rig


@pytest.fixture
def rig() -> Rig:
    return Rig(["memory:"])


@pytest.fixture
def named() -> Callable[[Sequence[Any], str], list[Any]]:
    """The messages of one kind among some."""
    return lambda messages, kind: [message for message in messages if message.get_type() == kind]
