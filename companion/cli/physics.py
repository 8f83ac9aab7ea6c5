"""`companion sitl --physics json:PORT`: the plant for an autopilot that is not this one."""

from __future__ import annotations

import select
import socket
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from companion.cli.common import Interrupt, UsageError

if TYPE_CHECKING:
    from sitl.json_physics import JsonPhysics

_TRUTH_S = 0.05
_LOOK_S = 0.2
_LONGEST = 2048


def parse_physics(text: str) -> tuple[str, int]:
    """Address to listen on, of `json:9002` or `json:0.0.0.0:9002`. Raises UsageError for anything else."""
    kind, _, rest = text.partition(":")
    host, colon, port = rest.rpartition(":")
    if kind != "json" or not (port.isascii() and port.isdigit() and 0 < int(port) < 65536) or (colon and not host):
        raise UsageError(f"--physics {text}: write json:PORT or json:HOST:PORT, as json:9002")
    return host or "127.0.0.1", int(port)


def serve_physics(
    physics: JsonPhysics,
    address: tuple[str, int],
    write_truth: Callable[[], None],
    lines: Callable[[], Sequence[int]],
    interrupt: Interrupt,
    duration_s: float | None,
) -> None:
    """Answer servo packets until interrupted, or for `duration_s` of the boat's time.

    `lines()` carries out what was typed, and gives the descriptors to wait for. Raises UsageError for an address that
    cannot be used.
    """
    world, truth_s = physics.world, 0.0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
        try:
            link.bind(address)
        except OSError as error:
            raise UsageError(f"--physics: {address[0]}:{address[1]} cannot be used ({error.strerror})") from error
        link.setblocking(False)
        while not (interrupt.received or (duration_s is not None and world.t_s >= duration_s)):
            ready, _, _ = select.select([link.fileno(), *lines()], [], [], _LOOK_S)
            if link.fileno() not in ready:
                continue
            try:
                data, peer = link.recvfrom(_LONGEST)
                if (reply := physics.answer(data)) is not None:
                    link.sendto(reply, peer)
            except OSError:  # the autopilot went away; another may come
                continue
            if world.t_s >= truth_s:
                truth_s = world.t_s + _TRUTH_S
                write_truth()
