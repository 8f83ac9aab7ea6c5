"""readings.csv of older logs: every reading that reached the estimator.

One line a reading, in the order of arrival: `kind,source,values`. The values are base64 of the fields
(`reading_codec.py`). Lines of other kinds:

    tick       the end of a tick, after its readings: TICK_COLUMNS as float64, then throttle and azimuth of each
               thruster where the setpoint sets them
    parameter  a parameter that changed during the run: its name as source, its value
    packet     a MAVLink packet that came in: persona and endpoint as source; when it was handled, then its bytes
    health     what a device's driver reports from then on: one byte for well or not, then its text
"""

from __future__ import annotations

import binascii
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from companion.core.readings import Reading
from companion.core.tick import DeviceHealth
from companion.record.reading_codec import CODECS, floats
from companion.record.recorded import TICK_COLUMNS, RecordedPacket, RecordedTick, tick_of

FILE = "readings.csv"
HEADER = b"kind,source,values\n"


class _Gathered:
    """The lines of one tick. `take` returns the tick when its last line has come."""

    def __init__(self) -> None:
        self.readings: list[Reading] = []
        self._parameters: list[tuple[str, float]] = []
        self._packets: list[RecordedPacket] = []
        self._health: list[DeviceHealth] = []

    def take(self, line: bytes) -> RecordedTick | None:
        """Raises ValueError, KeyError, IndexError, TypeError or struct.error for a line that is damaged."""
        if not line.endswith(b"\n"):
            raise ValueError("cut off")
        kind, source, data = _parts(line)
        match kind:
            case "tick":
                tick = _tick_of(floats(data), tuple(self.readings), tuple(self._parameters))
                return replace(tick, packets=tuple(self._packets), health=tuple(self._health))
            case "parameter":
                self._parameters.append((source, floats(data)[0]))
            case "packet":
                persona, _, endpoint = source.partition(" ")
                self._packets.append(RecordedPacket(struct.unpack_from("<d", data)[0], persona, endpoint, data[8:]))
            case "health":
                self._health.append(DeviceHealth(source, bool(data[0]), None, data[1:].decode()))
            case _:
                self.readings.append(CODECS[kind].reading(source, data))
        return None


def read_ticks(path: Path, warnings: list[str]) -> Iterator[RecordedTick]:
    """The ticks of a readings.csv. A damaged line is left out, and so are readings that no tick follows, each with a
    warning. Raises OSError for a file that cannot be read."""
    gathered = _Gathered()
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if line == HEADER:
                continue
            try:
                tick = gathered.take(line)
            except (ValueError, KeyError, IndexError, struct.error, TypeError) as error:
                warnings.append(f"{path.name}:{number}: line left out: {error}")
                continue
            if tick is not None:
                yield tick
                gathered = _Gathered()
    if gathered.readings:
        warnings.append(f"{path.name}: ends within a tick; its {len(gathered.readings)} readings are left out")


def read_kind(path: Path, kind: str, warnings: list[str]) -> list[Reading]:
    """The readings of one kind (a key of KINDS), which takes a fraction of the time of all. A damaged line is left out
    with a warning. Raises OSError for a file that cannot be read."""
    codec = CODECS[kind]
    found: list[Reading] = []
    begin = f"{kind},".encode()
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if line.startswith(begin) and line.endswith(b"\n"):
                try:
                    _, source, data = _parts(line)
                    found.append(codec.reading(source, data))
                except (ValueError, IndexError, struct.error, TypeError) as error:
                    warnings.append(f"{path.name}:{number}: line left out: {error}")
    return found


def _parts(line: bytes) -> tuple[str, str, bytes]:
    """A line's kind, source and values."""
    kind, source, text = line.decode("ascii").split(",")
    return kind, source, binascii.a2b_base64(text, strict_mode=False)


def _tick_of(
    values: tuple[float, ...], readings: tuple[Reading, ...], changes: tuple[tuple[str, float], ...]
) -> RecordedTick:
    fixed = len(TICK_COLUMNS)
    if len(values) < fixed or (len(values) - fixed) % 2:
        raise ValueError(f"{len(values)} values, a tick has {fixed} and two a thruster")
    pairs = values[fixed:]
    return tick_of(values[:fixed], pairs[::2], pairs[1::2], readings, changes)
