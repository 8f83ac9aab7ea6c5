"""A process that has loaded the companion's modules and begins others as copies of itself; `tests/copies.py` asks it.

It has one thread and opens nothing, so that a copy is a process as new as one of `python -m companion`. A keeper stands
between the two, for the one that asks is not the parent of the copy and cannot wait for it: it tells by a pipe which
process began, and how it ended.

Usage: python -m tests.fork_server DESCRIPTOR, one end of a pair of sockets that keep the borders of messages.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import io
import json
import os
import signal
import socket
import sys
from contextlib import suppress
from typing import Any, NoReturn

import companion.__main__

LARGEST_REQUEST = 1 << 17  # bytes; a command with its environment
_COMMANDS = ("check", "console", "leader", "mission", "run", "scenario", "script", "sitl")
_USED_LATER = (
    *("companion.analysis.replay", "sitl.emulators", "sitl.scenarios", "sitl.world", "shapely"),
    *("scipy.optimize", "scipy.sparse.csgraph"),
)


def main(channel: socket.socket) -> None:
    """Begin a copy for each request, until the asker ends. Returns in the copies only."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a person's Ctrl-C is for the asker and the copies
    while True:
        request, descriptors, _, _ = socket.recv_fds(channel, LARGEST_REQUEST, 4)
        _forget_keepers()
        if not request:
            os._exit(0)
        if os.fork() == 0:
            channel.close()
            *streams, told = descriptors
            if _keep(streams, told):
                _become(streams, **json.loads(request))
                return
        for descriptor in descriptors:
            os.close(descriptor)


def _forget_keepers() -> None:
    """Those that have ended; what they and their copies used of the processor counts as this process's then."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _keep(streams: list[int], told: int) -> bool:
    """True in the copy. The keeper waits for its end."""
    if (copy := os.fork()) == 0:
        os.close(told)
        return True
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    for stream in streams:
        os.close(stream)
    with suppress(BrokenPipeError):  # the asker has ended
        os.write(told, b"%d\n" % copy)
        _, status = os.waitpid(copy, 0)
        os.write(told, b"%d\n" % os.waitstatus_to_exitcode(status))
    os._exit(0)


def _become(streams: list[int], arguments: list[str], environment: dict[str, str], folder: str) -> None:
    """What a new process of these arguments would be."""
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv = [companion.__main__.__file__, *arguments]
    if environment.get("PYTHONUNBUFFERED"):
        sys.stdout = _unbuffered(1, "strict")
        sys.stderr = _unbuffered(2, "backslashreplace")


def _unbuffered(descriptor: int, errors: str) -> io.TextIOWrapper:
    raw: Any = os.fdopen(descriptor, "wb", buffering=0, closefd=False)
    return io.TextIOWrapper(raw, encoding="utf-8", errors=errors, write_through=True)


def _leave(codes: list[int]) -> None:
    """At the very end of a copy's program: leave its modules as they are. Python would take them apart one by one, which
    takes more processor time than the start."""
    if not codes:
        return
    with suppress(OSError, ValueError):  # Python says so, and tells it by its code
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(codes[0])


def _run(descriptor: int) -> NoReturn:
    codes: list[int] = []
    atexit.register(_leave, codes)  # before all others, so that it is called after them
    gc.disable()
    _load()
    gc.freeze()
    gc.enable()
    main(socket.socket(fileno=descriptor))
    codes.append(companion.__main__.main())
    sys.exit(codes[0])


def _load() -> None:
    """What every command would load and work out at its start."""
    from companion.config.vessel import bundled, find, load

    for name in (*(f"companion.cli.{command}" for command in _COMMANDS), *_USED_LATER):
        importlib.import_module(name)
    for vessel in bundled():  # two thirds of a start: how files are read, and what follows from their dimensions
        load(find(vessel))


if __name__ == "__main__":
    _run(int(sys.argv[1]))
