"""Reasons that several modes have for refusing, as ground stations list them."""

from __future__ import annotations

from companion.core.decision import KnownRefusal

_MOVE = "Move the boat or the fence, or lower <param>FENCE_MARGIN</param>."
FENCE_REFUSALS: tuple[KnownRefusal, ...] = (
    KnownRefusal(r".*outside the fence", "leads outside the fence", "Draw it inside the fence, or change the fence."),
    KnownRefusal(r".*crosses the fence", "the way crosses the fence", "Draw a way inside the fence, or sail round."),
    KnownRefusal(r".*nearer than .* to the fence", "too near the fence", _MOVE),
    KnownRefusal(r".*chart obstacle", "a chart obstacle is in the way", "Move the item, or change the chart."),
)
FAR_AWAY = KnownRefusal(
    r".* km away", "the destination is over 50 km away", "Check the coordinates, and the place of the boat."
)
