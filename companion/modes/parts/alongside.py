"""The boat's motion relative to a berth, smoothed to remove the waves, and the force of its thrusters towards it.

Waves move a small hull faster than it comes alongside. So docking decides by the smoothed motion. The scatter, which is
the motion that smoothing removes, measures the sea state.
"""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.decision import ModeInputs
from companion.modes.parts.berth import Berth

_SMOOTH_S = 2.0
_MEAN_S = 20.0
_SEA_S = 60.0


class Alongside:
    """Call `start(berth)`, then `update(inputs)` every tick. Forces towards the berth are positive. All values except
    `*_now_*` are smoothed over 2 s.

    `scatter_mps` is the rms of the velocity that smoothing removes; it is near 0 in calm water. `mean_n` is the mean
    force. Both cover up to 20 s since `settle()`; `settled_s` is the time since then. `shaken_mps2` is the rms
    acceleration towards the berth, over up to 60 s: groups of waves come and go. Little but waves makes it large.
    """

    def __init__(self) -> None:
        self._berth = Berth(0.0, 0.0, 0.0, (0.0, -1.0), 0.0, 0.0)
        self._begun = False
        self.off_m = self.along_m = self.turned_rad = self.closing_mps = self.sliding_mps = self.turning_radps = (
            self.push_n
        ) = 0.0
        self.off_now_m = self.along_now_m = self.turned_now_rad = self.closing_now_mps = 0.0
        self.scatter_mps = self.shaken_mps2 = self.mean_n = self.settled_s = 0.0

    def start(self, berth: Berth) -> None:
        """Measure relative to another berth from the next update on."""
        self._berth, self._begun = berth, False
        self.settle()

    def settle(self) -> None:
        """Restart the averages of force, scatter and acceleration."""
        self.mean_n = self.scatter_mps = self.shaken_mps2 = self.settled_s = 0.0

    def update(self, inputs: ModeInputs) -> None:
        """Update the smoothed motion with this tick's state."""
        nav, berth, dt_s = inputs.nav, self._berth, inputs.dt_s
        off_m, along_m = berth.place(nav.north_m, nav.east_m)
        closing_mps, sliding_mps = berth.resolved(nav.north_mps, nav.east_mps)
        push_n = pushing_n(berth, inputs)
        gained_mps = closing_mps - self.closing_now_mps
        self.off_now_m, self.along_now_m, self.closing_now_mps = off_m, along_m, closing_mps
        turned_rad = self.turned_now_rad = wrap_pi(nav.yaw_rad - berth.yaw_rad)
        if not self._begun:
            self._begun = True
            self.off_m, self.along_m, self.turned_rad = off_m, along_m, turned_rad
            self.closing_mps, self.sliding_mps, self.turning_radps, self.push_n = (
                closing_mps,
                sliding_mps,
                nav.yaw_rate_radps,
                push_n,
            )
            return
        share = dt_s / (dt_s + _SMOOTH_S)
        self.off_m += share * (off_m - self.off_m)
        self.along_m += share * (along_m - self.along_m)
        self.turned_rad = wrap_pi(self.turned_rad + share * wrap_pi(turned_rad - self.turned_rad))
        self.closing_mps += share * (closing_mps - self.closing_mps)
        self.sliding_mps += share * (sliding_mps - self.sliding_mps)
        self.turning_radps += share * (nav.yaw_rate_radps - self.turning_radps)
        self.push_n += share * (push_n - self.push_n)
        if dt_s <= 0.0:
            return
        self.settled_s += dt_s
        share = dt_s / min(self.settled_s, _MEAN_S)
        rest_mps = math.hypot(closing_mps - self.closing_mps, sliding_mps - self.sliding_mps)
        self.scatter_mps = math.sqrt((1.0 - share) * self.scatter_mps**2 + share * rest_mps * rest_mps)
        self.mean_n += share * (push_n - self.mean_n)
        share = dt_s / min(self.settled_s, _SEA_S)
        self.shaken_mps2 = math.sqrt((1.0 - share) * self.shaken_mps2**2 + share * (gained_mps / dt_s) ** 2)


def pushing_n(berth: Berth, inputs: ModeInputs) -> float:
    """The achieved force towards the berth, N."""
    (x, y), given = berth.towards, inputs.achieved
    return given.surge_n * x + given.sway_n * y
