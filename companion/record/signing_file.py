"""`signing.json` in the state directory: the key of MAVLink signatures and the time that they have come to.

Whoever can read it can command the boat, so it is its owner's alone (mode 0600), in no log and no copy of the state. It is written by a thread: the
medium may take its time, the vessel has none. What goes wrong there is told at the next save.
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

Kept = tuple[bytes | None, int]  # key, horizon: no packet stamped at or before it counts (10 µs since 2015)


class SigningFileError(Exception):
    """A file that is not used; one line with the remedy."""


def read_signing(directory: Path) -> Kept:
    """What is kept; (None, 0) where there is nothing. Raises SigningFileError for a file that others can read, or that is none of ours."""
    path = directory / FILE
    try:
        with path.open("rb") as file:
            mode = os.fstat(file.fileno()).st_mode
            if mode & _OTHERS:
                raise SigningFileError(f"{path}: others can read this key, it is not used; chmod 600 {path}, or better set another one (companion signing set)")
            content = json.loads(file.read())
    except FileNotFoundError:
        return None, 0
    except OSError as error:
        raise SigningFileError(f"{path}: {error.strerror}; nothing is signed, and nothing signed is taken") from error
    except ValueError as error:
        raise SigningFileError(f"{path}: corrupt; set the key again (companion signing set)") from error
    try:
        if content["format"] != _FORMAT:
            raise ValueError
        key, horizon = None if content["key"] is None else bytes.fromhex(content["key"]), content["horizon"]
        if (key is not None and len(key) != KEY_BYTES) or type(horizon) is not int or not 0 <= horizon <= _LAST:
            raise ValueError
    except (KeyError, TypeError, ValueError) as error:
        raise SigningFileError(f"{path}: not in a format that this version knows; set the key again (companion signing set)") from error
    return key, horizon


def write_signing(directory: Path, key: bytes | None, horizon: int) -> None:
    """Keep both, on the medium when this returns, in the name of the directory's owner. Raises OSError."""
    content = {"format": _FORMAT, "key": None if key is None else key.hex(), "horizon": horizon}
    owner = directory.stat() if os.geteuid() == 0 else None
    replace_file(directory, FILE, json.dumps(content, separators=(",", ":")).encode(), _MODE, None if owner is None else (owner.st_uid, owner.st_gid))


class SigningFile:
    """`save` hands over what is to be kept, the newest last; `close` waits until it is."""

    def __init__(self, directory: Path, on_warning: Callable[[str], None]) -> None:
        self._directory = directory
        self._on_warning = on_warning
        self._wake = threading.Condition()
        self._waiting: Kept | None = None
        self._closed = False
        self._fault: str | None = None
        self._thread: threading.Thread | None = None

    def save(self, key: bytes | None, horizon: int) -> None:
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
                    self._fault = f"{self._directory / FILE} not saved: {error.strerror}; it keeps what it had"
