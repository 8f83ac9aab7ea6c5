"""Whether the far end of a datagram link receives what we send it, and how much it is sent until that is known.

Anybody can write any sender on a datagram. A boat that answered a heartbeat of 20 bytes with telemetry and parameters
would flood whoever is named there. So an address that has proved nothing gets at most ANSWER_FACTOR times the bytes
that came from it. With the first of them it gets a PING and a TIMESYNC with a random number. Who sends that number back
has received it: from then on there is no limit. QGroundControl, MAVSDK, Mission Planner and MAVROS do so by
themselves. A genuine signature and an operator's system id count as well.

An address of this computer needs no proof: the kernel takes none of them from outside. Source of the rule: RFC 9000
(QUIC), section 8.
"""

from __future__ import annotations

import ipaddress
import secrets
from collections.abc import Sequence
from typing import Any

from companion.io.mavlink.wire import messages as mavlink

ANSWER_FACTOR = 5.0
_AGAIN_S = 1.0
_SCARCE_BYTES = 300.0  # kept for answers to what is asked next; telemetry and lists wait


class Proof:
    """What one address has sent and got, until it is proven."""

    def __init__(self) -> None:
        self.proven = False
        self._numbers = secrets.randbits(32), secrets.randbits(62) | 1, secrets.randbits(62) | 1
        self._left = 0.0
        self._asked_s: float | None = None

    @property
    def scarce(self) -> bool:
        """Whether little more may be sent there."""
        return not self.proven and self._left < _SCARCE_BYTES

    def received(self, size: int) -> None:
        """So many bytes came from the address."""
        self._left += ANSWER_FACTOR * size

    def take(self, message: Any) -> None:
        """See whether a message sends one of our numbers back."""
        sequence, time_us, time_ns = self._numbers
        number = message.get_msgId()
        if number == mavlink.MAVLINK_MSG_ID_PING:
            self.proven = self.proven or (message.time_usec, message.seq) == (time_us, sequence)
        elif number == mavlink.MAVLINK_MSG_ID_TIMESYNC:
            self.proven = self.proven or (message.ts1 == time_ns and message.tc1 != 0)

    def allows(self, size: int) -> bool:
        """Whether so many bytes more may be sent there; they count as sent."""
        if self.proven:
            return True
        if size > self._left:
            return False
        self._left -= size
        return True

    def questions(self, now_s: float) -> Sequence[Any]:
        """The messages to send first, and once a second while the proof is missing."""
        if self.proven or (self._asked_s is not None and now_s - self._asked_s < _AGAIN_S):
            return ()
        self._asked_s = now_s
        sequence, time_us, time_ns = self._numbers
        return (
            mavlink.MAVLink_ping_message(time_us, sequence, 0, 0),
            mavlink.MAVLink_timesync_message(0, time_ns),
        )


def needs_proof(host: str) -> bool:
    """Whether a datagram with this sender could come from somebody else."""
    try:
        return not ipaddress.ip_address(host).is_loopback
    except ValueError:
        return True
