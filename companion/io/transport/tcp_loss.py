"""TCP connections whose far end goes without a word: a device that loses its power, a network that is cut.

A reader would wait for ever: nothing tells it that the far end has restarted. So the operating system asks a
silent far end whether it is still there, where it can, and ends the connection after some 15 s without an answer.
"""

from __future__ import annotations

import contextlib
import socket

LOST_AFTER_S = 15.0
_OPTIONS = (
    ("SOL_SOCKET", "SO_KEEPALIVE", 1),
    ("IPPROTO_TCP", "TCP_KEEPIDLE", 5),
    ("IPPROTO_TCP", "TCP_KEEPINTVL", 5),
    ("IPPROTO_TCP", "TCP_KEEPCNT", 2),
    ("IPPROTO_TCP", "TCP_USER_TIMEOUT", round(LOST_AFTER_S * 1000)),
)


def notice_loss(connection: socket.socket) -> None:
    """Let the operating system end the connection when its far end is gone. A socket that is closed already is left
    alone."""
    for level, option, value in _OPTIONS:
        if hasattr(socket, option):
            with contextlib.suppress(OSError):
                connection.setsockopt(getattr(socket, level), getattr(socket, option), value)
