"""Ports in memory, for drivers and recognisers under test."""

from __future__ import annotations

from collections.abc import Sequence


class Wire:
    """A `ByteStream` that only brings bytes: `chunks`, (vessel time, bytes), are read once."""

    name = "wire"

    def __init__(self, chunks: Sequence[tuple[float, bytes]] = ()) -> None:
        self.chunks = list(chunks)

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        chunks, self.chunks = self.chunks, []
        return chunks

    def write(self, data: bytes, now_s: float) -> None: ...

    def fault(self) -> str | None:
        return None

    def fileno(self) -> int | None:
        return None

    def close(self) -> None: ...


class Listening(Wire):
    """A `Wire` that keeps what is written to it in `sent`, (vessel time, bytes), and is `broken` when told so."""

    def __init__(self) -> None:
        super().__init__()
        self.sent: list[tuple[float, bytes]] = []
        self.broken: str | None = None

    def write(self, data: bytes, now_s: float) -> None:
        self.sent.append((now_s, data))

    def fault(self) -> str | None:
        return self.broken
