"""Chart tiles from a PMTiles file. Source: PMTiles specification, version 3.

A header of 127 bytes, directories of which each entry is a run of tiles or a further directory, and the tiles. A tile's
number counts along Hilbert's curve, zoom by zoom.
"""

from __future__ import annotations

import functools
import gzip
import json
import struct
import zlib
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import zstandard

MAGIC = b"PMTiles"
_HEADER = struct.Struct("<7sB11Q6B")
_VERSION = 3
_TYPES = {2: "image/png", 3: "image/jpeg", 4: "image/webp", 5: "image/avif"}
_NONE, _GZIP, _ZSTD = (0, 1), 2, 4
_DEEPEST = 4  # directories below the root
_MOST_BYTES = 64 << 20  # of a directory or a tile: a damaged length must not fill the memory
_DAMAGE = (OSError, EOFError, ValueError, IndexError, struct.error, zlib.error, zstandard.ZstdError)


class DamagedTiles(ValueError):
    """What is no PMTiles file that can be shown: one line that says why."""


@dataclass(frozen=True, slots=True)
class _Entry:
    """Tiles from the number `first` on, `run` of them; `run` 0: a directory. Its place and size in bytes."""

    first: int
    run: int
    offset: int
    size: int


class PmTiles:
    """The tiles of one file, by zoom, column and row from the north."""

    def __init__(self, path: Path) -> None:
        """Raises DamagedTiles for a file that is no PMTiles or holds vectors, OSError."""
        self._path = path
        with path.open("rb") as file:
            head = file.read(_HEADER.size)
        if len(head) < _HEADER.size or not head.startswith(MAGIC):
            raise DamagedTiles("no PMTiles")
        values = _HEADER.unpack(head)
        if values[1] != _VERSION:
            raise DamagedTiles(f"PMTiles version {values[1]}; this reads version {_VERSION}")
        self._root: tuple[int, int] = (values[2], values[3])
        self._leaves, self._data = int(values[6]), int(values[8])
        _, self._packing, self._tile_packing, kind, *zooms = values[13:19]
        if kind not in _TYPES:
            raise DamagedTiles("vector tiles; the chart shows PNG, JPEG, WebP and AVIF")
        self._kind = _TYPES[kind]
        self.zooms = (int(zooms[0]), int(zooms[1]))
        try:
            words = json.loads(self._unpacked(values[4], values[5], self._packing) or b"{}")
            self._directory(*self._root)
        except _DAMAGE as error:
            raise DamagedTiles(f"damaged: {error}") from error
        self.attribution = str(words.get("attribution", "")) if isinstance(words, dict) else ""

    def tile(self, zoom: int, column: int, row: int) -> tuple[bytes, str] | None:
        """(image, its type), or None where there is none, or the file is damaged there."""
        if not (self.zooms[0] <= zoom <= self.zooms[1] and 0 <= column < 1 << zoom and 0 <= row < 1 << zoom):
            return None
        number, place = tile_number(zoom, column, row), self._root
        try:
            for _ in range(_DEEPEST):
                entry = _covering(self._directory(*place), number)
                if entry is None:
                    return None
                if entry.run:
                    return self._unpacked(self._data + entry.offset, entry.size, self._tile_packing), self._kind
                place = (self._leaves + entry.offset, entry.size)
        except _DAMAGE:
            return None
        return None

    def _unpacked(self, offset: int, size: int, packing: int) -> bytes:
        if size > _MOST_BYTES:
            raise ValueError(f"{size} bytes in one piece")
        with self._path.open("rb") as file:
            file.seek(offset)
            data = file.read(size)
        if packing in _NONE:
            return data
        if packing == _GZIP:
            return gzip.decompress(data)
        if packing == _ZSTD:
            return zstandard.ZstdDecompressor().decompress(data, max_output_size=_MOST_BYTES)
        raise ValueError(f"compression {packing} is not known here")

    @functools.lru_cache(64)  # noqa: B019  one file for the life of the console
    def _directory(self, offset: int, size: int) -> tuple[_Entry, ...]:
        numbers = _varints(self._unpacked(offset, size, self._packing))
        count = next(numbers)
        firsts, runs, sizes, places = ([next(numbers) for _ in range(count)] for _ in range(4))
        entries: list[_Entry] = []
        number = 0
        for step, run, length, place in zip(firsts, runs, sizes, places, strict=True):
            number += step
            follows = entries[-1].offset + entries[-1].size if entries else 0
            entries.append(_Entry(number, run, place - 1 if place else follows, length))
        return tuple(entries)


def tile_number(zoom: int, column: int, row: int) -> int:
    """The number of a tile: those of all smaller zooms come first, then Hilbert's curve."""
    number = ((1 << 2 * zoom) - 1) // 3
    x, y = column, row
    for bit in range(zoom - 1, -1, -1):
        side = 1 << bit
        right, down = x & side, y & side
        number += ((3 * right) ^ down) << bit
        if not down:
            x, y = (side - 1 - y, side - 1 - x) if right else (y, x)
    return number


def _covering(entries: tuple[_Entry, ...], number: int) -> _Entry | None:
    """The entry with that tile, or with the directory in which it would be."""
    at = bisect_right(entries, number, key=lambda entry: entry.first) - 1
    if at < 0:
        return None
    entry = entries[at]
    return entry if entry.run == 0 or number < entry.first + entry.run else None


def _varints(data: bytes) -> Iterator[int]:
    value = shift = 0
    for byte in data:
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            yield value
            value = shift = 0
    raise EOFError("a directory is cut off")
