"""Distress beacons among the AIS targets: search and rescue transmitters, persons overboard, EPIRBs.

Source: ITU-R M.1371-5 (status 14: active; 15, as none: under test) and M.585-9 (MMSI 970, 972, 974).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.decision import TextKind
from companion.core.estimate import NavState, TrackedTarget
from companion.core.events import Announce
from companion.core.geodesy import distance_and_bearing
from companion.core.readings import AisTarget

_ACTIVE = 14
_BEACONS = {970: "SART", 972: "MOB", 974: "EPIRB"}  # by the first digits of the MMSI
_KM_M = 10_000.0
_UPDATE_S = 1.0


class DistressWatch:
    """`update(targets, nav, now_s)` announces each beacon once, with bearing and distance; again once its place is
    known, where it was not, and once it is active, where it was under test.

    Remembers of each beacon that is heard whether it was announced as active, and with its place.
    """

    def __init__(self, say: Announce) -> None:
        self._say = say
        self._told: dict[int, tuple[bool, bool]] = {}
        self._updated_s = -math.inf

    def update(self, targets: Sequence[TrackedTarget], nav: NavState, now_s: float) -> None:
        """Call it once a tick; it looks once a second."""
        if now_s - self._updated_s < _UPDATE_S:
            return
        self._updated_s = now_s
        told: dict[int, tuple[bool, bool]] = {}
        for known in [target.known for target in targets if _is_beacon(target.known)]:
            active = known.status == _ACTIVE
            place = _place(known, nav)
            was_active, was_placed = before = self._told.get(known.mmsi, (False, False))
            told[known.mmsi] = active or was_active, place is not None or was_placed
            if known.mmsi in self._told and told[known.mmsi] == before:
                continue
            head = "Distress:" if active else "Test of"
            text = f"{head} {_BEACONS.get(known.mmsi // 1_000_000, 'MMSI')} {known.mmsi}, {place or 'place not known'}"
            self._say(now_s, TextKind.DANGER if active else TextKind.ROUTINE, "traffic_distress", text)
        self._told = told


def _is_beacon(known: AisTarget) -> bool:
    return known.status == _ACTIVE or known.mmsi // 1_000_000 in _BEACONS


def _place(known: AisTarget, nav: NavState) -> str | None:
    """Distance and bearing from the boat; None where either place is not known."""
    if known.lat_deg is None or known.lon_deg is None or not nav.position_valid:
        return None
    away_m, bearing_rad = distance_and_bearing(nav.lat_deg, nav.lon_deg, known.lat_deg, known.lon_deg)
    away = f"{away_m:.0f} m" if away_m < _KM_M else f"{away_m / 1000.0:.1f} km"
    return f"{away} at {math.degrees(bearing_rad) % 360.0:03.0f} deg"
