"""What signatures have reached, packet by packet, in the computer's memory: it outlives the process, not the boot.

`signing.json` is written every few seconds with a time that lies ahead, so that nothing counts twice after a power cut.
A process that starts again at once would be deaf until then. It goes on exactly where the one before was killed, by
this file in /dev/shm, which no medium can slow down. Without such a folder, or after a boot, the horizon in
`signing.json` counts.
"""

from __future__ import annotations

import contextlib
import hashlib
import mmap
import os
import stat
import struct
from pathlib import Path

from companion.io.mavlink.wire.signing import MOST_STREAMS, Recollection, SigningState, Stream

FOLDER = Path("/dev/shm")
_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
_HEAD = struct.Struct("<8s16s16sQQ")  # magic, boot, key, now, floor
_SLOT = struct.Struct("<4BxxxxQ")  # whether used, system, component, link, last stamp
_STAMP = struct.Struct("<Q")
_NOW_AT, _STAMP_AT = 40, 8
_MAGIC = b"USVSIGN1"
_MOST_AHEAD = 1_000_000  # 10 s: how far ahead of our time a horizon is stored
_SIZE = _HEAD.size + MOST_STREAMS * _SLOT.size


class SharedStreamMemory:
    """A `StreamMemory` in a file of FOLDER, one for each state directory and user. It is made with the first key, and
    deleted when the process ends in order. Where it cannot be made, nothing is remembered."""

    def __init__(self, directory: Path, folder: Path = FOLDER, boot_id: str | None = None) -> None:
        """`directory`: the state directory that the key is from. `boot_id`: names this boot; None: the kernel's."""
        name = hashlib.sha256(os.fsencode(os.path.realpath(directory))).hexdigest()[:16]
        self.path = folder / f"usv-companion-{os.geteuid()}-{name}"
        self._boot = hashlib.sha256((_boot_id() if boot_id is None else boot_id).encode()).digest()[:16]
        self._memory: mmap.mmap | None = None
        self._slots: dict[Stream, int] = {}

    def recall(self, state: SigningState) -> Recollection | None:
        """As `StreamMemory.recall`."""
        if state.key is None or not state.horizon:
            return None
        try:
            fd = os.open(self.path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            with os.fdopen(fd, "rb") as file:
                data = file.read(_SIZE) if _ours(fd) else b""
        except OSError:
            return None
        if len(data) != _SIZE:
            return None
        magic, boot, key, now, floor = _HEAD.unpack_from(data)
        if (magic, boot, key) != (_MAGIC, self._boot, _print_of(state.key)) or not _follows(now, state.horizon):
            return None
        slots = [_SLOT.unpack_from(data, at) for at in range(_HEAD.size, _SIZE, _SLOT.size)]
        streams = {(system, component, link): stamp for used, system, component, link, stamp in slots if used}
        return Recollection(now, floor, streams)

    def begin(self, key: bytes | None, known: Recollection) -> None:
        """As `StreamMemory.begin`."""
        if key is None:
            self.close()
            return
        memory = self._memory = self._made() if self._memory is None else self._memory
        if memory is None:
            return
        self._slots = {stream: number for number, stream in enumerate(list(known.streams)[:MOST_STREAMS])}
        content = bytearray(_SIZE)
        _HEAD.pack_into(content, 0, b"", self._boot, _print_of(key), known.now, known.floor)
        for stream, number in self._slots.items():
            _SLOT.pack_into(content, _place(number), 1, *stream, known.streams[stream])
        memory[:8] = bytes(8)  # not valid while it changes
        memory[8:] = bytes(content[8:])
        memory[:8] = _MAGIC

    def note(self, now: int, stream: Stream | None = None, stamp: int = 0) -> None:
        """As `StreamMemory.note`."""
        if self._memory is None:
            return
        _STAMP.pack_into(self._memory, _NOW_AT, now)
        if stream is None:
            return
        number = self._slots.get(stream)
        if number is not None:
            _STAMP.pack_into(self._memory, _place(number) + _STAMP_AT, stamp)
        elif len(self._slots) < MOST_STREAMS:
            number = self._slots[stream] = len(self._slots)
            _STAMP.pack_into(self._memory, _place(number) + _STAMP_AT, stamp)
            struct.pack_into("<4B", self._memory, _place(number), 1, *stream)

    def close(self) -> None:
        """As `StreamMemory.close`."""
        if self._memory is not None:
            self._memory.close()
            self._memory = None
            with contextlib.suppress(OSError):
                self.path.unlink()

    def _made(self) -> mmap.mmap | None:
        """Make the file anew; None where that is not possible."""
        try:
            with contextlib.suppress(FileNotFoundError):
                self.path.unlink()
            fd = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        except OSError:
            return None
        try:
            os.posix_fallocate(fd, 0, _SIZE)  # so that a full folder is told here, and not by a signal later
            return mmap.mmap(fd, _SIZE)
        except OSError:
            return None
        finally:
            os.close(fd)


def _follows(now: int, horizon: int) -> bool:
    """Whether the process that noted `now` also stored `horizon`: another one might have gone on without this file."""
    return now + _MOST_AHEAD >= horizon


def _place(number: int) -> int:
    return _HEAD.size + number * _SLOT.size


def _print_of(key: bytes) -> bytes:
    return hashlib.sha256(b"usv-companion stream memory" + key).digest()[:16]


def _ours(fd: int) -> bool:
    found = os.fstat(fd)
    return stat.S_ISREG(found.st_mode) and found.st_uid == os.geteuid() and not found.st_mode & 0o077


def _boot_id() -> str:
    try:
        return _BOOT_ID.read_text()
    except OSError:
        return ""
