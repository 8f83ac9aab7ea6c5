"""A second reader of a port: several devices behind one multiplexer, each with a driver of its own."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from companion.core.ports import ByteStream

_MOST_CHUNKS = 256  # a reader that does not read loses the oldest


class Tap:
    """A ByteStream that gives what its port has given to the first reader; that one opens it, waits on it and closes it."""

    def __init__(self, name: str, line: ByteStream) -> None:
        self.name = name
        self._line = line
        self._chunks: deque[tuple[float, bytes]] = deque(maxlen=_MOST_CHUNKS)

    def put(self, chunks: Sequence[tuple[float, bytes]]) -> None:
        self._chunks.extend(chunks)

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        chunks = list(self._chunks)
        self._chunks.clear()
        return chunks

    def write(self, data: bytes, now_s: float) -> None:
        self._line.write(data, now_s)

    def fault(self) -> str | None:
        return self._line.fault()

    def fileno(self) -> int | None:
        return None

    def close(self) -> None:
        self._chunks.clear()
