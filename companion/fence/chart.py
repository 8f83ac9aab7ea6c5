"""The plans of a boat as displays draw them: places and zones in the local plane, as plain values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from companion.core.geodesy import LocalFrame
from companion.fence.zones import fence_zones
from companion.mission.plan import PlanItem, PlanKind

Place = tuple[float, float]
_MISSION_FRAME = 2  # MAV_FRAME_MISSION: no place
_MOST = 400  # places of a plan that are drawn


def chart_of(
    plans: Mapping[PlanKind, Sequence[PlanItem]], frame: LocalFrame, obstacles: Sequence[Sequence[Place]] = ()
) -> dict[str, Any]:
    """`mission` and `rally`: places with their numbers for people; `fence`: zones, of a circle the centre with
    `radius_m`, and the outlines of a chart's `obstacles` as exclusion zones."""
    return {
        "mission": _places(plans.get(PlanKind.MISSION, ()), frame),
        "rally": _places(plans.get(PlanKind.RALLY, ()), frame),
        "fence": [
            {
                "inclusion": zone.inclusion,
                "points": [list(frame.to_ned(*point)) for point in zone.points],
                "radius_m": zone.radius_m,
            }
            for zone in fence_zones(plans.get(PlanKind.FENCE, ()))
        ]
        + [{"inclusion": False, "points": [list(point) for point in ring], "radius_m": None} for ring in obstacles],
    }


def _places(items: Sequence[PlanItem], frame: LocalFrame) -> list[dict[str, Any]]:
    found = []
    for item in items[:_MOST]:
        if item.frame != _MISSION_FRAME and (item.x or item.y):
            north_m, east_m = frame.to_ned(item.lat_deg, item.lon_deg)
            found.append(
                {
                    "number": item.number,
                    "seq": item.seq,
                    "command": item.command,
                    "north_m": north_m,
                    "east_m": east_m,
                }
            )
    return found
