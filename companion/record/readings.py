"""The recorded readings of a log folder, in whichever file its version wrote them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from companion.core.readings import Reading
from companion.core.tick import DeviceHealth
from companion.record import mcap_log, mcap_reader, readings_csv
from companion.record.recorded import RecordedTick

FILE = mcap_log.FILE


def path_in(folder: Path) -> Path:
    """The file of a log folder: log.mcap, or readings.csv of an older log. It need not exist."""
    older = folder / readings_csv.FILE
    return older if older.exists() and not (folder / FILE).exists() else folder / FILE


def read_ticks(path: Path, warnings: list[str]) -> Iterator[RecordedTick]:
    """The ticks of a log.mcap or readings.csv. What is damaged is left out, and so are readings that no tick follows,
    each with a warning. Raises OSError for a file that cannot be read."""
    if path.suffix == ".csv":
        yield from readings_csv.read_ticks(path, warnings)
    else:
        yield from mcap_reader.read_ticks(path, warnings)


def read_kind(path: Path, kind: str, warnings: list[str]) -> list[Reading]:
    """The readings of one kind (a key of KINDS). What is damaged is left out with a warning. Raises OSError for a file
    that cannot be read."""
    if path.suffix == ".csv":
        return readings_csv.read_kind(path, kind, warnings)
    return mcap_reader.read_kind(path, kind, warnings)


def read_health(path: Path, warnings: list[str]) -> list[tuple[int, DeviceHealth]]:
    """(Unix time in ns, health) of each report of a device; an older log has none. Raises OSError for a file that
    cannot be read."""
    return [] if path.suffix == ".csv" else mcap_reader.read_health(path, warnings)
