"""`signing.json` in the state directory: the key that signs MAVLink packets, and the time that signatures have reached.

Whoever can read the key can command the boat. So only its owner can read the file (mode 0600), and neither a log nor a
copy of the state has it.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

from companion.record.replacing import replace_file
from companion.record.writer import Access

FILE = "signing.json"
KEY_BYTES = 32
_FORMAT = 1
_MODE = 0o600
_OTHERS = 0o077
_LAST = 2**48 - 1

Kept = tuple[bytes | None, int]  # key, horizon: packets stamped at or before it are refused (10 µs since 2015)


class SigningFileError(Exception):
    """A file that is not used: one line that says why and what to do."""


def read_signing(directory: Path) -> Kept:
    """(key, horizon); (None, 0) where there is no file. Raises SigningFileError for a file that others can read, or
    that is invalid."""
    path = directory / FILE
    try:
        with path.open("rb") as file:
            mode = os.fstat(file.fileno()).st_mode
            if mode & _OTHERS:
                raise SigningFileError(
                    f"{path}: others can read this key, so it is not used; chmod 600 {path}, "
                    "or better set another one (companion signing set)"
                )
            content = json.loads(file.read())
    except FileNotFoundError:
        return None, 0
    except OSError as error:
        raise SigningFileError(
            f"{path}: {error.strerror}; no packet is signed, and no signed packet is accepted"
        ) from error
    except ValueError as error:
        raise SigningFileError(f"{path}: corrupt; set the key again (companion signing set)") from error
    try:
        if content["format"] != _FORMAT:
            raise ValueError
        key, horizon = None if content["key"] is None else bytes.fromhex(content["key"]), content["horizon"]
        if (key is not None and len(key) != KEY_BYTES) or type(horizon) is not int or not 0 <= horizon <= _LAST:
            raise ValueError
    except (KeyError, TypeError, ValueError) as error:
        raise SigningFileError(f"{path}: unknown format; set the key again (companion signing set)") from error
    return key, horizon


def write_signing(directory: Path, key: bytes | None, horizon: int) -> None:
    """Write both, synced to the medium, with the owner of the directory. Raises OSError."""
    may = access(directory)
    replace_file(directory, FILE, encoded(key, horizon), may.mode, may.owner)


def encoded(key: bytes | None, horizon: int) -> bytes:
    """The content of the file."""
    content = {"format": _FORMAT, "key": None if key is None else key.hex(), "horizon": horizon}
    return json.dumps(content, separators=(",", ":")).encode()


def access(directory: Path) -> Access:
    """Who may read the file: its owner, who is that of the directory. Where that is not there, the process."""
    try:
        owner = directory.stat() if os.geteuid() == 0 else None
    except OSError:
        owner = None
    return Access(_MODE, None if owner is None else (owner.st_uid, owner.st_gid))
