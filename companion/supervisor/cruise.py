"""The speed at which modes that steer by themselves sail."""

from __future__ import annotations

import math

from companion.params.store import Parameters


class Cruise:
    """Remembers the speed that was asked for, m/s; None: WP_SPEED. MPC_XY_VEL_MAX caps both."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.asked_mps: float | None = None

    def ask(self, speed_mps: float | None) -> None:
        """Set the speed until the next call. A value that is not above 0 and finite means None."""
        self.asked_mps = self.limited(speed_mps)

    def limited(self, speed_mps: float | None) -> float | None:
        """A speed above 0 within the cap, or None."""
        if speed_mps is None or not math.isfinite(speed_mps) or speed_mps <= 0.0:
            return None
        return min(speed_mps, self._parameters["MPC_XY_VEL_MAX"])

    @property
    def speed_mps(self) -> float:
        """The speed in force."""
        speed_mps = self._parameters["WP_SPEED"] if self.asked_mps is None else self.asked_mps
        return min(speed_mps, self._parameters["MPC_XY_VEL_MAX"])
