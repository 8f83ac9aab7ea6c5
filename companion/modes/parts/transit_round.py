"""Another way to the point that a boat in transit goes to."""

from __future__ import annotations

from companion.core.decision import ModeInputs
from companion.fence.allowed import Way
from companion.obstacles.open_water import Water
from companion.obstacles.way_round import WayRound
from companion.positioning.hold_point import HoldPoint


def transit_round(hold_point: HoldPoint, inputs: ModeInputs) -> WayRound[Way | None] | None:
    """To the same point, or to the nearest place beside it; None where the boat is not in transit."""
    if not hold_point.in_transit:
        return None
    here, end = (inputs.nav.north_m, inputs.nav.east_m), hold_point.target

    def find(water: Water) -> Way | None:
        return water.way(here, end)

    def lay(way: Way | None, inputs: ModeInputs) -> str | None:
        there = hold_point.in_transit and hold_point.target == end
        return hold_point.go_round(inputs.nav, way) if there else None

    return WayRound(find, lay)
