"""Installs the action files where QGroundControl looks for them, and removes them again.

A file of the same name is kept as `NAME.before-usv` (`.before-usv-2`, …) and comes back on removal. A list of the files
written, with hashes, tells ours from files that were changed since.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from gcs_plugins.qgroundcontrol.action_files import files

SAVE_FOLDERS = ("QGroundControl", "QGroundControl Daily")
_RECORD = "usv_actions.installed"
_BACKUP = ".before-usv"


class InstallationError(Exception):
    """The installation cannot be done; the text gives the remedy."""


def save_folders(documents: Path) -> list[Path]:
    """QGroundControl's save folders there: of the release, of the daily build. Raises InstallationError when there is
    none."""
    found = [documents / name for name in SAVE_FOLDERS if (documents / name).is_dir()]
    if not found:
        raise InstallationError(
            f"no QGroundControl folder in {documents}: start QGroundControl once, "
            "or give its load/save path (Application Settings, General) with --dir"
        )
    return found


def install(folder: Path) -> list[str]:
    """Write all files into a save folder. Returns what was done, a line each. May raise OSError."""
    if not folder.is_dir():
        raise InstallationError(f"{folder} is no folder; give QGroundControl's load/save path")
    said, record = [], _read_record(folder)
    for name, content in files().items():
        path, data = folder / name, content.encode()
        path.parent.mkdir(exist_ok=True)
        if path.exists() and _hash(path.read_bytes()) not in (record.get(name), _hash(data)):
            kept = _free(path)
            path.rename(kept)
            said.append(f"kept {kept}")
        path.write_bytes(data)
        record[name] = _hash(data)
        said.append(f"wrote {path}")
    (folder / _RECORD).write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    return said


def uninstall(folder: Path) -> list[str]:
    """Remove the files of `install` that were not changed since; the files that it had kept come back. Returns what was
    done, a line each."""
    said, record = [], _read_record(folder)
    if not record:
        raise InstallationError(f"no action files of ours are installed in {folder}")
    for name, written in record.items():
        path = folder / name
        if path.exists() and _hash(path.read_bytes()) != written:
            said.append(f"left {path}: changed since it was installed")
            continue
        path.unlink(missing_ok=True)
        said.append(f"removed {path}")
        backups = _backups(path)
        if backups:
            backups[-1].rename(path)
            said.append(f"brought back {path}")
    (folder / _RECORD).unlink()
    return said


def _read_record(folder: Path) -> dict[str, str]:
    try:
        read = json.loads((folder / _RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    known: Mapping[str, str] = files()
    return {name: str(read[name]) for name in known if name in read} if isinstance(read, dict) else {}


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _backups(path: Path) -> list[Path]:
    """Of a file, the oldest first."""
    kept, number = [], 1
    while (candidate := _backup(path, number)).exists():
        kept.append(candidate)
        number += 1
    return kept


def _free(path: Path) -> Path:
    return _backup(path, len(_backups(path)) + 1)


def _backup(path: Path, number: int) -> Path:
    return path.with_name(f"{path.name}{_BACKUP}{'' if number == 1 else f'-{number}'}")
