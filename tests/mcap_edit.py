"""Takes messages out of a log.mcap."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk

from companion.record.mcap_log import MAGIC


def without(path: Path, unwanted: Callable[[str, bytes], bool]) -> int:
    """Take out the messages of which `unwanted(topic, data)` is true. Returns how many there were."""
    builder, topics, gone = RecordBuilder(), dict[int, str](), 0
    builder.write(MAGIC)
    for record in StreamReader(BytesIO(path.read_bytes()), emit_chunks=True).records:
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        if not isinstance(record, Chunk):
            record.write(builder)
            continue
        kept = RecordBuilder()
        for message in breakup_chunk(record):
            assert isinstance(message, Message)
            if unwanted(topics[message.channel_id], message.data):
                gone += 1
            else:
                message.write(kept)
        data = kept.end()
        Chunk("", data, record.message_end_time, record.message_start_time, zlib.crc32(data), len(data)).write(builder)
    builder.write(MAGIC)
    path.write_bytes(builder.end())
    return gone
