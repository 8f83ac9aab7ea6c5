"""What the drivers of byte-stream sensors share: reading the port, counting, and saying how the device is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from companion.config import SensorConfig
from companion.core.ports import ByteStream
from companion.core.types import DeviceHealth, Reading
from companion.io.recognise import Overheard

_SILENT_BYTES = 600  # that many bytes without one valid message: not the language or not the speed


class StreamDriver(ABC):
    """Bytes of one port → readings. A protocol fills in `_feed`.

    Remembers when the last valid message came and counts of valid messages, of bad ones, and of bytes since the last valid one; where
    those are many, what they look like.
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
        self._overheard = Overheard(_SILENT_BYTES)

    def read(self, now_s: float) -> Sequence[Reading]:
        """Readings whose bytes came in since the last call, in order of arrival."""
        readings: list[Reading] = []
        for arrival_s, data in self._stream.read(now_s):
            self._bytes_since_valid += len(data)
            self._feed(arrival_s, data, readings)
            self._overheard.hear(data, self._bytes_since_valid)
        return readings

    def health(self, now_s: float) -> DeviceHealth:
        """Fault of the port, silence, or bytes that make no sense; else the counts."""
        age_s = None if self._last_valid_s is None else now_s - self._last_valid_s
        text = self._complaint(age_s)
        counts = f"{self._valid} {self.messages}, {self._bad} bad"
        return DeviceHealth(self.name, not text, age_s, f"{text} ({counts})" if text else counts)

    def fileno(self) -> int | None:
        return self._stream.fileno()

    def close(self) -> None:
        self._stream.close()

    def _complaint(self, age_s: float | None) -> str:
        fault = self._stream.fault()
        if fault is not None:
            return fault
        if age_s is not None and age_s <= self._config.timeout_s:
            return ""
        if self._bytes_since_valid >= _SILENT_BYTES:
            return f"{self._bytes_since_valid:,} bytes and no valid {self.messages}: {self._nonsense()}"
        if age_s is None:
            return "nothing received yet: check power and wiring"
        return f"silent for {age_s:.1f} s"

    def _nonsense(self) -> str:
        """What may be wrong where bytes come in that are no messages."""
        return self._overheard.guess or f"wrong baud rate in '{self._config.port}', or the device speaks another protocol"

    def _count_valid(self, arrival_s: float) -> None:
        self._valid += 1
        self._last_valid_s = arrival_s
        self._bytes_since_valid = 0

    @abstractmethod
    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        """Take the next bytes of the stream and append what they complete."""
