"""What the boat remembers of its ground stations: when one was heard, which has operator control, whose sticks came
last. What follows from it stands in `authority.py`.

Systems are told apart by the number of the message's sender, which anybody can claim where packets are not signed.
Operator control: MAVLink's development.xml, MAV_CMD_REQUEST_OPERATOR_CONTROL and CONTROL_STATUS.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable


class GroundStations:
    """`in_control`: system with operator control, 0 for none. `takeover`: whether others may take it. `steering`:
    system and link of the sticks that came last, and `steered_s` when."""

    def __init__(self, operators: Collection[int] = ()) -> None:
        """`operators`: the only systems that may command; empty: all may."""
        self.operators = frozenset(operators)
        self.in_control = 0
        self.takeover = True
        self.steering: tuple[int, Hashable] | None = None
        self.steered_s = -math.inf
        self._heard_s: float | None = None
        self._control_s = 0.0

    def heard(self, now_s: float) -> None:
        """A ground station is there, or what counts as one."""
        self._heard_s = now_s

    def age_s(self, now_s: float) -> float | None:
        """Since one was last heard; None if none ever was."""
        return None if self._heard_s is None else now_s - self._heard_s

    def steer(self, system: int, link: Hashable, now_s: float) -> bool:
        """The sticks of that system count. True where others' counted before."""
        changed = self.steering not in (None, (system, link))
        self.steering, self.steered_s = (system, link), now_s
        return changed

    def packet(self, system: int, now_s: float) -> None:
        """Any packet of a system keeps its operator control."""
        if system == self.in_control:
            self._control_s = now_s

    def take_control(self, system: int, takeover: bool, now_s: float) -> None:
        """That system has control from now on."""
        self.in_control, self.takeover, self._control_s = system, takeover, now_s

    def release_control(self) -> None:
        """No system has control."""
        self.in_control, self.takeover = 0, True

    def lapse_control(self, now_s: float, timeout_s: float) -> int:
        """The system that loses control now because it is silent; 0 for none."""
        silent = self.in_control
        if not silent or now_s - self._control_s <= timeout_s:
            return 0
        self.release_control()
        return silent
