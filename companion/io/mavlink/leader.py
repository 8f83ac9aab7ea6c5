"""The lead boat as other systems tell of it: FOLLOW_TARGET of a leader module, a phone or a ground station."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from companion.core.types import LeaderState
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.hub import Handler, Hub, Peer
from companion.io.mavlink.vessel import VesselFace

_HAS_POSITION, _HAS_VELOCITY = 1, 2  # est_capabilities


class LeaderService:
    """In: FOLLOW_TARGET. Out: leader states to the supervisor."""

    def __init__(self, hub: Hub, vessel: VesselFace) -> None:
        self._vessel = vessel
        self.handles: Mapping[int, Handler] = {mavlink.MAVLINK_MSG_ID_FOLLOW_TARGET: self._on_follow_target}

    def update(self, now_s: float) -> None:
        """Nothing happens by itself."""

    def _on_follow_target(self, message: Any, peer: Peer, now_s: float) -> None:
        placed = bool(message.est_capabilities & _HAS_POSITION) and (message.lat, message.lon) != (0, 0)
        moving = bool(message.est_capabilities & _HAS_VELOCITY) and all(map(math.isfinite, message.vel[:2]))
        self._vessel.supervisor.leader_heard(
            LeaderState(
                t_s=now_s,
                heard_s=now_s,
                source=f"mavlink:{peer.system}",
                system_id=peer.system,
                lat_deg=message.lat * 1e-7 if placed else None,
                lon_deg=message.lon * 1e-7 if placed else None,
                north_mps=message.vel[0] if moving else None,
                east_mps=message.vel[1] if moving else None,
            )
        )
