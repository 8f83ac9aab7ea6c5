"""What the loop needs of the world outside, as Protocols. The boat, SITL and the tests each bring their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from companion.core.types import ActuatorCommand, DeviceHealth, Reading, Tick


@runtime_checkable
class ByteStream(Protocol):
    """A port to one device. Never blocks, never raises for what the device or the line does: it turns into health."""

    name: str

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        """Bytes that came in since the last call, in order, as (time of arrival in vessel time, bytes)."""
        ...

    def write(self, data: bytes, now_s: float) -> None:
        """Send, or drop whole if the line cannot take it now."""
        ...

    def fault(self) -> str | None:
        """None while the port is open and well, else one line that says what is wrong and what to do."""
        ...

    def fileno(self) -> int | None:
        """A descriptor that becomes readable when bytes arrive, or None (memory, closed)."""
        ...

    def close(self) -> None: ...


class StreamOpener(Protocol):
    """Opens the port of a device by its name and URL. SITL answers by name with a `memory:` stream."""

    def open(self, name: str, url: str) -> ByteStream: ...


class Sensor(Protocol):
    """Driver of one sensor: bytes in, readings out."""

    name: str

    def read(self, now_s: float) -> Sequence[Reading]: ...

    def health(self, now_s: float) -> DeviceHealth: ...

    def fileno(self) -> int | None: ...

    def close(self) -> None: ...


class Actuator(Protocol):
    """Driver of one bridge: commands out, and the readings that the bridge reports back."""

    name: str

    def read(self, now_s: float) -> Sequence[Reading]: ...

    def write(self, command: ActuatorCommand, now_s: float) -> None: ...

    def health(self, now_s: float) -> DeviceHealth: ...

    def fileno(self) -> int | None: ...

    def close(self) -> None: ...


class Stations(Protocol):
    """All ground stations on all links."""

    def serve(self, now_s: float) -> None:
        """Read what came in, answer it at once."""
        ...

    def publish(self, tick: Tick) -> None:
        """Telemetry of a tick, as far as it is due on each link."""
        ...

    def health(self, now_s: float) -> Sequence[DeviceHealth]: ...

    def filenos(self) -> Sequence[int]: ...

    def close(self) -> None: ...


class Recorder(Protocol):
    def record(self, tick: Tick) -> None: ...

    def close(self) -> None: ...


class World(Protocol):
    """What must be brought up to date before a tick senses: nothing on a boat, the plant in SITL."""

    def advance(self, now_s: float) -> None: ...


class Clock(Protocol):
    def now_s(self) -> float: ...

    def time_unix_ns(self) -> int: ...


class WaitingClock(Clock, Protocol):
    """A clock that a run can wait by."""

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        """Until `until_s`, or until a descriptor is readable: True then, and there may be more time to wait."""
        ...

    def busy_s(self) -> float:
        """How much of the boat's time the work since the last wait ended has cost; 0 where time waits for the work."""
        ...
