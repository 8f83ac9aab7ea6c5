"""Tiles from a PMTiles or MBTiles file."""

from __future__ import annotations

import contextlib
import gzip
import sqlite3
import struct
from contextlib import closing
from pathlib import Path

import pytest

from companion.console.pmtiles import tile_number
from companion.console.tiles import TileError, open_tiles


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
    tiles = open_tiles(tiles_file(tmp_path / "a.mbtiles"))
    assert tiles.tile(3, 4, 6) == (b"\x89PNG tile", "image/png")  # the second row from the south of eight
    assert tiles.tile(3, 4, 1) is None
    assert tiles.zooms == (3, 3) and tiles.attribution == "Kartverket"


def test_what_cannot_be_shown_is_said(tmp_path: Path) -> None:
    with pytest.raises(TileError, match="vector"):
        open_tiles(tiles_file(tmp_path / "b.mbtiles", "pbf"))
    (tmp_path / "c.mbtiles").write_text("no database")
    with pytest.raises(TileError, match="neither PMTiles nor MBTiles"):
        open_tiles(tmp_path / "c.mbtiles")
    with pytest.raises(TileError):
        open_tiles(tmp_path / "missing.mbtiles")


def varint(number: int) -> bytes:
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*out, number])


def directory(entries: list[tuple[int, int, int, int]]) -> bytes:
    """Of (number, run, size, offset)."""
    firsts = [entry[0] for entry in entries]
    steps = [first - before for first, before in zip(firsts, [0, *firsts], strict=False)]
    columns = (steps, *([entry[n] for entry in entries] for n in (1, 2)), [entry[3] + 1 for entry in entries])
    return gzip.compress(b"".join(map(varint, (len(entries), *(value for column in columns for value in column)))))


def pmtiles_file(path: Path, kind: int = 2) -> Path:
    """Zoom 0, a run of three tiles of zoom 1 with one image, and zoom 2 in a directory of its own."""
    images = [b"\x89PNG world", b"\x89PNG quarter", b"\x89PNG corner"]
    starts = [sum(map(len, images[:n])) for n in range(3)]
    leaf = directory([(5, 1, len(images[2]), starts[2])])
    root = directory([(0, 1, len(images[0]), starts[0]), (1, 3, len(images[1]), starts[1]), (5, 0, len(leaf), 0)])
    about = gzip.compress(b'{"attribution": "Kartverket"}')
    places, at = [], 127
    for part in (root, about, leaf, b"".join(images)):
        places += [at, len(part)]
        at += len(part)
    head = struct.pack("<7sB11Q6B", b"PMTiles", 3, *places, 5, 4, 3, 1, 2, 1, kind, 0, 2)
    path.write_bytes(head.ljust(127, b"\0") + root + about + leaf + b"".join(images))
    return path


@pytest.mark.parametrize(
    ("place", "number"),
    [
        ((0, 0, 0), 0),
        ((1, 0, 0), 1),
        ((1, 0, 1), 2),
        ((1, 1, 1), 3),
        ((1, 1, 0), 4),
        ((2, 0, 0), 5),
        ((12, 3423, 1763), 19078479),  # of the specification
    ],
)
def test_tiles_are_numbered_along_hilberts_curve(place: tuple[int, int, int], number: int) -> None:
    assert tile_number(*place) == number


def test_every_tile_of_a_zoom_has_its_own_number() -> None:
    numbers = sorted(tile_number(4, column, row) for column in range(16) for row in range(16))
    assert numbers == list(range(85, 85 + 256))


def test_a_pmtiles_file_has_its_tiles(tmp_path: Path) -> None:
    tiles = open_tiles(pmtiles_file(tmp_path / "a.pmtiles"))
    assert tiles.zooms == (0, 2) and tiles.attribution == "Kartverket"
    assert tiles.tile(0, 0, 0) == (b"\x89PNG world", "image/png")
    assert [tiles.tile(1, *place) for place in ((0, 0), (0, 1), (1, 1))] == [(b"\x89PNG quarter", "image/png")] * 3
    assert tiles.tile(1, 1, 0) is None  # beyond the run
    assert tiles.tile(2, 0, 0) == (b"\x89PNG corner", "image/png") and tiles.tile(2, 3, 3) is None
    assert tiles.tile(3, 0, 0) is None and tiles.tile(1, 7, 0) is None


def test_a_damaged_pmtiles_file_is_said_or_has_no_tile(tmp_path: Path) -> None:
    with pytest.raises(TileError, match="vector"):
        open_tiles(pmtiles_file(tmp_path / "v.pmtiles", kind=1))
    data = pmtiles_file(tmp_path / "a.pmtiles").read_bytes()
    (tmp_path / "cut.pmtiles").write_bytes(data[:140])
    with pytest.raises(TileError, match="damaged"):
        open_tiles(tmp_path / "cut.pmtiles")
    (tmp_path / "short.pmtiles").write_bytes(data[:20])
    with pytest.raises(TileError, match="no PMTiles"):
        open_tiles(tmp_path / "short.pmtiles")
    for cut in range(127, len(data), 7):
        (tmp_path / "cut.pmtiles").write_bytes(data[:cut])
        with contextlib.suppress(TileError):
            open_tiles(tmp_path / "cut.pmtiles").tile(2, 0, 0)


def test_a_name_may_have_signs_that_mean_something_in_an_address(tmp_path: Path) -> None:
    """`charts #2.mbtiles` was "unable to open database file"."""
    tiles = open_tiles(tiles_file(tmp_path / "charts #2, 50%20?.mbtiles"))
    assert tiles.tile(3, 4, 6) == (b"\x89PNG tile", "image/png")
