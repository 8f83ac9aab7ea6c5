"""Which reference generator leads dynamic positioning: the companion's own or the thesis's, as DP_LAW says, changed under way without a jump."""

from __future__ import annotations

from companion.core.types import Setpoint
from companion.guidance.reference import ReferenceGenerator
from companion.guidance.thesis_reference import ThesisReference
from companion.params import Parameters

_THESIS = 1


class ChosenReference:
    """Same interface as `ReferenceGenerator`. Remembers the one at work and its last setpoint."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._kinds: tuple[ReferenceGenerator | ThesisReference, ...] = (ReferenceGenerator(parameters), ThesisReference(parameters))
        self._active = self._wanted()
        self._last: Setpoint | None = None
        self._speed_mps: float | None = None

    def start(
        self, north_m: float, east_m: float, yaw_rad: float, surge_mps: float = 0.0, sway_mps: float = 0.0, yaw_rate_radps: float = 0.0
    ) -> None:
        """Begin at this state; the target is where the boat comes to rest from it."""
        self._active = self._wanted()
        self._active.start(north_m, east_m, yaw_rad, surge_mps, sway_mps, yaw_rate_radps)
        self._last = self._speed_mps = None

    def retarget(self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None = None) -> None:
        """Go on from the present motion to another pose."""
        self._speed_mps = speed_mps
        self._active.retarget(north_m, east_m, yaw_rad, speed_mps)

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) where the reference leads to."""
        return self._active.target

    @property
    def arrived(self) -> bool:
        """Whether the reference stands at its target."""
        return self._active.arrived

    def update(self, dt_s: float) -> Setpoint:
        """The reference `dt_s` later."""
        wanted = self._wanted()
        if wanted is not self._active:
            self._change(wanted)
        self._last = self._active.update(dt_s)
        return self._last

    def _wanted(self) -> ReferenceGenerator | ThesisReference:
        return self._kinds[1 if self._parameters["DP_LAW"] == _THESIS else 0]

    def _change(self, new: ReferenceGenerator | ThesisReference) -> None:
        """Hand the present state and the target over."""
        target, last = self._active.target, self._last
        if last is not None and last.north_m is not None and last.east_m is not None and last.yaw_rad is not None:
            new.start(last.north_m, last.east_m, last.yaw_rad, last.surge_mps, last.sway_mps, last.yaw_rate_radps)
        else:
            new.start(*target)
        new.retarget(*target, self._speed_mps)
        self._active = new
