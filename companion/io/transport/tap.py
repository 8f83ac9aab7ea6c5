"""A second reader of a port: several devices behind one multiplexer, each with a driver of its own."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from companion.core.ports import ByteStream

_MOST_CHUNKS = 256  # of a reader that does not read; it loses the oldest


class Tap:
    """A ByteStream with the bytes that its port has given to the first reader. That reader opens, waits on and closes
    the port."""

    def __init__(self, name: str, line: ByteStream) -> None:
        self.name = name
        self._line = line
        self._chunks: deque[tuple[float, bytes]] = deque(maxlen=_MOST_CHUNKS)

    def put(self, chunks: Sequence[tuple[float, bytes]]) -> None:
        """Bytes that the first reader has read."""
        self._chunks.extend(chunks)

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        """See `ByteStream`."""
        chunks = list(self._chunks)
        self._chunks.clear()
        return chunks

    def write(self, data: bytes, now_s: float) -> None:
        """Write to the shared port."""
        self._line.write(data, now_s)

    def fault(self) -> str | None:
        """The fault of the shared port."""
        return self._line.fault()

    def fileno(self) -> int | None:
        """None: the first reader waits on the port."""
        return None

    def close(self) -> None:
        """Forget what is unread. The port stays open."""
        self._chunks.clear()
