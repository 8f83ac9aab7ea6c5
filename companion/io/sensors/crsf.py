"""CRSF of RC receivers (TBS Crossfire and Tracer, ExpressLRS): 420000 or 416666 baud, 8N1, both ways.

Frames: address, length of the rest, type, payload, CRC-8 (DVB-S2) over type and payload; they count from the third in a
row without a fault. Channels are 16 times 11 bits;
link statistics tell how good the radio link is. Receivers of most makers send no channels while their transmitter is
off.

Source: TBS, "CRSF protocol" (github.com/tbs-fpv/tbs-crsf-spec); ExpressLRS.
"""

from __future__ import annotations

import math
from dataclasses import replace

from fastcrc import crc8

from companion.config.devices import SensorConfig
from companion.core.ports import ByteStream
from companion.core.readings import Reading
from companion.io.crsf_telemetry import CrsfTelemetry
from companion.io.sensors.driver import SILENT_BYTES
from companion.io.sensors.rc_stream import CHANNEL_BYTES, RcStream, unpacked

_ADDRESSES = frozenset({0xC8, 0xEA, 0xEC, 0xEE, 0x00})
_LEAST, _MOST = 2, 62  # of the length field
_RC_CHANNELS, _LINK_STATISTICS = 0x16, 0x14
_LENGTHS = {_RC_CHANNELS: CHANNEL_BYTES, _LINK_STATISTICS: 10}
_QUALITY_AT = 2  # of the link towards the boat, %
_FRESH_S = 1.0
_IN_A_ROW = 3  # frames without a fault: on a bad line, eight bits of checksum let one in 256 pass


class CrsfReceiver(RcStream):
    """Bytes → `RcInput`; `telemetry` sends the boat's state back to the transmitter. Remembers the unfinished frame,
    how many came without a fault, and the newest quality of the radio link."""

    messages = "CRSF frames"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self.telemetry = CrsfTelemetry(stream)
        self._buffer = b""
        self._clean = 0  # frames in a row without a fault
        self._quality: int | None = None
        self._quality_s = -math.inf

    def _complaint(self, age_s: float | None) -> str:
        """Silence is no fault: it is what comes from a receiver whose transmitter is off."""
        complaint = super()._complaint(age_s)
        silent = self._stream.fault() is None and (age_s is None or age_s > self._config.timeout_s)
        return "" if silent and self._bytes_since_valid < SILENT_BYTES else complaint

    def _nonsense(self) -> str:
        return self._overheard.guess or "does the receiver send CRSF, and is the baud rate 420000?"

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        buffer = self._buffer + data
        at = 0
        while at + _LEAST < len(buffer):
            length = buffer[at + 1]
            if buffer[at] not in _ADDRESSES or not _LEAST <= length <= _MOST:
                at, self._clean = at + 1, 0
                continue
            if at + 2 + length > len(buffer):
                break
            body = buffer[at + 2 : at + 1 + length]
            if crc8.dvb_s2(body) != buffer[at + 1 + length]:
                self._bad += body[0] in _LENGTHS
                at, self._clean = at + 1, 0
                continue
            self._clean += 1
            self._hear(body[0], body[1:], arrival_s)
            at += 2 + length
        self._buffer = buffer[at:]

    def _hear(self, kind: int, payload: bytes, arrival_s: float) -> None:
        if _LENGTHS.get(kind) != len(payload) or self._clean < _IN_A_ROW:
            return
        self._count_valid(arrival_s)
        if kind == _LINK_STATISTICS:
            self._quality, self._quality_s = payload[_QUALITY_AT], arrival_s
            if not self._quality and self._newest is not None:
                self._newest = replace(self._newest, t_s=arrival_s - self._config.latency_s, lost=True)
        else:
            lost = self._quality == 0 and arrival_s - self._quality_s <= _FRESH_S
            self._take(arrival_s, unpacked(payload), lost)
