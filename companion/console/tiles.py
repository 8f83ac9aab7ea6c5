"""Chart tiles from a file on this computer: PMTiles 3, or MBTiles 1.3 (SQLite; its rows count from the south)."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Protocol

from companion.console import pmtiles

_KINDS = ((b"\x89PNG", "image/png"), (b"\xff\xd8", "image/jpeg"), (b"RIFF", "image/webp"))


class TileError(Exception):
    """A file that holds no tiles: one line that says why."""


class Tiles(Protocol):
    """The tiles of one file, by zoom, column and row from the north. `zooms`: the least and the largest."""

    zooms: tuple[int, int]
    attribution: str

    def tile(self, zoom: int, column: int, row: int) -> tuple[bytes, str] | None:
        """(image, its type), or None where there is none."""
        ...


def open_tiles(path: Path) -> Tiles:
    """The tiles of a file, by what it begins with. Raises TileError."""
    try:
        with path.open("rb") as file:
            begin = file.read(len(pmtiles.MAGIC))
        return pmtiles.PmTiles(path) if begin == pmtiles.MAGIC else MbTiles(path)
    except pmtiles.DamagedTiles as error:
        raise TileError(f"{path}: {error}") from error
    except OSError as error:
        raise TileError(f"{path}: {error.strerror or error}") from error


class MbTiles:
    """The tiles of an MBTiles file."""

    def __init__(self, path: Path) -> None:
        """Raises TileError for a file that is no MBTiles, or holds vectors."""
        self._path = path
        try:
            with closing(self._open()) as database:
                rows = dict(database.execute("SELECT name, value FROM metadata").fetchall())
                zooms = database.execute("SELECT min(zoom_level), max(zoom_level) FROM tiles").fetchone()
        except sqlite3.Error as error:
            raise TileError(f"{path}: neither PMTiles nor MBTiles: {error}") from error
        if rows.get("format") == "pbf":
            raise TileError(f"{path}: vector tiles; the chart shows PNG, JPEG and WebP")
        self.zooms = (int(zooms[0] or 0), int(zooms[1] or 0))
        self.attribution = str(rows.get("attribution", ""))

    def _open(self) -> sqlite3.Connection:
        return sqlite3.connect(f"{self._path.absolute().as_uri()}?mode=ro", uri=True)

    def tile(self, zoom: int, column: int, row: int) -> tuple[bytes, str] | None:
        """(image, its type), or None where there is none."""
        with closing(self._open()) as database:
            found = database.execute(
                "SELECT tile_data FROM tiles WHERE zoom_level = ? AND tile_column = ? AND tile_row = ?",
                (zoom, column, (1 << zoom) - 1 - row),
            ).fetchone()
        if found is None:
            return None
        data = bytes(found[0])
        return data, next((kind for start, kind in _KINDS if data.startswith(start)), "application/octet-stream")
