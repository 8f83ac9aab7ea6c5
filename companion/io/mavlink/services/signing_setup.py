"""SETUP_SIGNING: sets the signing key, on a trusted link only. The key is never logged, forwarded or sent back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.core.decision import TextKind
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.io.mavlink.wire.signing import KEY_BYTES, Signing
from companion.loop import Vessel


class SigningService:
    """Answers SETUP_SIGNING addressed to this system. Key and time stamp all zero remove the key."""

    def __init__(self, hub: Hub, vessel: Vessel, signing: Signing) -> None:
        self._hub = hub
        self._vessel = vessel
        self._signing = signing
        self.handles: Mapping[int, Handler] = {mavlink.MAVLINK_MSG_ID_SETUP_SIGNING: self._on_setup}

    def update(self, now_s: float) -> None:
        """Nothing to do: the service only answers messages."""

    def _on_setup(self, message: Any, peer: Peer, now_s: float) -> None:
        if message.target_system != self._hub.system:
            return
        if not peer.endpoint.guard.options.trusted:
            self._hub.say(peer, TextKind.REFUSAL, "signing key not set: link without ?trusted=yes")
            return
        key, stamp = bytes(message.secret_key), message.initial_timestamp
        if any(key):
            self._signing.set_key(key, stamp)
            self._announce(now_s, f"signing key set by system {peer.system}")
        elif stamp == 0:
            self._signing.set_key(None)
            self._announce(now_s, f"signing key removed by system {peer.system}")
        else:
            self._hub.say(peer, TextKind.REFUSAL, f"signing key not set: {KEY_BYTES} zeros are not a key")

    def _announce(self, now_s: float, text: str) -> None:
        self._vessel.events.say(now_s, TextKind.ROUTINE, "signing", text)
