"""A line of an RC receiver under test, and streams of channels, for SBUS and CRSF alike."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from companion.config.devices import SensorConfig
from companion.core.readings import RcInput
from companion.io.sensors import open_sensor
from tests.wires import Wire

PERIOD_S = 0.014
CENTRE, LOW, HIGH = 992, 192, 1792  # 1500, 1000 and 2000 µs
ANY_STREAM = {
    "values": st.lists(st.integers(0, 2047), min_size=16, max_size=16),
    "noise": st.binary(max_size=40),
    "sizes": st.lists(st.integers(1, 40), min_size=1, max_size=8),
}
"""Channels, noise before them, and the sizes of the chunks in which they arrive."""


def packed(values: tuple[int, ...]) -> bytes:
    """Sixteen channels of 11 bits, the lowest bit first. `values`: of the first; the others are at the centre."""
    bits = 0
    for n, value in enumerate((*values, *(CENTRE for _ in range(16 - len(values))))):
        bits |= value << (11 * n)
    return bits.to_bytes(22, "little")


def cut(stream: bytes, sizes: list[int]) -> list[bytes]:
    """The stream in chunks of these sizes, again and again."""
    chunks, at = [], 0
    while at < len(stream):
        chunks.append(stream[at : at + sizes[len(chunks) % len(sizes)]])
        at += len(chunks[-1])
    return chunks


def in_shares(values: list[int]) -> tuple[float, ...]:
    """What a reading says for these values of channels."""
    return tuple(max(-1.4, min(1.4, (round(880 + 0.625 * value) - 1500) / 500)) for value in values)


class Line:
    """A driver and its wire: `hear` lets chunks arrive one by one, and reads."""

    def __init__(self, driver: str = "sbus", **more: Any) -> None:
        self.wire = Wire()
        self.sensor: Any = open_sensor(SensorConfig("rc", driver, "serial:/dev/x:100000", **more), self.wire)
        self.now_s, self.period_s = 0.0, PERIOD_S

    def hear(self, *chunks: bytes, every_s: float | None = None) -> list[RcInput]:
        found: list[RcInput] = []
        for chunk in chunks:
            self.now_s += self.period_s if every_s is None else every_s
            self.wire.chunks = [(self.now_s, chunk)]
            found += self.sensor.read(self.now_s)
        return found
