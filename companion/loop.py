"""The tick: sense → estimate → decide → guide → control → allocate → gate → act → record.

`Vessel` holds the blocks and says that order in one function. `run` calls it at absolute deadlines and, between two ticks, lets
the vessel answer whatever comes in on its links. Neither knows whether the world outside is real.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

from companion.allocation.allocator import Allocator
from companion.allocation.availability import Availability
from companion.allocation.feedback import ThrusterReports
from companion.allocation.jet import JetAllocator
from companion.config import VesselConfig
from companion.control.controller import Controller
from companion.core.frames import ned_to_body
from companion.core.geodesy import LocalFrame
from companion.core.ports import Actuator, Clock, Recorder, Sensor, Stations, WaitingClock, World
from companion.core.types import (
    ZERO_WRENCH,
    ActuatorCommand,
    AisTarget,
    Allocation,
    Battery,
    Condition,
    Corrections,
    Depth,
    DeviceHealth,
    Inputs,
    Leak,
    NavState,
    RcInput,
    Reading,
    Setpoint,
    SetpointKind,
    Severity,
    Status,
    ThrusterFeedback,
    Tick,
    Wind,
    Wrench,
)
from companion.mission.executor import MissionExecutor
from companion.mission.plan import Plans
from companion.modes.beacon import beacon
from companion.modes.events import EventLog
from companion.modes.supervisor import Supervisor
from companion.nav.charge import ChargeCounter
from companion.nav.estimator import Estimator
from companion.params import Parameters
from companion.safety import Gate

_ANSWER_S = 10.0  # after the start, by which a device should have answered: motors of NMEA 2000 and drives that home need a while
_LATE_S = 0.005  # a tick that begins later is counted


@dataclass(frozen=True, slots=True)
class Blocks:
    """The arithmetic of a vessel, wired by `app.build`."""

    estimator: Estimator
    supervisor: Supervisor
    controller: Controller
    availability: Availability
    allocator: Allocator | JetAllocator
    gate: Gate


@dataclass(frozen=True, slots=True)
class Devices:
    """What the vessel has plugged in."""

    world: World
    sensors: tuple[Sensor, ...]
    actuators: tuple[Actuator, ...]


class Vessel:
    """One boat: its blocks, its devices, its ground stations, and the values that they share."""

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
        self.load = 0.0  # share of the period that the last tick took, as the runner measured it
        self.period_s = 1.0 / config.control_rate_hz
        self._blocks = blocks
        self._devices = devices
        self._clock = clock
        self._stations: Stations = NoStations()
        self._recorders: list[Recorder] = []
        self._arrived: list[Reading] = []  # readings that came in between two ticks
        self._inputs = Inputs()
        self._charge = ChargeCounter(config.battery)
        self._reports = ThrusterReports(len(config.thrusters))
        self._achieved: Wrench = ZERO_WRENCH
        self._command: ActuatorCommand | None = None  # the last that went to the bridges
        self._thrust: Wrench | None = None  # on the hull, None where it is not ours to know
        self._device_ok: dict[str, bool] = {}
        self._answers_due_s: float | None = None

    @property
    def frame(self) -> LocalFrame:
        """The local NED plane that the estimator works in."""
        return self._blocks.estimator.frame

    def attach(self, stations: Stations) -> None:
        """The ground stations; they hold the vessel in turn, so they come after it."""
        self._stations = stations

    def add_recorder(self, recorder: Recorder) -> None:
        self._recorders.append(recorder)

    def request_restart(self) -> None:
        """Asked for by a ground station; the runner ends the process with the exit code that a supervisor restarts on."""
        self.restart_requested = True

    def filenos(self) -> Sequence[int]:
        """Descriptors that become readable when something arrives."""
        devices = (device.fileno() for device in (*self._devices.sensors, *self._devices.actuators))
        return [*self._stations.filenos(), *(fd for fd in devices if fd is not None)]

    def serve(self, now_s: float) -> None:
        """Between two ticks: stamp and keep what the sensors sent, answer the ground stations."""
        self._collect(now_s)
        self._stations.serve(now_s)

    def tick(self, now_s: float) -> Tick:
        """One cycle, whole."""
        readings = self.sense(now_s)
        nav = self._blocks.estimator.update(readings, now_s, self._thrust)
        health = self.device_health(now_s)
        status = self.supervisor.update(nav, self._inputs, health, now_s)
        self.mind_thrusters(health, now_s)
        setpoint = self.supervisor.guide(nav, now_s, self.period_s)
        wrench = self._blocks.controller.update(setpoint, nav, self._achieved, self.period_s)
        allocation = self.allocate(setpoint, wrench, status, nav)
        command = self.gate(allocation, status, health, now_s)
        self.act(command, now_s)
        return self.record(readings, nav, status, setpoint, wrench, allocation, command, health)

    def sense(self, now_s: float) -> Sequence[Reading]:
        """All readings since the last tick; the slow ones are kept for the steps and the telemetry that look at the newest."""
        self._devices.world.advance(now_s)
        self._stations.serve(now_s)
        self._collect(now_s)
        readings, self._arrived = self._arrived, []
        inputs = self._inputs
        for reading in readings:
            match reading:
                case Battery():
                    inputs = replace(inputs, battery=self._charge.update(reading))
                case Leak():
                    inputs = replace(inputs, leak=reading)
                case RcInput():
                    inputs = replace(inputs, rc=reading)
                case Wind():
                    inputs = replace(inputs, wind=reading)
                case Depth():
                    inputs = replace(inputs, depth=reading)
                case Corrections():
                    inputs = replace(inputs, corrections=reading)
                case ThrusterFeedback():
                    self._reports.take(reading)
                case AisTarget():
                    self.supervisor.traffic_heard(reading, now_s)
        self._inputs = inputs
        return readings

    def device_health(self, now_s: float) -> tuple[DeviceHealth, ...]:
        """Health of every device; a change is said, and what has not answered some time after the start."""
        health = tuple(device.health(now_s) for device in (*self._devices.sensors, *self._devices.actuators))
        self._answers_due_s = now_s + _ANSWER_S if self._answers_due_s is None else self._answers_due_s
        for device in health:
            before = self._device_ok.get(device.name)
            if before is None and not device.ok and now_s < self._answers_due_s:
                continue
            if device.ok and before is False:
                self.events.say(now_s, Severity.NOTICE, f"{device.name}_back", f"{device.name}: back")
            elif not device.ok and before is not False:
                self.events.say(now_s, Severity.WARNING, f"{device.name}_lost", f"{device.name}: {device.text}")
            self._device_ok[device.name] = device.ok
        return health

    def mind_thrusters(self, health: Sequence[DeviceHealth], now_s: float) -> None:
        """Thrusters that have failed or are not down are left out of the allocation at once, and the modes know of them."""
        availability = self._blocks.availability
        silent = [device.name for device in health if not device.ok]
        if availability.update(self._reports.newest, self._command, self.supervisor.retraction.lower, silent, now_s):
            for i, condition in enumerate(availability.conditions):
                self._blocks.allocator.set_failed(i, condition is not Condition.READY)
                self.supervisor.thruster_failed(i, condition is Condition.FAILED)
        self.supervisor.retraction.see(availability.up, now_s)

    def allocate(self, setpoint: Setpoint, wrench: Wrench, status: Status, nav: NavState) -> Allocation:
        """Thruster demands; what the thrusters cannot give is remembered for the integrators."""
        allocator = self._blocks.allocator
        if not status.armed or setpoint.kind is SetpointKind.NEUTRAL:
            allocation = allocator.neutral()
        elif setpoint.kind is SetpointKind.THRUSTERS and setpoint.thrusters is not None:
            allocation = allocator.direct(setpoint.thrusters, surge_mps=surge_through_water_mps(nav))
        else:
            allocation = allocator.update(wrench, self.period_s, surge_through_water_mps(nav))
        self._achieved = allocation.achieved
        self._thrust = allocation.achieved if status.armed else None
        self.supervisor.thrust_achieved(allocation.achieved)
        return allocation

    def gate(self, allocation: Allocation, status: Status, health: Sequence[DeviceHealth], now_s: float) -> ActuatorCommand:
        """What may go to the bridges, with servos, relays and lamps."""
        lower = self.supervisor.retraction.lower
        outputs = self.supervisor.auxiliary.update(status.armed, now_s)
        command = self._blocks.gate.update(allocation, status.armed, now_s, self.period_s, lower, self._reports.newest, outputs)
        leak = self._inputs.leak
        lamps = beacon(status, leak is not None and leak.wet, health, self._blocks.availability.conditions)
        return replace(command, beacon=lamps)

    def act(self, command: ActuatorCommand, now_s: float) -> None:
        self._command = command
        for actuator in self._devices.actuators:
            actuator.write(command, now_s)

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
        """The cycle as one record, for the log and the telemetry."""
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
            health=(*health, *self._stations.health(nav.t_s)),
            events=self.events.drain(),
            load=self.load,
            readings=readings,
            conditions=self._blocks.availability.conditions,
        )
        self.last_tick = tick
        for recorder in self._recorders:
            recorder.record(tick)
        self._stations.publish(tick)
        return tick

    def close(self) -> None:
        """Neutral to the bridges, then everything shut."""
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
        for sensor in self._devices.sensors:
            self._arrived.extend(sensor.read(now_s))
        for actuator in self._devices.actuators:
            self._arrived.extend(actuator.read(now_s))


def surge_through_water_mps(nav: NavState) -> float:
    """Speed ahead through the water; over ground where no current is known."""
    if nav.current_north_mps is None or nav.current_east_mps is None:
        return nav.surge_mps
    return nav.surge_mps - ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)[0]


class NoStations:
    """A vessel without ground stations."""

    def serve(self, now_s: float) -> None:
        pass

    def publish(self, tick: Tick) -> None:
        pass

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        return ()

    def filenos(self) -> Sequence[int]:
        return ()

    def close(self) -> None:
        pass


class RealWorld:
    """On a boat the world advances by itself."""

    def advance(self, now_s: float) -> None:
        pass


class Ticking(Protocol):
    """What can be run: a vessel, or the module on a lead boat. `load`: share of the period that the last tick took, as the runner measured it."""

    period_s: float
    load: float

    def filenos(self) -> Sequence[int]: ...

    def serve(self, now_s: float) -> None: ...

    def tick(self, now_s: float) -> Any: ...


@dataclass(slots=True)
class Punctuality:
    """How a run kept its deadlines, in the boat's time: ticks, those that began more than 5 ms late, the worst and when it was, and those left out."""

    ticks: int = 0
    late: int = 0
    worst_s: float = 0.0
    worst_at_s: float = 0.0
    left_out: int = 0

    def note(self, deadline_s: float, now_s: float) -> None:
        """A tick that was due at `deadline_s` begins."""
        late_s = now_s - deadline_s
        self.ticks += 1
        self.late += late_s > _LATE_S
        if late_s > self.worst_s:
            self.worst_s, self.worst_at_s = late_s, deadline_s

    @property
    def text(self) -> str:
        worst = f"the latest began {1e3 * self.worst_s:.1f} ms after its time (at {self.worst_at_s:.1f} s)"
        return f"{self.ticks} ticks, {worst}, {self.late} more than {1e3 * _LATE_S:.0f} ms, {self.left_out} left out"


def run(vessel: Ticking, clock: WaitingClock, stop: Callable[[], bool]) -> Punctuality:
    """Tick at absolute deadlines until `stop()`. A deadline that was missed by more than a period is skipped, not caught up."""
    punctuality = Punctuality()
    deadline_s = clock.now_s()
    while not stop():
        while clock.wait(deadline_s, vessel.filenos()):
            vessel.serve(clock.now_s())
        punctuality.note(deadline_s, clock.now_s())
        vessel.tick(clock.now_s())
        vessel.load = clock.busy_s() / vessel.period_s
        late_s = clock.now_s() - deadline_s
        periods = max(1, math.ceil(late_s / vessel.period_s))
        punctuality.left_out += periods - 1
        deadline_s += vessel.period_s * periods
    return punctuality
