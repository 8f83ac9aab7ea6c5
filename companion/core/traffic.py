"""Other vessels: what one report says of one of them, and what is known of it from all its reports. `core.types` offers these names too."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.records import quick


@quick
@dataclass(frozen=True, slots=True)
class AisTarget:
    """What one message says of another vessel; None for what it does not say. `t_s`: when it was there, as far as the receiver tells.

    A report of motion has a position; one of the ship alone (its size and names) has none. Distances are from the position's place on board to
    bow, stern and sides. `status`, `kind`: navigational status and type of ship by AIS's numbers (ITU-R M.1371).
    """

    t_s: float
    source: str
    mmsi: int
    lat_deg: float | None = None
    lon_deg: float | None = None
    course_rad: float | None = None  # over ground
    speed_mps: float | None = None  # over ground
    heading_rad: float | None = None
    turn_rate_radps: float | None = None
    status: int | None = None
    kind: int | None = None
    bow_m: float | None = None
    stern_m: float | None = None
    port_m: float | None = None
    starboard_m: float | None = None
    callsign: str | None = None
    name: str | None = None


@quick
@dataclass(frozen=True, slots=True)
class TrackedTarget:
    """All that is known of one vessel. `known.t_s` is that of its position, `heard_s` when it last said anything."""

    known: AisTarget
    heard_s: float
    reports: int  # of its position

    @property
    def label(self) -> str:
        """For people: its name, else its number."""
        return self.known.name or f"MMSI {self.known.mmsi}"


@quick
@dataclass(frozen=True, slots=True)
class Contact:
    """A vessel as it is now, dead-reckoned along its course: the middle of its hull in the local plane, its velocity over ground, and the
    radius around its middle that holds all of the hull."""

    mmsi: int
    label: str
    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    radius_m: float
    status: int | None

    @property
    def speed_mps(self) -> float:
        return math.hypot(self.north_mps, self.east_mps)
