"""The process of one script: reduces its own rights, loads the file, calls its `main(boat)`.

`python -m companion.scripting.runner SETTINGS`, where SETTINGS is the JSON of a `Settings`. Only its keeper starts it.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import runpy
import socket
import sys
import traceback
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from companion.scripting.boat import Boat
from companion.scripting.client import ScriptError
from companion.scripting.door import Door, SocketDoor
from companion.scripting.limits import reduce_rights, write_only_below

_LONGEST = 150


@dataclass(frozen=True, slots=True)
class Settings:
    """What the keeper tells the process. `link`: descriptor of its end of the boat's link, or -1 with `address` of a
    TCP link. `status`: descriptor of the keeper's pipe. `folder`: where it may write."""

    file: str
    arguments: tuple[str, ...]
    system: int
    feed: str
    folder: str
    keeper: int
    status: int
    link: int = -1
    address: tuple[str, int] | None = None
    memory_mb: int = 512
    disk_mb: int = 64

    def text(self) -> str:
        """As JSON."""
        return json.dumps(asdict(self))


def settings_of(text: str) -> Settings:
    """The settings of a JSON text."""
    data = json.loads(text)
    data["arguments"] = tuple(data["arguments"])
    data["address"] = None if data["address"] is None else tuple(data["address"])
    return Settings(**data)


def run_file(file: str, door: Door, boat: Boat) -> int:
    """Load the file and call its `main(boat)`. Returns the exit code; what went wrong is told to the keeper."""
    try:
        found = runpy.run_path(file, run_name="script")
        main = found.get("main")
        if not callable(main):
            raise ScriptError("the file has no main(boat)")
        boat.connect()
        main(boat)
    except (SystemExit, KeyboardInterrupt) as ending:
        code = ending.code if isinstance(ending, SystemExit) else 0
        return code if isinstance(code, int) else 0 if code is None else _failed(door, str(code))
    except BaseException as error:  # noqa: BLE001  whatever a script raises is its own failure
        traceback.print_exc()
        return _failed(door, _words_of(error))
    return 0


def _failed(door: Door, text: str) -> int:
    door.tell("failed", text)
    return 1


def _words_of(error: BaseException) -> str:
    """One line: what was raised, and the last line of the script's own that led there."""
    if isinstance(error, MemoryError):
        return "out of memory (memory_mb)"
    said = str(error).split("\n")[0]
    text = said if isinstance(error, ScriptError) else f"{type(error).__name__}: {said}"
    own = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith("<frozen")]
    last = [frame for frame in own if f"{os.sep}companion{os.sep}scripting{os.sep}" not in frame.filename]
    where = f"line {last[-1].lineno}: " if last else ""
    return f"{where}{text}"[:_LONGEST]


class _Output(io.RawIOBase):
    """Where the script prints. What the log cannot take, because it is full, goes nowhere: no script fails by it."""

    def __init__(self, descriptor: int) -> None:
        super().__init__()
        self._descriptor = descriptor

    def writable(self) -> bool:
        """Always."""
        return True

    def fileno(self) -> int:
        """See `io.IOBase`."""
        return self._descriptor

    def write(self, data: Any) -> int:
        """Write as much of it as goes; all of it counts as written."""
        rest = memoryview(data).cast("B")
        length = len(rest)
        with contextlib.suppress(OSError):
            while rest:
                rest = rest[os.write(self._descriptor, rest) :]
        return length


def _printing_to(descriptor: int) -> io.TextIOWrapper:
    return io.TextIOWrapper(_Output(descriptor), "utf-8", "replace", line_buffering=True, write_through=True)  # type: ignore[arg-type]


def main(argv: Sequence[str]) -> int:
    """Run the script of the settings in `argv`."""
    settings = settings_of(argv[0])
    sys.stdout, sys.stderr = _printing_to(1), _printing_to(2)
    reduce_rights(settings.memory_mb, settings.disk_mb, settings.keeper)
    os.chdir(settings.folder)
    if not write_only_below(Path(settings.folder)):
        sys.stderr.write("this kernel has no Landlock: the script may write wherever this user may\n")
    link = _connected(settings)
    door = SocketDoor(link, Path(settings.feed), settings.status)
    return run_file(settings.file, door, Boat(door, settings.system, settings.arguments))


def _connected(settings: Settings) -> socket.socket:
    if settings.address is not None:
        return socket.create_connection(settings.address, timeout=10.0)
    return socket.socket(fileno=settings.link)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
