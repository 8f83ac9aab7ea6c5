"""`signing.json` in the state directory: the key that signs MAVLink packets, and the time that signatures have reached.

Whoever can read the key can command the boat. So only its owner can read the file (mode 0600), and neither a log nor a
copy of the state has it. A thread writes it, since the vessel cannot wait for the medium. The next save reports a
failure.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable
from pathlib import Path

from companion.record.replacing import replace_file

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
    content = {"format": _FORMAT, "key": None if key is None else key.hex(), "horizon": horizon}
    owner = directory.stat() if os.geteuid() == 0 else None
    replace_file(
        directory,
        FILE,
        json.dumps(content, separators=(",", ":")).encode(),
        _MODE,
        None if owner is None else (owner.st_uid, owner.st_gid),
    )


class SigningFile:
    """Writes the newest of what `save` hands over, in a thread of its own."""

    def __init__(self, directory: Path, on_warning: Callable[[str], None]) -> None:
        self._directory = directory
        self._on_warning = on_warning
        self._wake = threading.Condition()
        self._waiting: Kept | None = None
        self._closed = False
        self._fault: str | None = None
        self._thread: threading.Thread | None = None

    def save(self, key: bytes | None, horizon: int) -> None:
        """Write both soon; returns at once. Reports the failure of an earlier save."""
        with self._wake:
            self._waiting = key, horizon
            fault, self._fault = self._fault, None
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="signing-file", daemon=True)
                self._thread.start()
            self._wake.notify()
        if fault is not None:
            self._on_warning(fault)

    def close(self) -> None:
        """Wait until everything is written."""
        with self._wake:
            self._closed = True
            self._wake.notify()
        if self._thread is not None:
            self._thread.join()
        if self._fault is not None:
            self._on_warning(self._fault)

    def _run(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._waiting is not None or self._closed)
                kept, self._waiting = self._waiting, None
            if kept is None:
                return
            try:
                write_signing(self._directory, *kept)
            except OSError as error:
                with self._wake:
                    self._fault = (
                        f"{self._directory / FILE} not saved: {error.strerror}; the file keeps its old content"
                    )
