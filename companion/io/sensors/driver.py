"""What the drivers of byte-stream sensors share: reading the port, counts, and the health of the device."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from companion.config.devices import SensorConfig
from companion.core.ports import ByteStream
from companion.core.readings import Reading
from companion.core.tick import DeviceHealth
from companion.io.recognise import Overheard
from companion.io.sensors.message_timing import MessageTiming
from companion.io.sensors.setup import DeviceSetup

SILENT_BYTES = 600  # that many bytes without one valid message: not the language or not the speed


class StreamDriver(ABC):
    """Bytes of one port → readings. A protocol fills in `_feed`.

    Remembers when the last valid message came, counts of valid and of bad messages and of bytes since the last valid
    one, since when messages come that are of no use, and the rates of messages. Where those bytes are many, it
    remembers what they look like.
    """

    messages = "messages"  # what the protocol calls them, for people

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        self.name = config.name
        self._config = config
        self._stream = stream
        self._last_valid_s: float | None = None
        self._valid = 0
        self._bad = 0
        self._bytes_since_valid = 0
        self._useless_s: float | None = None
        self._pace = MessageTiming(config.rate_hz)
        self._setup: DeviceSetup | None = None  # of devices that are configured at the start
        self._was_open = False
        self._overheard = Overheard(SILENT_BYTES)

    def read(self, now_s: float) -> Sequence[Reading]:
        """Readings whose bytes came in since the last call, in order of arrival."""
        readings: list[Reading] = []
        for arrival_s, data in self._stream.read(now_s):
            self._bytes_since_valid += len(data)
            self._feed(arrival_s, data, readings)
            self._overheard.hear(data, self._bytes_since_valid)
        if self._setup is not None:
            self._set_up(self._setup, now_s)
            if not self._setup.done:
                return ()  # its axes and rates may not be those of the vessel's file yet
        return readings

    @property
    def counts(self) -> tuple[int, int]:
        """Valid messages and bad ones, since the start."""
        return self._valid, self._bad

    def health(self, now_s: float) -> DeviceHealth:
        """Fault of the port, silence, or bytes that are no messages; else the counts and the rates."""
        age_s = None if self._last_valid_s is None else now_s - self._last_valid_s
        text = self._complaint(age_s)
        counts = f"{self._valid} {self.messages}, {self._bad} bad"
        if not text and self._pace.text:
            counts += f"; {self._pace.text}"
        return DeviceHealth(self.name, not text, age_s, f"{text} ({counts})" if text else counts)

    def fileno(self) -> int | None:
        """See `Sensor`."""
        return self._stream.fileno()

    def close(self) -> None:
        """Close the port."""
        self._stream.close()

    def _set_up(self, setup: DeviceSetup, now_s: float) -> None:
        is_open = self._stream.fault() is None
        if is_open and not self._was_open:
            setup.restart()
        self._was_open = is_open
        if not setup.done:
            self._useless_s = None
        since_s = self._last_valid_s if self._useless_s is None else self._useless_s
        if is_open and (request := setup.due(now_s, 0.0 if since_s is None else now_s - since_s)):
            self._stream.write(request, now_s)

    def _complaint(self, age_s: float | None) -> str:
        fault = self._stream.fault()
        if fault is not None:
            return fault
        recent = age_s is not None and age_s <= self._config.timeout_s
        if not recent and self._bytes_since_valid >= SILENT_BYTES:
            return f"{self._bytes_since_valid:,} bytes and no valid {self.messages}: {self._nonsense()}"
        if self._setup is not None and not self._setup.done:
            return self._setup.remark
        if recent:
            return ""
        if age_s is None:
            return "nothing received yet: check power and wiring"
        return f"silent for {age_s:.1f} s"

    def _nonsense(self) -> str:
        """What may be wrong where bytes come in that are no messages."""
        return (
            self._overheard.guess or f"wrong baud rate in '{self._config.port}', or the device speaks another protocol"
        )

    def _count_valid(self, arrival_s: float, kind: str = "") -> None:
        self._valid += 1
        self._pace.note(arrival_s, kind)
        self._last_valid_s = arrival_s
        self._bytes_since_valid = 0

    def _count_use(self, arrival_s: float, used: bool) -> None:
        """Of a driver that tells it: whether a valid message has brought what the sensor is for."""
        if used:
            self._useless_s = None
        elif self._useless_s is None:
            self._useless_s = arrival_s

    @property
    def _is_useless(self) -> bool:
        """Whether the messages of the last `timeout_s` have brought nothing."""
        since_s, last_s = self._useless_s, self._last_valid_s
        return since_s is not None and last_s is not None and last_s - since_s > self._config.timeout_s

    @abstractmethod
    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        """Take the next bytes of the stream. Append to `readings` those that they complete."""
