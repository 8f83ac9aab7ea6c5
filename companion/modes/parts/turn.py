"""A turn on the spot in a chosen direction, which may be the long way round."""

from __future__ import annotations

import math

from companion.core.angles import TWO_PI, wrap_pi

_STEP_RAD = 2.0  # less than half a turn, because the reference turns the short way


class TurnPlan:
    """`update(yaw_rad)` returns the heading to ask for next. Remembers how much of the turn is left. Angles are in
    radians, clockwise positive."""

    def __init__(self, from_rad: float, yaw_rad: float, relative: bool, direction: int) -> None:
        """`direction` is 1 clockwise, −1 counter-clockwise, or 0 for the short way. A relative turn with 0 uses the
        sign of `yaw_rad`."""
        if relative:
            turn = yaw_rad if direction == 0 else math.copysign(yaw_rad, direction)
        else:
            turn = wrap_pi(yaw_rad - from_rad)
            if direction > 0 and turn < 0.0:
                turn += TWO_PI
            elif direction < 0 and turn > 0.0:
                turn -= TWO_PI
        self._left_rad = turn
        self._last_rad = from_rad
        self._end_rad = wrap_pi(from_rad + turn)

    @property
    def in_last_step(self) -> bool:
        """Whether the rest of the turn is short enough to ask for its end."""
        return abs(self._left_rad) <= _STEP_RAD

    def update(self, yaw_rad: float) -> float:
        """Return the heading to ask for next. `yaw_rad` is the reference's present heading."""
        if not self.in_last_step:
            self._left_rad -= wrap_pi(yaw_rad - self._last_rad)
            self._last_rad = yaw_rad
        if self.in_last_step:
            return self._end_rad
        return wrap_pi(yaw_rad + math.copysign(_STEP_RAD, self._left_rad))
