"""What the loop needs from outside, as Protocols: the boat, SITL and the tests each have their own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any, Protocol, TypeVar, runtime_checkable

from companion.core.actuation import ActuatorCommand
from companion.core.readings import Reading
from companion.core.storing import Ticket
from companion.core.tick import DeviceHealth, Tick

T = TypeVar("T")


@runtime_checkable
class ByteStream(Protocol):
    """A port to one device. It never blocks, and never raises for a fault of the device or the line: `fault` reports
    it."""

    name: str

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        """The bytes since the last call, in order, as (vessel time of arrival, bytes)."""
        ...

    def write(self, data: bytes, now_s: float) -> None:
        """Send all of `data`, or nothing if the line cannot take it now."""
        ...

    def fault(self) -> str | None:
        """None while the port works, else one line: what is wrong and what to do."""
        ...

    def fileno(self) -> int | None:
        """A descriptor that becomes readable when bytes arrive; None for memory or a closed port."""
        ...

    def close(self) -> None:
        """Close the port."""
        ...


class StreamOpener(Protocol):
    """Opens the ports of devices."""

    def open(self, name: str, url: str) -> ByteStream:
        """The port of the device `name` at `url`. SITL ignores the URL and gives a `memory:` stream for the name."""
        ...


class Sensor(Protocol):
    """Driver of one sensor: bytes in, readings out."""

    name: str

    def read(self, now_s: float) -> Sequence[Reading]:
        """The readings since the last call, in order of arrival."""
        ...

    def health(self, now_s: float) -> DeviceHealth:
        """The state of the device now."""
        ...

    def fileno(self) -> int | None:
        """A descriptor that becomes readable when the device sends, or None."""
        ...

    def close(self) -> None:
        """Close the device's port."""
        ...


@runtime_checkable
class ReportsBack(Protocol):
    """A sensor or actuator whose device shows the boat's state: `telemetry` gets every tick."""

    telemetry: Recorder


class Actuator(Protocol):
    """Driver of one bridge: commands out, and the readings that the bridge reports back."""

    name: str

    def read(self, now_s: float) -> Sequence[Reading]:
        """What the bridge reported since the last call, in order of arrival."""
        ...

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """Send the command to the bridge."""
        ...

    def health(self, now_s: float) -> DeviceHealth:
        """The state of the bridge now."""
        ...

    def fileno(self) -> int | None:
        """A descriptor that becomes readable when the bridge sends, or None."""
        ...

    def close(self) -> None:
        """Close the bridge's port."""
        ...


class GroundStationPort(Protocol):
    """All ground stations on all links."""

    def serve(self, now_s: float) -> None:
        """Read what arrived and answer it at once."""
        ...

    def publish(self, tick: Tick) -> None:
        """Send the telemetry of a tick that is due on each link."""
        ...

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        """The state of each link now."""
        ...

    def filenos(self) -> Sequence[int]:
        """Descriptors that become readable when packets arrive."""
        ...

    def close(self) -> None:
        """Close all links."""
        ...


class Recorder(Protocol):
    """Takes each tick whole: the log, the state file, the relay of corrections."""

    def record(self, tick: Tick) -> None:
        """Take one tick."""
        ...

    def close(self) -> None:
        """Write out what is pending."""
        ...


class Host(Protocol):
    """The computer that the boat's program runs on."""

    def faults(self, now_s: float) -> Sequence[str]:
        """What it lacks, a few words each."""
        ...


class Storage(Protocol):
    """What the vessel keeps over a restart. Nothing here waits for the medium: who acknowledges something asks for its
    ticket, and answers when that is settled."""

    def parameters(self) -> Ticket:
        """The ticket of the parameters as they are now."""
        ...

    def progress(self) -> Ticket:
        """Store mission progress and home as they are now."""
        ...

    def plan(self, kind: int, items: Sequence[Any]) -> Ticket:
        """Store a plan, which replaces the stored one of that kind (`PlanKind`)."""
        ...

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        """Whether the state and the log are being written."""
        ...

    def lost(self) -> Sequence[str]:
        """What was kept over the restart and does not count, a line for operators each; until it is stored anew."""
        ...


class Worker(Protocol):
    """Carries out functions that take longer than a tick may: beside the control thread, or at once in lockstep."""

    def submit(self, work: Callable[[], T], urgent: bool = False) -> Future[T]:
        """Carry out `work`, after what was submitted before. `urgent`: after what is urgent alone, since the boat waits
        for it. A future that is not running yet can be cancelled."""
        ...


class Waker(Protocol):
    """Wakes the control thread when work beside it is done."""

    def ring(self) -> None:
        """Wake it now, or when it next waits. Any thread may call this."""
        ...

    def fileno(self) -> int:
        """A descriptor that becomes readable then."""
        ...

    def silence(self) -> None:
        """It is awake."""
        ...


class World(Protocol):
    """What is brought up to date before a tick senses: nothing on a boat, the plant in SITL."""

    def advance(self, now_s: float) -> None:
        """Simulate up to `now_s`."""
        ...


class Clock(Protocol):
    """Vessel time and absolute time: wall clock or simulated."""

    def now_s(self) -> float:
        """Vessel time: seconds since the process started."""
        ...

    def time_unix_ns(self) -> int:
        """Absolute time now, in nanoseconds since 1970."""
        ...


class WaitingClock(Clock, Protocol):
    """A clock that a run can wait by."""

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        """Wait until `until_s`, or until a descriptor is readable: then it returns True, perhaps early."""
        ...

    def busy_s(self) -> float:
        """Vessel time that the work took since the last wait ended; 0 if the clock stands still during work."""
        ...
