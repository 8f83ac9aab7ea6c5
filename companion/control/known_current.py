"""The step from a path in still water to one in a known current, and back, without a step of the thrust."""

from __future__ import annotations

from companion.config.hull import HullConfig
from companion.control.bias import BiasForce
from companion.control.model import damping
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import PathSetpoint


class KnownCurrent:
    """Hands over between the bias, which learns what drag an unknown current adds, and the model of a known one.
    Call `hand_over` each cycle. Remembers whether the current was known, and the last that was."""

    def __init__(self, hull: HullConfig) -> None:
        self._hull = hull
        self.restart()

    def restart(self) -> None:
        """Forget it, after another law was active."""
        self._known: bool | None = None
        self._last_mps = (0.0, 0.0)

    def hand_over(self, setpoint: PathSetpoint, nav: NavState, bias: BiasForce) -> None:
        """Where the current becomes known, take off `bias` what its drag adds, as far as that has learnt it; where it
        becomes unknown, add it."""
        before, last_mps = self._known, self._last_mps
        self._known = nav.current_north_mps is not None and nav.current_east_mps is not None
        if self._known:
            last_mps = self._last_mps = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        if before is None or before == self._known:
            return
        x_mps, y_mps = ned_to_body(*last_mps, nav.yaw_rad)
        u, v = setpoint.surge_mps, setpoint.sway_mps
        there_x, there_y, _ = damping(self._hull, u - x_mps, v - y_mps, 0.0)
        still_x, still_y, _ = damping(self._hull, u, v, 0.0)
        more_x, more_y = there_x - still_x, there_y - still_y
        if self._known:
            learnt_x, learnt_y, _ = bias.in_body(nav.yaw_rad)
            more_x, more_y = -_common(more_x, learnt_x), -_common(more_y, learnt_y)
        bias.add(more_x, more_y, 0.0, nav.yaw_rad)


def _common(a: float, b: float) -> float:
    """What both have of one direction."""
    if a * b <= 0.0:
        return 0.0
    return a if abs(a) < abs(b) else b
