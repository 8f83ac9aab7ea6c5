"""The lead boat's receiver as a moving base: the RTCM 3 that it prints between its sentences goes to the followers,
whose receivers answer with the vector between both antennas.

The bytes pass unchanged, so any receiver will do that makes what the follower's takes (observations, and for u-blox
4072.0 with the base's own position). Source: MAVLink common.xml, GPS_RTCM_DATA: bit 0 of `flags` marks a fragment, bits
1 and 2 are its number, bits 3 to 7 the sequence number of the frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from companion.core.ports import ByteStream
from companion.io.mavlink.wire import messages as mavlink
from companion.io.rtcm import RtcmFramer

_PIECE = 180  # bytes of a fragment
_SEQUENCES, _NUMBERS = 0x1F, 0x03
_MOST_WAITING = 16  # frames: two epochs of the largest kind


class RtcmTap:
    """The port of a receiver, read by its driver: `frames()` gives the RTCM frames that came by. A
    `companion.core.ports.ByteStream`.

    Remembers an unfinished frame, and the frames since the last call.
    """

    def __init__(self, stream: ByteStream) -> None:
        self.name = stream.name
        self._stream = stream
        self._framer = RtcmFramer()
        self._frames: list[bytes] = []

    def frames(self) -> list[bytes]:
        """Whole frames since the last call; of very many the newest."""
        frames, self._frames = self._frames, []
        return frames

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        """See `ByteStream`."""
        chunks = self._stream.read(now_s)
        for _, data in chunks:
            self._frames += self._framer.feed(data)
        del self._frames[:-_MOST_WAITING]
        return chunks

    def write(self, data: bytes, now_s: float) -> None:
        """See `ByteStream`."""
        self._stream.write(data, now_s)

    def fault(self) -> str | None:
        """See `ByteStream`."""
        return self._stream.fault()

    def fileno(self) -> int | None:
        """See `ByteStream`."""
        return self._stream.fileno()

    def close(self) -> None:
        """See `ByteStream`."""
        self._stream.close()


def fragments(frame: bytes, sequence: int) -> list[Any]:
    """GPS_RTCM_DATA messages that carry one frame. Beyond 720 bytes the numbers of the fragments begin again.

    A frame of n·180 bytes needs no empty last one: RTCM says itself where it ends.
    """
    head = (sequence & _SEQUENCES) << 3
    pieces = [frame[at : at + _PIECE] for at in range(0, len(frame), _PIECE)]
    fragmented = 1 if len(pieces) > 1 else 0
    return [
        mavlink.MAVLink_gps_rtcm_data_message(
            head | (n & _NUMBERS) << 1 | fragmented, len(piece), list(piece.ljust(_PIECE, b"\0"))
        )
        for n, piece in enumerate(pieces)
    ]
