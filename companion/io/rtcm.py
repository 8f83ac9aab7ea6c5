"""RTCM 3 frames in a stream of bytes.

Source: RTCM 10403.3, transport layer: D3, six zero bits, length of the data in ten bits, data, CRC-24Q (polynomial
1864CFB, begins with 0) over all before it.
"""

from __future__ import annotations

import re

_POLYNOMIAL = 0x1864CFB
_HEAD, _CRC = 3, 3
LONGEST = 1023 + _HEAD + _CRC
_start = re.compile(rb"\xd3(?:[\x00-\x03]|\Z)").search


def _table() -> list[int]:
    table = []
    for byte in range(256):
        crc = byte << 16
        for _ in range(8):
            crc = crc << 1 ^ (_POLYNOMIAL if crc & 0x800000 else 0)
        table.append(crc & 0xFFFFFF)
    return table


_TABLE = _table()


def crc24q(data: bytes) -> int:
    """CRC-24Q of RTCM 3; 0 over a frame with its own checksum."""
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFFFFFF) ^ _TABLE[crc >> 16 ^ byte]
    return crc


def message_number(frame: bytes) -> int:
    """1005, 1077, … of a whole frame; 0 for one without data."""
    return frame[3] << 4 | frame[4] >> 4 if len(frame) > _HEAD + _CRC + 1 else 0


class RtcmFramer:
    """Bytes as they come in → whole frames, unchanged. Remembers an unfinished frame (at most 1029 bytes).

    Where a checksum does not hold, the search goes on one byte further. `bad`: frames with a wrong checksum; `garbage`:
    bytes of no frame.
    """

    def __init__(self) -> None:
        self._rest = b""
        self.bad = 0
        self.garbage = 0

    @property
    def pending(self) -> bool:
        """Whether a frame is unfinished."""
        return bool(self._rest)

    def feed(self, data: bytes) -> list[bytes]:
        """The frames that the next bytes complete."""
        return self._scan(self._rest + data, False)

    def flush(self) -> list[bytes]:
        """The frames in what is unfinished, as if nothing more came."""
        return self._scan(self._rest, True) if self._rest else []

    def _scan(self, buffer: bytes, last: bool) -> list[bytes]:
        frames: list[bytes] = []
        at = 0
        while (found := _start(buffer, at)) is not None:
            self.garbage += found.start() - at
            at = found.start()
            size = (
                _HEAD + _CRC + ((buffer[at + 1] & 0x03) << 8 | buffer[at + 2]) if len(buffer) >= at + _HEAD else LONGEST
            )
            if len(buffer) < at + size:
                if not last:
                    self._rest = buffer[at:]
                    return frames
            elif crc24q(buffer[at : at + size]) == 0:  # with its own checksum behind it
                frames.append(buffer[at : at + size])
                at += size
                continue
            else:
                self.bad += 1
            self.garbage += 1
            at += 1
        self.garbage += len(buffer) - at
        self._rest = b""
        return frames
