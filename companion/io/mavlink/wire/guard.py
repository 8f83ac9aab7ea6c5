"""The guard of a link: admits packets and signs ours, by the link's options and the vessel's signing key."""

from __future__ import annotations

from typing import Any

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.link_options import LinkOptions
from companion.io.mavlink.wire.signing import Policy, SignatureVerdict, Signing
from companion.supervisor.authority import RequestedAction

RADIO_STATUS: int = mavlink.MAVLINK_MSG_ID_RADIO_STATUS


class Guard:
    """The guard of one link. Remembers how many packets it refused, by the reason.

    The hub sets `signing` (the key), `number` (the link id in signatures), `operators` (systems that may command;
    empty: all), `exposed` (anybody in the network can reach the link) and `proves` (answers to unknown addresses are
    limited, because the hub asks for the proof that lifts the limit), `granted` (all that the link may ask for; None:
    everything). Without `signing` no packet is signed, and no
    signature counts as genuine.
    """

    def __init__(self, options: LinkOptions | None = None) -> None:
        self.options = LinkOptions() if options is None else options
        self.signing: Signing | None = None
        self.number = 0
        self.operators: frozenset[int] = frozenset()
        self.exposed = False
        self.proves = False
        self.granted: frozenset[RequestedAction] | None = None
        self.refused: dict[SignatureVerdict, int] = {}
        self._genuine = False  # the message that was admitted last

    def admits(self, message: Any) -> bool:
        """Whether a message is admitted. Ask once for each message, because a signature is genuine only once.
        RADIO_STATUS is always admitted: it comes from the modem, which has no key."""
        policy, signing = self.options.signing, self.signing
        # verified under every policy: a packet heard on one link must not count again on another
        verdict = signing.judge(message.get_msgbuf()) if signing is not None else SignatureVerdict.FORGED
        self._genuine = verdict is SignatureVerdict.GENUINE
        if policy is Policy.OFF or message.get_msgId() == RADIO_STATUS or verdict is SignatureVerdict.GENUINE:
            return True
        if policy is Policy.ACCEPT and (verdict is SignatureVerdict.UNSIGNED or signing is None or not signing.has_key):
            return True
        self.refused[verdict] = self.refused.get(verdict, 0) + 1
        return False

    def trusts(self, message: Any) -> bool:
        """Whether the message that was admitted last speaks for its sender: signed, or from one of the operators."""
        return self._genuine or message.get_srcSystem() in self.operators

    def sign(self, data: bytes, crc_extra: bytes) -> bytes:
        """One of our frames, signed where the link's policy asks for it."""
        if self.signing is None or self.options.signing is Policy.OFF:
            return data
        return self.signing.sign(data, crc_extra, self.number)

    @property
    def text(self) -> str:
        """What to report in the link's health; empty for nothing."""
        parts = ["obeys anybody in the network"] if self.exposed else []
        if self.options.signing is Policy.REQUIRE and (self.signing is None or not self.signing.has_key):
            parts.append("requires signatures but has no key: all packets are refused (companion signing set)")
        if self.refused:
            kinds = ", ".join(f"{count} {verdict.value}" for verdict, count in self.refused.items())
            parts.append(f"{sum(self.refused.values())} packets refused: {kinds}")
        return "; ".join(parts)
