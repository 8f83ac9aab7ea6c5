"""The lead boat: what one message says of it, and what is known of it now. `core.types` offers these names too."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from companion.core.records import quick


class Wish(IntEnum):
    """What the crew of the lead boat asks of the follower."""

    NONE = 0
    MANUAL = 1  # whoever is aboard, or its own transmitter, steers
    REMOTE = 2  # the sticks of the lead boat steer
    AUTONOMOUS = 3  # it follows


@quick
@dataclass(frozen=True, slots=True)
class LeaderState:
    """What one message says of a lead boat; None for what it does not say. `t_s`: vessel time at which it was so, `heard_s` when it came in.

    `lat_deg`, `lon_deg` None: the leader has no fix. `wish` None: no leader module speaks, but a phone, a ground station or another vehicle.
    `presses`: how often the crew has pressed for its wish since the module started, 255 followed by 1. `lost`: messages of this link that went
    missing since the one before.
    """

    t_s: float
    heard_s: float
    source: str
    system_id: int
    lat_deg: float | None
    lon_deg: float | None
    north_mps: float | None = None
    east_mps: float | None = None
    yaw_rad: float | None = None
    yaw_rate_radps: float | None = None
    accuracy_m: float | None = None  # one sigma, horizontal
    wish: Wish | None = None
    lost: int = 0
    presses: int = 0


@quick
@dataclass(frozen=True, slots=True)
class Leader:
    """Best estimate of the lead boat now, in the local plane. `yaw_rad` is its heading, or its course where it tells none; None while it has neither.

    `age_s`: since the moment of its last position; `interval_s`: as they have come lately. `counter`: 0 … 40, up with each message lost, down with
    each received.
    """

    system_id: int
    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    yaw_rad: float | None
    yaw_rate_radps: float
    accuracy_m: float
    age_s: float
    interval_s: float
    wish: Wish | None
    counter: int = 0
