"""SETUP_SIGNING: the key of signatures, taken on a trusted link and nowhere else. It is never logged, never forwarded, never answered with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.core.types import Severity
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.hub import Handler, Hub, Peer
from companion.io.mavlink.signing import KEY_BYTES, Signing
from companion.io.mavlink.vessel import VesselFace


class SigningService:
    """In: SETUP_SIGNING for this system by name. All zero, the time too, means no key any more."""

    def __init__(self, hub: Hub, vessel: VesselFace, signing: Signing) -> None:
        self._hub = hub
        self._vessel = vessel
        self._signing = signing
        self.handles: Mapping[int, Handler] = {mavlink.MAVLINK_MSG_ID_SETUP_SIGNING: self._on_setup}

    def update(self, now_s: float) -> None:
        """Nothing happens by itself."""

    def _on_setup(self, message: Any, peer: Peer, now_s: float) -> None:
        if message.target_system != self._hub.system:
            return
        if not peer.endpoint.guard.options.trusted:
            self._hub.say(peer, Severity.WARNING, "signing key not set: link without ?trusted=yes")
            return
        key, stamp = bytes(message.secret_key), message.initial_timestamp
        if any(key):
            self._signing.set_key(key, stamp)
            self._tell(now_s, f"signing key set by system {peer.system}")
        elif stamp == 0:
            self._signing.set_key(None)
            self._tell(now_s, f"signing ended by system {peer.system}: there is no key")
        else:
            self._hub.say(peer, Severity.WARNING, f"signing key not set: {KEY_BYTES} zeros are no key")

    def _tell(self, now_s: float, text: str) -> None:
        self._vessel.events.say(now_s, Severity.NOTICE, "signing", text)
