"""log.mcap: readings, ticks, events, packets and the boat's place, for a replay and for Foxglove, PlotJuggler, pandas.

Source: MCAP specification. Messages are protobuf with their descriptors in the file. Chunks are compressed with zstd
and written every `CHUNK_S`, and at once with a warning or worse; each is whole by itself, so that a file which ends
anywhere is readable up to its last whole chunk. There is no index: it would be larger than the data.

    /SOURCE/KIND      the readings of a device in a tick, exactly (`columns.py`)
    /tick             the end of a tick: estimate, setpoint, wrench exactly; `order` lists the channel of each reading
    /parameter        a parameter that changed during the run
    /packet           a MAVLink packet that came in, before the tick that follows
    /health           what a device's driver reports from then on; of a device that is well once a minute
    /log              an event, foxglove.Log
    /position, /pose, /tf   for viewers, 5 times a second: foxglove.LocationFix, PoseInFrame, FrameTransform
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator, Sequence
from itertools import repeat
from typing import Any

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, DataEnd, Footer, Header, McapRecord, Schema
from mcap.well_known import MessageEncoding, SchemaEncoding

from companion.core.decision import Event, TextKind
from companion.core.readings import KINDS, Reading
from companion.core.tick import DeviceHealth, Tick
from companion.record import log_schemas as schemas
from companion.record.columns import ColumnWriter, Layout, tick_us_of
from companion.record.protobuf import blob, descriptor_file, descriptor_set, packed_varints, tag, text, whole
from companion.record.reading_codec import CODECS
from companion.record.recorded import thruster_values, tick_values, unsteered_values

FILE = "log.mcap"
MAGIC = b"\x89MCAP0\r\n"
CHUNK_S = 2.0
_MOST_BYTES = 256 << 10  # of a chunk: a plan's upload does not wait for its time
_LEVEL = 3
_MESSAGE = struct.Struct("<BQHIQQ")
_OP_MESSAGE = 5
_VIEW_S = 0.2
_Key = tuple[type[Any], str]  # of a group of readings: their kind and source
_KIND_OF = {kind_type: kind for kind, kind_type in KINDS.items()}
_LEVELS = (5, 5, 5, 4, 3, 2, 2, 1)  # of foxglove.Log, from emergency to debug
_FIRST_QUIET = 5  # severities that wait for the chunk: notice, info, debug


class McapEncoder:
    """Ticks → chunks. Remembers the messages of the present chunk, and the columns of each device."""

    def __init__(self) -> None:
        self._compressor = zstandard.ZstdCompressor(level=_LEVEL)
        self._declared = [b"".join(map(_record, schemas.FIXED_RECORDS))]
        self._schemas: dict[Layout, int] = {}
        self._channels: dict[tuple[Layout, str], int] = {}
        self._next = schemas.FIRST_FREE
        self._writers: dict[_Key, ColumnWriter] = {}
        self._newest: dict[_Key, tuple[Layout, int]] = {}  # the layout in use, and its channel
        self._left_out: set[_Key] = set()
        self._new: list[bytes] = []  # schemas and channels that no chunk has followed yet
        self._messages: list[bytes] = []
        self._bytes = 0
        self._from_ns = self._now_ns = 0
        self._viewed_s = -math.inf
        self._urgent = False

    def header(self) -> bytes:
        """What a file begins with: all schemas and channels so far. Another thread may call this."""
        return MAGIC + _record(Header("", "usv-companion")) + b"".join(self._declared)

    def parameter(self, name: str, value: float) -> None:
        """A parameter that was changed under way."""
        self._add(schemas.PARAMETER, text(1, name) + tag(2, 1) + struct.pack("<d", value))

    def packet(self, persona: str, endpoint: str, t_s: float, packet: bytes) -> None:
        """A MAVLink packet that came in."""
        self._add(
            schemas.PACKET, tag(1, 1) + struct.pack("<d", t_s) + text(2, persona) + text(3, endpoint) + blob(4, packet)
        )

    def tick(self, tick: Tick, changed: Sequence[DeviceHealth]) -> None:
        """A tick, its readings and events, and the devices that are otherwise than before."""
        self._now_ns = tick.time_unix_ns
        for device in changed:
            self._add(schemas.HEALTH, text(1, device.name) + whole(2, device.ok) + text(3, device.text))
        order = self._readings(tick.readings, tick.nav.t_s)
        self._add(schemas.TICK, _tick_message(tick, order))
        for event in tick.events:
            self._event(event)
        if tick.nav.position_valid and abs(tick.t_s - self._viewed_s) > _VIEW_S - 0.01:
            self._viewed_s = tick.t_s
            for channel, message in schemas.views(tick):
                self._add(channel, message)

    def lone_readings(self, readings: Sequence[Reading], t_s: float, time_unix_ns: int) -> None:
        """The readings of a tick in which nothing is steered: a leader module's."""
        self._now_ns = time_unix_ns
        order = self._readings(readings, t_s)
        row = schemas.TICK_ROW.packed(unsteered_values(t_s))
        self._add(schemas.TICK, row + blob(schemas.ORDER, packed_varints(order)))

    def due(self) -> bytes:
        """The chunk, where it is time for it; else nothing."""
        late = self._now_ns - self._from_ns >= CHUNK_S * 1e9 or self._now_ns < self._from_ns
        return self.chunk() if late or self._urgent or self._bytes > _MOST_BYTES else b""

    def chunk(self) -> bytes:
        """What waits, as a chunk with the schemas and channels that are new."""
        if not self._messages:
            return b""
        data = b"".join(self._messages)
        new = b"".join(self._new)
        self._messages, self._new, self._bytes, self._urgent = [], [], 0, False
        first_ns, self._from_ns = min(self._from_ns, self._now_ns), self._now_ns
        compressed = self._compressor.compress(data)
        return new + _record(Chunk("zstd", compressed, self._now_ns, first_ns, zlib.crc32(data), len(data)))

    def drop(self) -> None:
        """Forget what waits: the log has stopped, and what it begins with next is to be whole."""
        self._messages, self._bytes, self._urgent = [], 0, False

    def end(self) -> bytes:
        """What waits, and the end of the file."""
        return self.chunk() + _record(DataEnd(0)) + _record(Footer(0, 0, 0)) + MAGIC

    def _add(self, channel: int, message: bytes) -> None:
        if not self._messages:
            self._from_ns = self._now_ns
        head = _MESSAGE.pack(_OP_MESSAGE, 22 + len(message), channel, 0, self._now_ns, self._now_ns)
        self._messages += (head, message)
        self._bytes += len(head) + len(message)

    def _readings(self, readings: Sequence[Reading], t_s: float) -> list[int]:
        """Write the readings. Returns the channel of each, in their order of arrival."""
        groups: dict[_Key, list[Any]] = {}
        keys: list[_Key] = []
        for reading in readings:
            key = (reading.__class__, reading.source)
            group = groups.get(key)
            if group is not None:
                group.append(reading)
            elif key[0] in _KIND_OF:
                groups[key] = [reading]
            else:
                continue  # a recorder never ends a run; a test sees to it that every kind has its row
            keys.append(key)
        now_us = tick_us_of(t_s)
        channels: dict[_Key, Iterator[int]] = {}
        for key, group in groups.items():
            try:
                channels[key] = self._channels_of(key, group, now_us)
            except (ArithmeticError, TypeError, ValueError, struct.error) as error:
                self._leave_out(key, error, t_s)
        return [next(channels[key]) for key in keys if key in channels]

    def _channels_of(self, key: _Key, readings: Sequence[Any], now_us: int) -> Iterator[int]:
        """Write the readings of one kind and source. Returns the channel of each. Raises what packing raises."""
        if (writer := self._writers.get(key)) is None:
            kind = _KIND_OF[key[0]]
            writer = self._writers[key] = ColumnWriter(kind, key[1], CODECS[kind])
        if writer.single:
            return iter([self._columns(writer, key, [reading], now_us) for reading in readings])
        return repeat(self._columns(writer, key, readings, now_us))

    def _leave_out(self, key: _Key, error: Exception, t_s: float) -> None:
        """A reading that cannot be packed is a mistake of this program, and must not end a boat's run: its tick goes
        without, and the log says so, once for each device and kind."""
        if key not in self._left_out:
            self._left_out.add(key)
            said = f"{key[1]}: readings left out of the log ({type(error).__name__}: {error})"
            self._event(Event(t_s, TextKind.ATTENTION, "log_left_out", said))

    def _columns(self, writer: ColumnWriter, key: _Key, readings: Sequence[Any], now_us: int) -> int:
        """Write a message of these readings. Returns its channel."""
        message = writer.message(readings, now_us)
        layout, channel = self._newest.get(key, (None, 0))
        if layout is not writer.layout:
            channel = self._channel(writer.layout, key[1])
            self._newest[key] = writer.layout, channel
        self._add(channel, message)
        return channel

    def _channel(self, layout: Layout, source: str) -> int:
        """The channel of these columns; it is declared before the chunk, and in each file that begins later."""
        if (layout, source) in self._channels:
            return self._channels[layout, source]
        declared = b""
        if layout not in self._schemas:
            self._schemas[layout] = self._next
            file = descriptor_file(f"usv/{layout.schema_name}.proto", "usv", [layout.message])
            declared = _record(
                Schema(self._next, descriptor_set([file]), SchemaEncoding.Protobuf, f"usv.{layout.schema_name}")
            )
            self._next += 1
        number = self._next
        self._next += 1
        topic = f"/{source}/{layout.kind}"
        declared += _record(Channel(number, topic, MessageEncoding.Protobuf, layout.metadata, self._schemas[layout]))
        self._channels[layout, source] = number
        self._declared.append(declared)
        self._new.append(declared)
        return number

    def _event(self, event: Event) -> None:
        level = whole(2, _LEVELS[event.severity])
        self._add(schemas.LOG, schemas.stamp(1, self._now_ns) + level + text(3, event.text) + text(4, event.name))
        self._urgent = self._urgent or event.severity < _FIRST_QUIET


def _tick_message(tick: Tick, order: Sequence[int]) -> bytes:
    throttles, azimuths = thruster_values(tick)
    commands = tick.command.thrusters
    count = f"<{len(commands)}f"
    parts = [
        schemas.TICK_ROW.packed(tick_values(tick)),
        schemas.TICK_MORE.packed(schemas.more_values(tick)),
        text(schemas.MODE, tick.status.mode.word),
        text(schemas.FAILSAFES, ";".join(tick.status.failsafes)) if tick.status.failsafes else b"",
        blob(schemas.ORDER, packed_varints(order)),
        blob(schemas.THROTTLE, struct.pack(count, *schemas.rounded([t.throttle for t in commands]))),
        blob(schemas.AZIMUTH, struct.pack(count, *schemas.rounded([schemas.or_nan(t.azimuth_rad) for t in commands]))),
        blob(schemas.FORCE, struct.pack(count, *schemas.rounded([t.force_n for t in commands]))),
    ]
    if throttles:
        count = f"<{len(throttles)}d"
        parts.append(blob(schemas.SET_THROTTLE, struct.pack(count, *throttles)))
        parts.append(blob(schemas.SET_AZIMUTH, struct.pack(count, *azimuths)))
    return b"".join(parts)


def _record(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
