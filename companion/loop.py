"""The tick: sense → estimate → decide → guide → control → allocate → gate → act → record.

`Vessel.tick` calls these steps in this order. `run` calls it at absolute deadlines, and between two ticks lets the
vessel answer what arrives on its links. Neither knows whether the boat is real or simulated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol

from companion.allocation.availability import Availability
from companion.allocation.choice import AnyAllocator
from companion.allocation.feedback import ThrusterReports
from companion.config.vessel import VesselConfig
from companion.containment import Containment
from companion.control.controller import Controller
from companion.core.actuation import (
    ZERO_WRENCH,
    ActuatorCommand,
    Allocation,
    ThrusterCondition,
    ThrusterFeedback,
    Wrench,
)
from companion.core.decision import Status, TextKind
from companion.core.estimate import NavState, through_water
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.ports import (
    Actuator,
    Clock,
    GroundStationPort,
    Host,
    Recorder,
    Sensor,
    Storage,
    WaitingClock,
    Waker,
    Worker,
    World,
)
from companion.core.readings import (
    AisTarget,
    Battery,
    Corrections,
    Depth,
    DepthAhead,
    GnssFix,
    Leak,
    RadarTarget,
    Ranges,
    RcInput,
    Reading,
    RelativeFix,
    Wind,
)
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, Setpoint, ThrusterSetpoint
from companion.core.storing import Ticket, durable
from companion.core.tick import DeviceHealth, Inputs, Tick
from companion.core.work import AtOnce
from companion.mission.executor import MissionExecutor
from companion.mission.plan import Plans
from companion.nav.battery import BatteryGauge
from companion.nav.estimator import Estimator
from companion.nav.inertial import InertialSolution
from companion.params.store import Parameters
from companion.safety import Gate
from companion.supervisor.beacon import beacon
from companion.supervisor.supervisor import Supervisor

_ANSWER_S = 10.0  # time for a device to answer after the start: NMEA 2000 motors and drives that home need it
_LATE_S = 0.005  # a tick that begins later counts as late

NEWEST: Mapping[type, str] = {Leak: "leak", RcInput: "rc", Wind: "wind", Depth: "depth", Corrections: "corrections"}
"""Kinds of which the loop keeps the newest reading, with the field of `Inputs` that holds it."""


@dataclass(frozen=True, slots=True)
class Blocks:
    """The blocks of a vessel, one for each step of the tick; `app.build` makes them."""

    estimator: Estimator
    supervisor: Supervisor
    controller: Controller
    availability: Availability
    allocator: AnyAllocator
    gate: Gate


@dataclass(frozen=True, slots=True)
class Devices:
    """The drivers of the vessel's devices, and the world that they stand in."""

    world: World
    sensors: tuple[Sensor, ...]
    actuators: tuple[Actuator, ...]


class Vessel:
    """One boat: its blocks, its devices, its ground stations, and the values that they share. Remembers the inputs and
    the results that the next tick needs."""

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        plans: Plans,
        executor: MissionExecutor,
        events: EventLog,
        blocks: Blocks,
        devices: Devices,
        clock: Clock,
    ) -> None:
        self.config = config
        self.parameters = parameters
        self.plans = plans
        self.executor = executor
        self.events = events
        self.supervisor = blocks.supervisor
        self.last_tick: Tick | None = None
        self.restart_requested = False
        self.storage: Storage = NoStorage()
        self.worker: Worker = AtOnce()
        self.waker: Waker | None = None
        self.host: Host = WellHost()
        self.load = 0.0  # share of the period that the last tick took; set by `run`
        self.period_s = 1.0 / config.control_rate_hz
        self.containment = Containment(events.say)
        self._blocks = blocks
        self._devices = devices
        self._clock = clock
        self._stations: GroundStationPort = NoGroundStations()
        self._recorders: list[Recorder] = []
        self._arrived: list[Reading] = []  # readings that came in between two ticks
        self._inputs = Inputs()
        self._newest: dict[str, Any] = {}  # of a tick, by the fields of `Inputs`
        self._battery = BatteryGauge(config, parameters, events.say)
        self._reports = ThrusterReports(len(config.thrusters))
        self._achieved: Wrench = ZERO_WRENCH
        self._command: ActuatorCommand | None = None  # the last one sent to the bridges
        self._thrust: Wrench | None = None  # on the hull; None while disarmed
        self._taken: Mapping[type, Callable[[Any, float], None]] = {  # the kinds of which a block takes every reading
            Battery: self._battery_read,
            ThrusterFeedback: lambda report, _: self._reports.take(report),
            AisTarget: self.supervisor.traffic_heard,
            Ranges: self.supervisor.obstacle_heard,
            RadarTarget: self.supervisor.obstacle_heard,
            DepthAhead: self.supervisor.obstacle_heard,
            GnssFix: self.supervisor.place_heard,
            RelativeFix: self.supervisor.place_heard,
        }
        self._device_ok: dict[str, bool] = {}
        self._answers_due_s: float | None = None

    @property
    def frame(self) -> LocalFrame:
        """The local NED plane of the estimator."""
        return self._blocks.estimator.frame

    @property
    def sources(self) -> Mapping[str, str | None]:
        """The sensor in use for each kind of reading, as the estimator chooses; None before the first."""
        return self._blocks.estimator.sources

    @property
    def inertial(self) -> InertialSolution | None:
        """The solution that the inertial sensor carries; None before its first reading."""
        return self._blocks.estimator.inertial

    def attach(self, stations: GroundStationPort) -> None:
        """Set the ground stations. They need the vessel, so they are made after it."""
        self._stations = stations

    def store_in(self, storage: Storage) -> None:
        """Set the storage. It needs the recorders, so it is made after them."""
        self.storage = storage

    def work_beside(self, worker: Worker, waker: Waker) -> None:
        """Let `worker` do what takes long, and `waker` wake the control thread afterwards."""
        self.worker, self.waker = worker, waker

    def add_recorder(self, recorder: Recorder) -> None:
        """Pass every tick to `recorder` too."""
        self._recorders.append(recorder)

    def request_restart(self) -> None:
        """Ask the runner to end this run and begin the program anew."""
        self.restart_requested = True

    def filenos(self) -> Sequence[int]:
        """Descriptors that become readable when a device or a ground station sends, or work beside is done."""
        devices = (device.fileno() for device in (*self._devices.sensors, *self._devices.actuators))
        waker = () if self.waker is None else (self.waker.fileno(),)
        return [*self._stations.filenos(), *(fd for fd in devices if fd is not None), *waker]

    def serve(self, now_s: float) -> None:
        """Between two ticks: keep what the sensors sent, with its time, and answer the ground stations."""
        if self.waker is not None:
            self.waker.silence()
        self._collect(now_s)
        self._stations.serve(now_s)

    def tick(self, now_s: float) -> Tick:
        """One cycle. One that fails is left out and announced, as `Containment` has it; then the last tick's record is
        returned. Raises what made too many fail, or the first."""
        try:
            tick = self.cycle(now_s)
        except Exception as error:
            if self.last_tick is None:
                raise
            self.containment.tick_failed(error, now_s)
            return self.last_tick
        self.containment.tick_done()
        return tick

    def cycle(self, now_s: float) -> Tick:
        """All steps in their order."""
        self.supervisor.parts.computer.update(now_s, self.host.faults(now_s))
        readings = self.sense(now_s)
        nav = self._blocks.estimator.update(readings, now_s, self._thrust)
        health = self.device_health(now_s)
        status = self.supervisor.update(nav, self._inputs, health, now_s)
        self.update_thruster_conditions(health, now_s)
        setpoint = self.supervisor.guide(nav, now_s, self.period_s)
        wrench = self._blocks.controller.update(setpoint, nav, self._achieved, self.period_s)
        self.supervisor.turns_against(self._blocks.controller.turn_resistance, now_s)
        allocation = self.allocate(setpoint, wrench, status, nav)
        command = self.gate(allocation, status, health, now_s)
        self.act(command, now_s)
        return self.record(readings, nav, status, setpoint, wrench, allocation, command, health)

    def sense(self, now_s: float) -> Sequence[Reading]:
        """All readings since the last tick, in the order of arrival: the estimator gets them all. `_taken` names the
        blocks that want every reading of a kind, NEWEST the kinds that the steps and the telemetry look up."""
        self._devices.world.advance(now_s)
        self._stations.serve(now_s)
        self._collect(now_s)
        readings, self._arrived = self._arrived, []
        newest = self._newest
        newest.clear()
        for reading in readings:
            kind = type(reading)
            if kind in self._taken:
                self._taken[kind](reading, now_s)
            elif kind in NEWEST:
                newest[NEWEST[kind]] = reading
        if newest:
            self._inputs = self._inputs.renewed(newest)
        self.supervisor.calibration.take(readings, now_s)
        return readings

    def _battery_read(self, reading: Battery, now_s: float) -> None:
        before: Battery | None = self._newest.get("battery", self._inputs.battery)
        self._newest["battery"] = self._battery.update(reading, before, now_s)
        self._newest["batteries"] = self._battery.packs(now_s)

    def device_health(self, now_s: float) -> tuple[DeviceHealth, ...]:
        """Health of every device. Announces changes, and devices that do not answer within `_ANSWER_S` of the start."""
        health = tuple(
            self.containment.health(device, now_s) for device in (*self._devices.sensors, *self._devices.actuators)
        )
        self._answers_due_s = now_s + _ANSWER_S if self._answers_due_s is None else self._answers_due_s
        for device in health:
            before = self._device_ok.get(device.name)
            if before is None and not device.ok and now_s < self._answers_due_s:
                continue
            if device.ok and before is False:
                self.events.say(now_s, TextKind.ROUTINE, f"{device.name}_back", f"{device.name}: back")
            elif not device.ok and before is not False:
                self.events.say(now_s, TextKind.ATTENTION, f"{device.name}_lost", f"{device.name}: {device.text}")
            self._device_ok[device.name] = device.ok
        return health

    def update_thruster_conditions(self, health: Sequence[DeviceHealth], now_s: float) -> None:
        """Tell allocation, control and supervisor which thrusters have failed or are not lowered, and how fast they
        turn."""
        availability = self._blocks.availability
        silent = [device.name for device in health if not device.ok]
        if availability.update(self._reports.newest, self._command, self.supervisor.retraction.lower, silent, now_s):
            for i, condition in enumerate(availability.conditions):
                self._blocks.allocator.set_failed(i, condition is not ThrusterCondition.READY)
                self.supervisor.thruster_failed(i, condition is ThrusterCondition.FAILED)
        for i, rate_radps in availability.take_turn_rates():
            self._blocks.allocator.set_turn_rate(i, rate_radps)
            self._blocks.controller.set_turn_rate(i, rate_radps)
            self.supervisor.steers_late(self._blocks.controller.steers_late_s)
        self.supervisor.retraction.see(availability.up, now_s)

    def allocate(self, setpoint: Setpoint, wrench: Wrench, status: Status, nav: NavState) -> Allocation:
        """The thruster demands for a setpoint and its wrench, or of a motor test. Keeps the achieved wrench for the
        integrators."""
        allocator = self._blocks.allocator
        allocator.feel(self.supervisor.rig, nav)
        if (test := self.supervisor.motor_test.update(nav.t_s, self.period_s)) is not None:
            allocation = replace(allocator.direct(test), achieved=ZERO_WRENCH)
        elif not status.armed or isinstance(setpoint, NeutralSetpoint):
            allocation = allocator.neutral()
        elif isinstance(setpoint, ThrusterSetpoint):
            allocation = allocator.direct(setpoint.thrusters, surge_mps=through_water(nav)[0])
        else:
            planned = isinstance(setpoint, PathSetpoint) and setpoint.exact
            ahead = self._blocks.controller.ahead
            allocation = allocator.update(wrench, self.period_s, through_water(nav)[0], planned, ahead)
        self._achieved = allocation.achieved
        self._thrust = allocation.achieved if status.armed else None
        self.supervisor.thrust_achieved(allocation.achieved, wrench)
        return allocation

    def gate(
        self, allocation: Allocation, status: Status, health: Sequence[DeviceHealth], now_s: float
    ) -> ActuatorCommand:
        """The command for the bridges, with servos, relays and lamps."""
        lower = self.supervisor.retraction.lower
        outputs = self.supervisor.outputs(now_s, self.period_s)
        armed = status.armed or self.supervisor.motor_test.running
        command = self._blocks.gate.update(
            allocation, armed, now_s, self.period_s, lower, self._reports.newest, outputs
        )
        leak = self._inputs.leak
        lamps = beacon(status, leak is not None and leak.wet, health, self._blocks.availability.conditions)
        return command.lit(lamps)

    def act(self, command: ActuatorCommand, now_s: float) -> None:
        """Send the command to all bridges."""
        self._command = command
        for actuator in self._devices.actuators:
            self.containment.driver(actuator.name, partial(actuator.write, command, now_s), None, now_s)

    def record(
        self,
        readings: Sequence[Reading],
        nav: NavState,
        status: Status,
        setpoint: Setpoint,
        wrench: Wrench,
        allocation: Allocation,
        command: ActuatorCommand,
        health: tuple[DeviceHealth, ...],
    ) -> Tick:
        """Make the tick's record, and pass it to the recorders and the ground stations."""
        computer = self.supervisor.parts.computer.health
        tick = Tick(
            t_s=nav.t_s,
            time_unix_ns=self._clock.time_unix_ns(),
            nav=nav,
            status=status,
            setpoint=setpoint,
            wrench=wrench,
            allocation=allocation,
            command=command,
            inputs=self._inputs,
            feedback=tuple(self._reports.newest),
            health=(*health, *self._stations.health(nav.t_s), *self.storage.health(nav.t_s), computer),
            events=self.events.drain(),
            load=self.load,
            readings=readings,
            conditions=self._blocks.availability.conditions,
            shots=self.supervisor.payload.take_shots(),
            forwards=self.supervisor.payload.take_forwards(),
        )
        self.last_tick = tick
        for recorder in self._recorders:
            recorder.record(tick)
        self._stations.publish(tick)
        return tick

    def close(self) -> None:
        """Command neutral, then close ground stations, recorders and devices."""
        now_s = self._clock.now_s()
        neutral = self._blocks.gate.update(self._blocks.allocator.neutral(), False, now_s, self.period_s)
        last = self._command
        self.act(neutral if last is None else replace(neutral, lower=last.lower, beacon=last.beacon), now_s)
        self._stations.close()
        for recorder in self._recorders:
            recorder.close()
        for device in (*self._devices.sensors, *self._devices.actuators):
            device.close()

    def _collect(self, now_s: float) -> None:
        for device in (*self._devices.sensors, *self._devices.actuators):
            self._arrived.extend(self.containment.driver(device.name, partial(device.read, now_s), (), now_s))


class NoGroundStations:
    """The `GroundStations` of a vessel without links."""

    def serve(self, now_s: float) -> None:
        """Nothing arrives."""

    def publish(self, tick: Tick) -> None:
        """Nobody listens."""

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        """No links."""
        return ()

    def filenos(self) -> Sequence[int]:
        """No descriptors."""
        return ()

    def close(self) -> None:
        """Nothing to close."""


class WellHost:
    """The `Host` of a vessel whose computer is not looked at."""

    def faults(self, now_s: float) -> Sequence[str]:
        """Nothing is wrong."""
        return ()


class NoStorage:
    """The `Storage` of a vessel that keeps nothing: what it is asked to do is done at once."""

    def parameters(self) -> Ticket:
        """Nothing to wait for."""
        return durable()

    def progress(self) -> Ticket:
        """Nothing to wait for."""
        return durable()

    def plan(self, kind: int, items: Sequence[Any]) -> Ticket:
        """Nothing to wait for."""
        return durable()

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        """Nothing that could fail."""
        return ()

    def lost(self) -> Sequence[str]:
        """Nothing was kept."""
        return ()


class RealWorld:
    """The `World` of a boat: it advances by itself."""

    def advance(self, now_s: float) -> None:
        """Nothing to simulate."""


class Ticking(Protocol):
    """What `run` can run: a vessel, or the module on a lead boat. `load`: share of the period that the last tick took;
    `run` sets it."""

    period_s: float
    load: float

    def filenos(self) -> Sequence[int]:
        """Descriptors that become readable when something arrives."""
        ...

    def serve(self, now_s: float) -> None:
        """Handle what arrived between two ticks."""
        ...

    def tick(self, now_s: float) -> Any:
        """One cycle."""
        ...


@dataclass(slots=True)
class Punctuality:
    """How a run kept its deadlines, in vessel time: the number of ticks, of those that began more than 5 ms late and of
    those skipped; the latest start and when it was due."""

    ticks: int = 0
    late: int = 0
    worst_s: float = 0.0
    worst_at_s: float = 0.0
    skipped: int = 0

    def note(self, deadline_s: float, now_s: float) -> None:
        """Count a tick that begins now and was due at `deadline_s`."""
        late_s = now_s - deadline_s
        self.ticks += 1
        self.late += late_s > _LATE_S
        if late_s > self.worst_s:
            self.worst_s, self.worst_at_s = late_s, deadline_s

    @property
    def text(self) -> str:
        """One line for people."""
        worst = f"latest start {1e3 * self.worst_s:.1f} ms late (at {self.worst_at_s:.1f} s)"
        return f"{self.ticks} ticks: {worst}, {self.late} over {1e3 * _LATE_S:.0f} ms late, {self.skipped} skipped"


def run(
    vessel: Ticking, clock: WaitingClock, stop: Callable[[], bool], punctuality: Punctuality | None = None
) -> Punctuality:
    """Tick at absolute deadlines until `stop()`; returns how it kept them. A deadline missed by more than a period is
    skipped, not made up for. `punctuality`: to count in, for who wants to look at it during the run."""
    punctuality = Punctuality() if punctuality is None else punctuality
    deadline_s = clock.now_s()
    while not stop():
        while clock.wait(deadline_s, vessel.filenos()):
            vessel.serve(clock.now_s())
        punctuality.note(deadline_s, clock.now_s())
        vessel.tick(clock.now_s())
        vessel.load = clock.busy_s() / vessel.period_s
        late_s = clock.now_s() - deadline_s
        periods = max(1, math.ceil(late_s / vessel.period_s))
        punctuality.skipped += periods - 1
        deadline_s += vessel.period_s * periods
    return punctuality
