"""Tiles from an MBTiles file."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from companion.console.tiles import TileError, Tiles


def tiles_file(path: Path, kind: str = "png") -> Path:
    with closing(sqlite3.connect(path)) as database:
        database.execute("CREATE TABLE metadata (name TEXT, value TEXT)")
        database.execute(
            "CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB)"
        )
        database.executemany("INSERT INTO metadata VALUES (?, ?)", [("format", kind), ("attribution", "Kartverket")])
        database.execute("INSERT INTO tiles VALUES (3, 4, 1, ?)", (b"\x89PNG tile",))
        database.commit()
    return path


def test_rows_count_from_the_north(tmp_path: Path) -> None:
    tiles = Tiles(tiles_file(tmp_path / "a.mbtiles"))
    assert tiles.tile(3, 4, 6) == (b"\x89PNG tile", "image/png")  # the second row from the south of eight
    assert tiles.tile(3, 4, 1) is None
    assert tiles.zooms == (3, 3) and tiles.attribution == "Kartverket"


def test_what_cannot_be_shown_is_said(tmp_path: Path) -> None:
    with pytest.raises(TileError, match="vector"):
        Tiles(tiles_file(tmp_path / "b.mbtiles", "pbf"))
    (tmp_path / "c.mbtiles").write_text("no database")
    with pytest.raises(TileError, match="no MBTiles"):
        Tiles(tmp_path / "c.mbtiles")
    with pytest.raises(TileError):
        Tiles(tmp_path / "missing.mbtiles")
