"""Reads log.mcap, whatever ended the run that wrote it: chunks that are whole are read, the rest is left out with a
warning."""

from __future__ import annotations

import os
import struct
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import breakup_chunk

from companion.core.readings import Reading
from companion.core.tick import DeviceHealth
from companion.record import log_schemas as schemas
from companion.record.columns import ColumnReader, tick_us_of
from companion.record.mcap_log import MAGIC
from companion.record.protobuf import parts_of, varints
from companion.record.reading_codec import CODECS
from companion.record.recorded import TICK_COLUMNS, RecordedPacket, RecordedTick, tick_of

_DAMAGE = (
    ValueError,
    KeyError,
    IndexError,
    TypeError,
    struct.error,
    zstandard.ZstdError,
    McapError,
)
_HEAD = struct.Struct("<BQ")
_SEEN = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.CHUNK)
_FLOAT_TICK = struct.Struct("<d")


@dataclass(frozen=True, slots=True)
class LoggedMessage:
    """A message of the file: its topic, the name of its schema, when it was logged (Unix time), its bytes."""

    channel: Channel
    schema: str
    unix_ns: int
    data: bytes


def messages(path: Path, warnings: list[str]) -> Iterator[LoggedMessage]:
    """All messages in order. What is damaged or cut off is left out, each with a warning. Raises OSError."""
    channels: dict[int, Channel] = {}
    names: dict[int, str] = {0: ""}
    for opcode, at, body in _records(path, warnings):
        try:
            stream = ReadDataStream(BytesIO(body))
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                names[schema.id] = schema.name
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(stream)
                channels[channel.id] = channel
            else:
                for record in breakup_chunk(Chunk.read(stream), validate_crc=True):
                    if isinstance(record, Message):
                        channel = channels[record.channel_id]
                        yield LoggedMessage(channel, names[channel.schema_id], record.log_time, record.data)
        except _DAMAGE as error:
            warnings.append(f"{path.name}: {Opcode(opcode).name.lower()} at byte {at} left out: {error}")


def has_end(path: Path) -> bool:
    """Whether the run that wrote the file has ended it; that of a power cut, or one that goes on, has not. Raises
    OSError."""
    with path.open("rb") as file:
        file.seek(-min(len(MAGIC), path.stat().st_size), os.SEEK_END)
        return file.read() == MAGIC and file.tell() > len(MAGIC)


def _records(path: Path, warnings: list[str]) -> Iterator[tuple[int, int, bytes]]:
    """(opcode, place, content) of each record that matters."""
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            warnings.append(f"{path.name}: not an MCAP file, or empty")
            return
        at = len(MAGIC)
        while head := file.read(_HEAD.size):
            if len(head) < _HEAD.size:
                break
            opcode, size = _HEAD.unpack(head)
            if opcode == Opcode.FOOTER:
                return
            body = file.read(size) if size < 1 << 32 else b""
            if len(body) < size:
                break
            if opcode in _SEEN:
                yield opcode, at, body
            at += _HEAD.size + size
    warnings.append(f"{path.name}: ends without its footer: the run was cut off; read up to byte {at}")


@dataclass(slots=True)
class _Gathered:
    """The messages of one tick."""

    columns: list[tuple[int, bytes]] = field(default_factory=list)
    parameters: list[tuple[str, float]] = field(default_factory=list)
    packets: list[RecordedPacket] = field(default_factory=list)
    health: list[DeviceHealth] = field(default_factory=list)


def read_ticks(path: Path, warnings: list[str]) -> Iterator[RecordedTick]:
    """The ticks of a log. What is damaged is left out, and so are readings that no tick follows, each with a warning.
    Raises OSError."""
    readers: dict[int, ColumnReader] = {}
    gathered = _Gathered()
    for message in messages(path, warnings):
        number = message.channel.id
        try:
            if number == schemas.TICK:
                done, gathered = gathered, _Gathered()
                yield _tick(message.data, done, readers)
            elif number >= schemas.FIRST_FREE:
                if number not in readers:
                    readers[number] = _reader(message.channel)
                gathered.columns.append((number, message.data))
            else:
                _take(number, message.data, gathered)
        except _DAMAGE as error:
            warnings.append(f"{path.name}: {message.channel.topic} left out: {error}")
    if gathered.columns:
        warnings.append(f"{path.name}: ends within a tick; its readings are left out")


def read_kind(path: Path, kind: str, warnings: list[str]) -> list[Reading]:
    """The readings of one kind (a key of KINDS). What is damaged is left out with a warning. Raises OSError."""
    found: list[Reading] = []
    readers: dict[int, ColumnReader] = {}
    waiting: list[tuple[int, bytes]] = []
    for message in messages(path, warnings):
        number = message.channel.id
        try:
            if number == schemas.TICK and waiting:
                now_us = tick_us_of(_time_of(message.data))
                done, waiting = waiting, []
                for each, data in done:
                    found += readers[each].readings(data, now_us)
            elif number >= schemas.FIRST_FREE and message.channel.metadata.get("kind") == kind:
                readers.setdefault(number, _reader(message.channel))
                waiting.append((number, message.data))
        except _DAMAGE as error:
            warnings.append(f"{path.name}: {message.channel.topic} left out: {error}")
    return found


def read_health(path: Path, warnings: list[str]) -> list[tuple[int, DeviceHealth]]:
    """(Unix time in ns, health) of each report of a device. What is damaged is left out with a warning. Raises
    OSError."""
    gathered = _Gathered()
    times: list[int] = []
    for message in messages(path, warnings):
        if message.channel.id == schemas.HEALTH:
            try:
                _take(schemas.HEALTH, message.data, gathered)
                times.append(message.unix_ns)
            except _DAMAGE as error:
                warnings.append(f"{path.name}: {message.channel.topic} left out: {error}")
    return list(zip(times, gathered.health, strict=True))


def _reader(channel: Channel) -> ColumnReader:
    return ColumnReader(CODECS[channel.metadata["kind"]], channel.metadata)


def _take(number: int, data: bytes, gathered: _Gathered) -> None:
    values = {field: value or whole for field, whole, value in parts_of(data)}
    if number == schemas.PARAMETER:
        gathered.parameters.append((_text(values, 1), _double(values[2])))
    elif number == schemas.PACKET:
        packet = values.get(4, b"")
        assert isinstance(packet, bytes)
        gathered.packets.append(RecordedPacket(_double(values[1]), _text(values, 2), _text(values, 3), packet))
    elif number == schemas.HEALTH:
        gathered.health.append(DeviceHealth(_text(values, 1), bool(values.get(2, 0)), None, _text(values, 3)))


def _text(values: dict[int, bytes | int], number: int) -> str:
    value = values.get(number) or b""
    return value.decode() if isinstance(value, bytes) else ""


def _double(value: bytes | int) -> float:
    number: float = _FLOAT_TICK.unpack(value if isinstance(value, bytes) else b"")[0]
    return number


def _time_of(data: bytes) -> float:
    return next(_double(value) for number, _, value in parts_of(data) if number == schemas.FIRST_VALUE)


def _tick(data: bytes, gathered: _Gathered, readers: dict[int, ColumnReader]) -> RecordedTick:
    values: dict[int, float] = {}
    order: list[int] = []
    thrusters: dict[int, tuple[float, ...]] = {schemas.SET_THROTTLE: (), schemas.SET_AZIMUTH: ()}
    for number, _, value in parts_of(data):
        if number >= schemas.FIRST_VALUE:
            if number < schemas.FIRST_VALUE + len(TICK_COLUMNS):
                values[number] = _double(value)
        elif number == schemas.ORDER:
            order = varints(value)
        elif number in thrusters:
            thrusters[number] = struct.unpack(f"<{len(value) // 8}d", value)
    row = [values[schemas.FIRST_VALUE + at] for at in range(len(TICK_COLUMNS))]
    now_us = tick_us_of(row[0])
    waiting: dict[int, deque[Reading]] = {}
    for number, message in gathered.columns:
        waiting.setdefault(number, deque()).extend(readers[number].readings(message, now_us))
    readings = tuple(waiting[number].popleft() for number in order)
    changes = tuple(gathered.parameters)
    tick = tick_of(row, thrusters[schemas.SET_THROTTLE], thrusters[schemas.SET_AZIMUTH], readings, changes)
    return replace(tick, packets=tuple(gathered.packets), health=tuple(gathered.health))
