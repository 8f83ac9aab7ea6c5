"""A network of its own for processes of a test, so that programs with fixed port numbers disturb nobody."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType

from tests.waiting import ended

# Brings the loopback interface up (SIOCSIFFLAGS: IFF_UP and IFF_RUNNING), then keeps the network until stdin closes.
_KEEP = """
import fcntl, socket, struct, sys
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
    fcntl.ioctl(any_socket, 0x8914, struct.pack("16sh14x", b"lo", 0x41))
print("ready", flush=True)
sys.stdin.read()
"""


class NoIsland(Exception):
    """This machine gives a test no network of its own. The text says why."""


class Island:
    """A Linux network namespace with nothing but its own 127.0.0.1. `within` is put before a command to run it there.

    Raises NoIsland where the kernel, a container or a missing `unshare` forbids it.
    """

    def __init__(self) -> None:
        command = ["unshare", "--map-root-user", "--net", "--", sys.executable, "-c", _KEEP]
        try:
            self._keeper = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
        except OSError as error:
            raise NoIsland(f"no `unshare`: {error}") from error
        assert self._keeper.stdout is not None
        if not self._keeper.stdout.readline():
            raise NoIsland(f"no network namespace: {ended(self._keeper, 'unshare')[1].strip()}")
        target = f"--target={self._keeper.pid}"
        self.within = ("nsenter", target, "--user", "--preserve-credentials", "--net", "--")

    def __enter__(self) -> Island:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        ended(self._keeper, "the network namespace")  # which closes its stdin first


@contextmanager
def island_if_any() -> Iterator[tuple[str, ...]]:
    """What to put before a command so that it has a network of its own; nothing where this machine gives none."""
    try:
        island = Island()
    except NoIsland:
        yield ()
        return
    with island:
        yield island.within
