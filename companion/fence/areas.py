"""The areas of a fence: where the boat, its middle and its plans may be."""

from __future__ import annotations

from dataclasses import dataclass

from companion.core.work import Lane
from companion.fence.area import FenceArea


@dataclass(frozen=True, slots=True)
class FenceAreas:
    """`fence`: where the boat may be. `stopping`: where its middle may come to rest, half a boat's length further in.
    `keeping`: where plans may lead, further in again by FENCE_MARGIN."""

    fence: FenceArea
    stopping: FenceArea
    keeping: FenceArea

    def in_lane(self, lane: Lane) -> FenceAreas:
        """As `FenceArea.in_lane`."""
        return FenceAreas(self.fence.in_lane(lane), self.stopping.in_lane(lane), self.keeping.in_lane(lane))
