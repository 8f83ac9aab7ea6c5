"""What drivers of serial RC receivers share: channels of 11 bits, and when the transmitter counts as lost."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from companion.config.devices import SensorConfig
from companion.core.ports import ByteStream
from companion.core.readings import RcInput, Reading
from companion.io.rc_receiver import channels
from companion.io.sensors.driver import StreamDriver

CHANNELS, CHANNEL_BYTES = 16, 22
_BITS, _MASK = 11, 0x7FF
_PULSE_AT_0_US, _US_A_STEP = 880.0, 0.625  # 992 is 1500 µs; 172 and 1811 are 988 and 2012 µs
_LEAST_S = 0.018  # between two readings: receivers send up to 500 frames a second


def unpacked(data: bytes) -> tuple[int, ...]:
    """16 values of 11 bits, the lowest bit first."""
    bits = int.from_bytes(data[:CHANNEL_BYTES], "little")
    return tuple(bits >> (_BITS * n) & _MASK for n in range(CHANNELS))


def pulses_us(values: Sequence[int]) -> tuple[int, ...]:
    """The pulse widths that the values stand for."""
    return tuple(round(_PULSE_AT_0_US + _US_A_STEP * value) for value in values)


class RcStream(StreamDriver):
    """Frames of a serial RC receiver → `RcInput`: the newest of each read, at most 50 a second.

    A protocol calls `_take` for each frame of channels. Where none has come for `timeout_s`, one reading says that the
    transmitter is lost. Remembers the newest channels, whether they are told, and when the last reading was.
    """

    messages = "RC frames"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._newest: RcInput | None = None
        self._told: RcInput | None = None
        self._now_s = 0.0

    def read(self, now_s: float) -> Sequence[Reading]:
        """See `Sensor`."""
        self._now_s = now_s
        super().read(now_s)
        newest, told = self._newest, self._told
        if newest is None:
            return []
        if not newest.lost and now_s - newest.t_s > self._config.timeout_s:
            newest = RcInput(newest.t_s + self._config.timeout_s, self.name, newest.channels, True)
        if told is not None and newest.lost == told.lost and newest.t_s - told.t_s < _LEAST_S:
            return []
        self._newest = self._told = newest
        return [newest]

    def _take(self, arrival_s: float, values: Sequence[int], lost: bool) -> None:
        """The channels of a frame; `lost`: the RC receiver hears no transmitter."""
        found = channels(pulses_us(values))
        self._newest = RcInput(arrival_s - self._config.latency_s, self.name, found, lost)

    @abstractmethod
    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        """Take the next bytes of the stream, and give its frames to `_take`."""
