"""`memory:` streams: ports whose other end is an emulated device in the same process."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

from sitl.noise import stream

_MAX_BYTES = 65536  # limit in each direction; a side that does not read loses the oldest bytes
_SOON_S = 1e-9
_GARBLED_SHARE = 0.1


def garbling(seed: int, name: str) -> Callable[[bytes], bytes]:
    """What a bad line makes of bytes: one in ten becomes another, by the seed."""
    draws = stream(seed, f"{name} garbled")

    def garbles(data: bytes) -> bytes:
        return bytes([draws.randrange(256) if draws.random() < _GARBLED_SHARE else byte for byte in data])

    return garbles


class _Queue:
    """A bounded queue of chunks, each with the time from which it can be read."""

    __slots__ = ("_bytes", "_chunks")

    def __init__(self) -> None:
        self._chunks: deque[tuple[float, bytes]] = deque()
        self._bytes = 0

    def put(self, t_s: float, data: bytes) -> None:
        """Add a chunk that can be read from `t_s`; drop the oldest beyond the limit."""
        chunks = self._chunks
        chunks.append((t_s, data))
        self._bytes += len(data)
        while self._bytes > _MAX_BYTES:
            self._bytes -= len(chunks.popleft()[1])

    def take(self, now_s: float) -> list[tuple[float, bytes]]:
        """Remove and return the chunks that can be read by `now_s`."""
        chunks, taken = self._chunks, []
        while chunks and chunks[0][0] <= now_s + _SOON_S:
            chunk = chunks.popleft()
            self._bytes -= len(chunk[1])
            taken.append(chunk)
        return taken

    def clear(self) -> None:
        """Drop all chunks."""
        self._chunks.clear()
        self._bytes = 0


class MemoryStream:
    """The host's end of a memory stream: a `companion.core.ports.ByteStream`."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.device = MemoryDevice(self)
        self.to_host = _Queue()
        self.to_device = _Queue()
        self.plugged = True
        self.garbles: Callable[[bytes], bytes] | None = None  # what a bad line makes of bytes, either way
        self._closed = False

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        """(time of arrival, bytes) of each chunk that has arrived by `now_s`."""
        return self.to_host.take(now_s) if self.plugged and not self._closed else ()

    def write(self, data: bytes, now_s: float) -> None:
        """Send to the device."""
        if self.plugged and not self._closed:
            self.to_device.put(now_s, data if self.garbles is None else self.garbles(data))
            if self.device.wake is not None:
                self.device.wake(now_s)

    def fault(self) -> str | None:
        """One line of text while the stream is closed or unplugged, else None."""
        if self._closed:
            return "closed"
        return None if self.plugged else f"memory:{self.name}: no such device; is it plugged in?"

    def fileno(self) -> int | None:
        """None: there is no descriptor."""
        return None

    def close(self) -> None:
        """Close the stream and lose the bytes in transit to the host."""
        self._closed = True
        self.to_host.clear()

    def reopen(self) -> None:
        """Open again after `close`. Bytes that arrived meanwhile are lost."""
        if self._closed:
            self._closed = False
            self.to_host.clear()


class MemoryDevice:
    """The device's end. `unplug` removes the port and all bytes in transit; `plug` restores it.

    A device that answers at once, not at the world's next step, sets `wake(now_s)`: it is called when the host has
    written.
    """

    __slots__ = ("_stream", "wake")

    def __init__(self, stream: MemoryStream) -> None:
        self._stream = stream
        self.wake: Callable[[float], None] | None = None

    def send(self, data: bytes, t_s: float) -> None:
        """Send bytes that arrive at the host at `t_s`."""
        if self._stream.plugged:
            garbles = self._stream.garbles
            self._stream.to_host.put(t_s, data if garbles is None else garbles(data))

    def receive(self, now_s: float) -> list[tuple[float, bytes]]:
        """(time, bytes) that the host has written by `now_s`."""
        return self._stream.to_device.take(now_s)

    def unplug(self) -> None:
        """Remove the port."""
        self._stream.plugged = False
        self._stream.to_host.clear()
        self._stream.to_device.clear()

    def plug(self) -> None:
        """Bring the port back."""
        self._stream.plugged = True
