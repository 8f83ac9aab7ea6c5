"""What a link lets in, and the signatures that it gives: the link's options applied to each packet, with the vessel's one key."""

from __future__ import annotations

from typing import Any

from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.link_options import LinkOptions
from companion.io.mavlink.signing import Policy, Signing, Verdict

RADIO_STATUS: int = mavlink.MAVLINK_MSG_ID_RADIO_STATUS


class Guard:
    """Of one link. Remembers how many packets it refused, by what was wrong with them.

    `signing` and `number` (of the link, as signatures bear it) are given by who has the key; without them nothing is signed, and nothing genuine.
    """

    def __init__(self, options: LinkOptions | None = None) -> None:
        self.options = LinkOptions() if options is None else options
        self.signing: Signing | None = None
        self.number = 0
        self.refused: dict[Verdict, int] = {}

    def admits(self, message: Any) -> bool:
        """Judge a message; once only, since a signature counts once. RADIO_STATUS comes from the modem, which has no key."""
        policy, signing = self.options.signing, self.signing
        # judged where nothing depends on it too: what has been heard on one link must not count again on another
        verdict = signing.judge(message.get_msgbuf()) if signing is not None else Verdict.FORGED
        if policy is Policy.OFF or message.get_msgId() == RADIO_STATUS or verdict is Verdict.GENUINE:
            return True
        if policy is Policy.ACCEPT and (verdict is Verdict.UNSIGNED or signing is None or not signing.has_key):
            return True
        self.refused[verdict] = self.refused.get(verdict, 0) + 1
        return False

    def sign(self, data: bytes, crc_extra: bytes) -> bytes:
        """One of our frames as it goes out there."""
        if self.signing is None or self.options.signing is Policy.OFF:
            return data
        return self.signing.sign(data, crc_extra, self.number)

    @property
    def text(self) -> str:
        """What people should know of it; empty for nothing."""
        parts = []
        if self.options.signing is Policy.REQUIRE and (self.signing is None or not self.signing.has_key):
            parts.append("asks for signatures but there is no key: nobody is heard (companion signing set)")
        if self.refused:
            kinds = ", ".join(f"{count} {verdict.value}" for verdict, count in self.refused.items())
            parts.append(f"{sum(self.refused.values())} packets refused: {kinds}")
        return "; ".join(parts)
