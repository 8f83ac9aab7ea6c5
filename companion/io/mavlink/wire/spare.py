"""A descriptor kept for the moment when there is none left.

A client that waits to be accepted keeps the listening socket readable. Without a descriptor it can neither be accepted
nor turned away, and a loop that waits on that socket would turn without end.
"""

from __future__ import annotations

import contextlib
import os
import socket


class SpareDescriptor:
    """`turn_away(listener)` uses the spare descriptor to accept one client, and closes it at once."""

    def __init__(self) -> None:
        self._fd: int | None = None
        self._renew()

    def turn_away(self, listener: socket.socket) -> bool:
        """Turn away one client; False where there was no spare descriptor either, or no client."""
        if self._fd is None:
            self._renew()
            return False
        self.close()
        try:
            listener.accept()[0].close()
        except OSError:
            return False
        finally:
            self._renew()
        return True

    def close(self) -> None:
        """Give the descriptor back."""
        if self._fd is not None:
            os.close(self._fd)
            self._fd = None

    def _renew(self) -> None:
        with contextlib.suppress(OSError):
            self._fd = os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
