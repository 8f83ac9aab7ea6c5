"""Logs, and the read-only files that the boat shows over MAVLink FTP."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mavsdk.plugins.ftp import Ftp, FtpError, FtpResult
from mavsdk.plugins.log_files import LogFiles, LogFilesError, LogFilesResult

from gcs_plugins.usvctl.boat import Boat, Mistake, NoVessel, Refused
from gcs_plugins.usvctl.progress import transferred

_ULOG = b"ULog"


def logs(boat: Boat) -> Sequence[Any]:
    """Entries with `id`, `date` and `size_bytes`, the oldest run first; none when there are no logs."""
    return _entries(LogFiles(boat.system))


def _entries(plugin: LogFiles) -> Sequence[Any]:
    try:
        return plugin.get_entries()  # type: ignore[no-any-return]
    except LogFilesError as error:
        if error.result == LogFilesResult.NO_LOGFILES:
            return ()
        raise NoVessel("the boat did not list its logs") from error


def get_log(boat: Boat, number: int | None, folder: Path) -> Path:
    """Fetch one log, None for the newest; its suffix tells what it is. Raises Mistake for a number that there is
    not."""
    plugin = LogFiles(boat.system)  # it knows only logs that it has listed itself
    entries = {entry.id: entry for entry in _entries(plugin)}
    if not entries or (number is not None and number not in entries):
        raise Mistake(f"no log {'here' if number is None else number}; `usvctl logs list` shows what there is")
    entry = entries[max(entries) if number is None else number]
    part = _made(folder) / f"log_{entry.id}.part"
    part.unlink(missing_ok=True)  # MAVSDK overwrites no file
    result = transferred(
        f"log {entry.id}",
        lambda report: plugin.download_log_file_async(entry, str(part), report),
        lambda data: float(data.progress),
        lambda result: result == LogFilesResult.NEXT,
    )
    if result != LogFilesResult.SUCCESS:
        raise NoVessel(f"log {entry.id} did not come: {result.name.lower().replace('_', ' ')}")
    with part.open("rb") as file:
        suffix = ".ulg" if file.read(len(_ULOG)) == _ULOG else ".tlog"
    return part.replace(part.parent / f"log_{entry.id}_{entry.date.replace(':', '')}{suffix}")


def listing(boat: Boat, path: str) -> list[str]:
    """Names in a folder of the boat, folders with a slash."""
    try:
        entries = Ftp(boat.system).list_directory(path).entries
    except FtpError as error:
        raise _said(path, error.result) from error
    return [f"{e.name}/" if e.entry_type == e.EntryType.DIRECTORY else e.name for e in entries]


def get_file(boat: Boat, path: str, folder: Path) -> Path:
    """Fetch one file by its path on the boat."""
    plugin, folder = Ftp(boat.system), _made(folder)
    result = transferred(
        path,
        lambda report: plugin.download_async(path, str(folder), True, report),
        lambda data: data.bytes_transferred / max(1, data.total_bytes),
        lambda result: result == FtpResult.NEXT,
    )
    if result != FtpResult.SUCCESS:
        raise _said(path, result)
    return folder / Path(path).name


def _made(folder: Path) -> Path:
    """The folder, made where it is missing, as the absolute path that MAVSDK needs."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder.resolve()


def _said(path: str, result: FtpResult) -> Exception:
    if result in (FtpResult.TIMEOUT, FtpResult.NO_SYSTEM):
        return NoVessel(f"{path}: no answer")
    return Refused(f"{path}: {result.name.lower().replace('_', ' ')}")
