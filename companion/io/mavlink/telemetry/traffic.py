"""Messages about other vessels: AIS_VESSEL and ADSB_VEHICLE, one vessel after the other, each once a second at most;
and AIS_VESSEL from other systems."""

from __future__ import annotations

import math
import weakref
from collections.abc import Sequence
from typing import Any

from companion.core.estimate import TrackedTarget
from companion.core.readings import AisTarget
from companion.io.mavlink.telemetry.view import UINT16_UNKNOWN, View, centidegrees, degrees_e7, fitted
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.personas import Persona

_SAME_S = 1e-6  # times that differ by rounding only
_ROUND_S = 1.0  # no vessel is sent more often
_FASTEST_CMPS = 65_000
_TURN_DDEG = 127  # limit of the field, to either side
_LONGEST = {
    "bow": (511, mavlink.AIS_FLAGS_LARGE_BOW_DIMENSION),
    "stern": (511, mavlink.AIS_FLAGS_LARGE_STERN_DIMENSION),
}
_WIDEST = {
    "port": (63, mavlink.AIS_FLAGS_LARGE_PORT_DIMENSION),
    "starboard": (63, mavlink.AIS_FLAGS_LARGE_STARBOARD_DIMENSION),
}
_NO_STATUS = 15


class Rounds:
    """`next(endpoint, vessels, now_s)` → the vessel whose turn it is. Remembers, for each endpoint, the last vessel and
    when the round began."""

    def __init__(self) -> None:
        self._last: weakref.WeakKeyDictionary[Endpoint, tuple[int, float]] = weakref.WeakKeyDictionary()

    def next(self, endpoint: Endpoint, vessels: Sequence[TrackedTarget], now_s: float) -> TrackedTarget | None:
        """`vessels`: sorted by MMSI. None once all of them were sent within the last second."""
        mmsi, began_s = self._last.get(endpoint, (0, -math.inf))
        placed = [vessel for vessel in vessels if vessel.known.lat_deg is not None]
        chosen = next((vessel for vessel in placed if vessel.known.mmsi > mmsi), None)
        if chosen is None or mmsi == 0:
            if not placed or now_s - began_s < _ROUND_S - 1e-6:
                return None
            chosen, began_s = placed[0], now_s
        self._last[endpoint] = chosen.known.mmsi, began_s
        return chosen


def nearest(view: View, persona: Persona) -> Any:
    """AIS_VESSEL of the vessel nearest to the boat by its last report, for a request of one message."""
    vessel = _nearest(view)
    return None if vessel is None else ais_vessel(vessel, view.now_s)


def _nearest(view: View) -> TrackedTarget | None:
    if view.tick is None:
        return None
    nav, best = view.tick.nav, None
    for vessel in view.status.traffic:
        lat_deg, lon_deg = vessel.known.lat_deg, vessel.known.lon_deg
        if lat_deg is not None and lon_deg is not None:
            away = math.hypot(
                lat_deg - nav.lat_deg,
                math.remainder(lon_deg - nav.lon_deg, 360.0) * math.cos(math.radians(nav.lat_deg)),
            )
            best = (away, vessel) if best is None or away < best[0] else best
    return None if best is None else best[1]


def ais_vessel(vessel: TrackedTarget, now_s: float) -> Any:
    """AIS_VESSEL of a vessel whose position is known: its last report, and the age of that."""
    known, flags = vessel.known, 0
    sizes: dict[str, int] = {}
    for side, (most, large) in (_LONGEST | _WIDEST).items():
        size = getattr(known, f"{side}_m")
        sizes[side] = fitted(size, 1.0, 0, most, 0)
        if size is not None and size >= most:
            flags |= large
    told = (
        (known.course_rad is not None, mavlink.AIS_FLAGS_VALID_COG),
        (known.speed_mps is not None, mavlink.AIS_FLAGS_VALID_VELOCITY),
        (known.turn_rate_radps is not None, mavlink.AIS_FLAGS_VALID_TURN_RATE),
        (sizes["bow"] + sizes["stern"] > 0, mavlink.AIS_FLAGS_VALID_DIMENSIONS),
        (known.callsign is not None, mavlink.AIS_FLAGS_VALID_CALLSIGN),
        (known.name is not None, mavlink.AIS_FLAGS_VALID_NAME),
    )
    flags |= sum(flag for is_told, flag in told if is_told)
    turn = None if known.turn_rate_radps is None else math.degrees(known.turn_rate_radps)
    return mavlink.MAVLink_ais_vessel_message(
        known.mmsi,
        degrees_e7(known.lat_deg or 0.0),
        degrees_e7(known.lon_deg or 0.0),
        0 if known.course_rad is None else centidegrees(known.course_rad),
        centidegrees(known.heading_rad),
        fitted(known.speed_mps, 100.0, 0, _FASTEST_CMPS, 0),
        fitted(turn, 10.0, -_TURN_DDEG, _TURN_DDEG, 0),
        _NO_STATUS if known.status is None else known.status & 0xFF,
        (known.kind or 0) & 0xFF,
        *(sizes[side] for side in ("bow", "stern", "port", "starboard")),
        (known.callsign or "").encode("ascii", "replace")[:7],
        (known.name or "").encode("ascii", "replace")[:20],
        _age_s(now_s - known.t_s),
        flags,
    )


def _age_s(age_s: float) -> int:
    """Whole seconds, rounded up: a report that boats pass on to each other must not get younger by it."""
    return fitted(math.ceil(age_s - _SAME_S), 1.0, 0, UINT16_UNKNOWN, 0)


def nearest_adsb(view: View, persona: Persona) -> Any:
    """ADSB_VEHICLE of the same vessel as `nearest`."""
    vessel = _nearest(view)
    return None if vessel is None else adsb_vehicle(vessel, view.now_s)


def adsb_vehicle(vessel: TrackedTarget, now_s: float) -> Any:
    """ADSB_VEHICLE of a vessel, for ground stations that show only aircraft (QGroundControl): a surface vehicle, with
    its MMSI as ICAO address."""
    known = vessel.known
    told = (
        (True, mavlink.ADSB_FLAGS_VALID_COORDS),
        (known.course_rad is not None, mavlink.ADSB_FLAGS_VALID_HEADING),
        (known.speed_mps is not None, mavlink.ADSB_FLAGS_VALID_VELOCITY),
        (vessel.label != "", mavlink.ADSB_FLAGS_VALID_CALLSIGN),
    )
    return mavlink.MAVLink_adsb_vehicle_message(
        known.mmsi,
        degrees_e7(known.lat_deg or 0.0),
        degrees_e7(known.lon_deg or 0.0),
        mavlink.ADSB_ALTITUDE_TYPE_GEOMETRIC,
        0,
        0 if known.course_rad is None else centidegrees(known.course_rad),
        fitted(known.speed_mps, 100.0, 0, _FASTEST_CMPS, 0),
        0,
        (known.name or str(known.mmsi)).encode("ascii", "replace")[:8],
        mavlink.ADSB_EMITTER_TYPE_SERVICE_SURFACE,
        fitted(now_s - known.t_s, 1.0, 0, 255, 0),
        sum(flag for is_told, flag in told if is_told),
        0,
    )


def from_ais_vessel(message: Any, system: int, now_s: float) -> AisTarget:
    """The report in another system's AIS_VESSEL, with the age that the message gives."""
    flags = message.flags
    sized = bool(flags & mavlink.AIS_FLAGS_VALID_DIMENSIONS)
    sizes = (message.dimension_bow, message.dimension_stern, message.dimension_port, message.dimension_starboard)
    bow, stern, port, starboard = (float(size) if sized else None for size in sizes)
    turning = flags & mavlink.AIS_FLAGS_VALID_TURN_RATE and not flags & mavlink.AIS_FLAGS_TURN_RATE_SIGN_ONLY
    return AisTarget(
        t_s=now_s - message.tslc,
        source=f"mavlink:{system}",
        mmsi=message.MMSI,
        lat_deg=message.lat * 1e-7,
        lon_deg=message.lon * 1e-7,
        course_rad=math.radians(message.COG * 0.01)
        if flags & mavlink.AIS_FLAGS_VALID_COG and message.COG < 36000
        else None,
        speed_mps=message.velocity * 0.01 if flags & mavlink.AIS_FLAGS_VALID_VELOCITY else None,
        heading_rad=math.radians(message.heading * 0.01) if message.heading < 36000 else None,
        turn_rate_radps=math.radians(message.turn_rate * 0.1) if turning else None,
        status=message.navigational_status if message.navigational_status < _NO_STATUS else None,
        kind=message.type or None,
        bow_m=bow,
        stern_m=stern,
        port_m=port,
        starboard_m=starboard,
        callsign=_text(message.callsign) if flags & mavlink.AIS_FLAGS_VALID_CALLSIGN else None,
        name=_text(message.name) if flags & mavlink.AIS_FLAGS_VALID_NAME else None,
    )


def _text(text: str) -> str | None:
    return "".join(c for c in text if c.isprintable()).strip() or None
