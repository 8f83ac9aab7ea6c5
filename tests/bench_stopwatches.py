"""Stopwatches of `make bench`: they stand between a vessel and its ports, and before its ticks.

A compiled class lets no method be replaced, so nothing here replaces one: a port is a protocol, for which another object
may stand, and a vessel stands behind a proxy.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from typing import Any

from companion.core.actuation import ActuatorCommand
from companion.core.ports import Actuator, World
from companion.core.readings import Reading
from companion.core.tick import DeviceHealth
from companion.loop import Devices, Vessel


class TimedWorld:
    """A world that sums the processor time of its steps: `took_s`. `after`: is called after each."""

    def __init__(self, world: World, after: Callable[[], object]) -> None:
        self._world, self._after = world, after
        self.took_s = 0.0

    def advance(self, now_s: float) -> None:
        """As `World.advance`."""
        started_s = time.thread_time()
        self._world.advance(now_s)
        self.took_s += time.thread_time() - started_s
        self._after()


class ControlStep:
    """The processor time of each tick from the last byte that a bridge is asked for to the first that it is told:
    estimate, decide, guide, control, allocate, gate. `ticks_s`: one value a tick."""

    def __init__(self) -> None:
        self.ticks_s: list[float] = []
        self._began_s: float | None = None

    def begin(self) -> None:
        """All readings are there."""
        self._began_s = time.thread_time()

    def leave_out(self, took_s: float) -> None:
        """Do not count work that is done beside on a boat."""
        if self._began_s is not None:
            self._began_s += took_s

    def end(self) -> None:
        """The command is made; a second call of the same tick does nothing."""
        if self._began_s is not None:
            self.ticks_s.append(time.thread_time() - self._began_s)
            self._began_s = None


class TimedActuator:
    """A bridge that starts the stopwatch with what it has read, and stops it with what it is to write."""

    def __init__(self, actuator: Actuator, step: ControlStep) -> None:
        self._actuator, self._step = actuator, step
        self.name = actuator.name

    def read(self, now_s: float) -> Sequence[Reading]:
        """As `Actuator.read`."""
        readings = self._actuator.read(now_s)
        self._step.begin()
        return readings

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """As `Actuator.write`."""
        self._step.end()
        self._actuator.write(command, now_s)

    def health(self, now_s: float) -> DeviceHealth:
        """As `Actuator.health`."""
        return self._actuator.health(now_s)

    def fileno(self) -> int | None:
        """As `Actuator.fileno`."""
        return self._actuator.fileno()

    def close(self) -> None:
        """As `Actuator.close`."""
        self._actuator.close()


def time_world(vessel: Vessel, after: Callable[[], object] = int) -> TimedWorld:
    """Let the vessel's world be timed."""
    devices = vessel._devices
    timed = TimedWorld(devices.world, after)
    vessel._devices = Devices(timed, devices.sensors, devices.actuators)
    return timed


def time_control_steps(vessel: Vessel) -> ControlStep:
    """Let the vessel's steps from estimate to gate be timed."""
    step, devices = ControlStep(), vessel._devices
    actuators = tuple(TimedActuator(actuator, step) for actuator in devices.actuators)
    vessel._devices = Devices(devices.world, devices.sensors, actuators)
    return step


class TimedVessel:
    """A vessel whose calls by the control thread are timed, without its plant: `took(name, seconds)` is told of each
    `tick` and `serve`."""

    def __init__(self, vessel: Vessel, world: TimedWorld, took: Callable[[str, float], None]) -> None:
        self._vessel, self._world, self._took = vessel, world, took

    def __getattr__(self, name: str) -> Any:
        return getattr(self._vessel, name)

    def tick(self, now_s: float) -> Any:
        """As `Vessel.tick`."""
        return self._timed("tick", now_s)

    def serve(self, now_s: float) -> Any:
        """As `Vessel.serve`."""
        return self._timed("serve", now_s)

    def _timed(self, name: str, now_s: float) -> Any:
        plant_before_s, started_s = self._world.took_s, time.thread_time()
        result = getattr(self._vessel, name)(now_s)
        self._took(name, time.thread_time() - started_s - (self._world.took_s - plant_before_s))
        return result


class GarbageCollector:
    """The processor time that the garbage collector takes while this is entered."""

    def __init__(self) -> None:
        self._began_s = self._took_s = 0.0

    def __enter__(self) -> GarbageCollector:
        gc.collect()
        gc.freeze()  # as `companion run` does
        gc.callbacks.append(self._note)
        return self

    def __exit__(self, *error: object) -> None:
        gc.callbacks.remove(self._note)
        gc.unfreeze()

    def _note(self, phase: str, _: dict[str, int]) -> None:
        if phase == "start":
            self._began_s = time.thread_time()
        else:
            self._took_s += time.thread_time() - self._began_s

    def take(self) -> float:
        """What it has taken since the last call."""
        took_s, self._took_s = self._took_s, 0.0
        return took_s
