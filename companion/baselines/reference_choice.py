"""The choice of reference generator by DP_LAW: the companion's own, or that of the ReVolt thesis. It may change under
way, without a jump."""

from __future__ import annotations

from companion.baselines.reference import ThesisReference
from companion.core.setpoint import PoseSetpoint
from companion.guidance.reference import ReferenceGenerator
from companion.params.store import Parameters

_THESIS = 1


class ChosenReference:
    """Same interface as `ReferenceGenerator`. Remembers the generator in use, its last setpoint, its speed limit and
    whether it hurries."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._kinds: tuple[ReferenceGenerator | ThesisReference, ...] = (
            ReferenceGenerator(parameters),
            ThesisReference(parameters),
        )
        self._active = self._wanted()
        self._last: PoseSetpoint | None = None
        self._speed_mps: float | None = None
        self._hurries = False

    def start(
        self,
        north_m: float,
        east_m: float,
        yaw_rad: float,
        surge_mps: float = 0.0,
        sway_mps: float = 0.0,
        yaw_rate_radps: float = 0.0,
    ) -> None:
        """Begin at this state; the target is where the boat comes to rest from it."""
        self._active = self._wanted()
        self._active.start(north_m, east_m, yaw_rad, surge_mps, sway_mps, yaw_rate_radps)
        self._last = self._speed_mps = None
        self._hurries = False

    def retarget(
        self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None = None, hurries: bool = False
    ) -> None:
        """Go on from the present motion to another pose, at `speed_mps` at most; `hurries`: turn faster than
        DP_YAW_RATE, which the thesis's reference cannot."""
        self._speed_mps, self._hurries = speed_mps, hurries
        self._active.retarget(north_m, east_m, yaw_rad, speed_mps, hurries)

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad) that the reference leads to."""
        return self._active.target

    @property
    def arrived(self) -> bool:
        """Whether the reference is at rest at its target."""
        return self._active.arrived

    def update(self, dt_s: float, pace: float = 1.0) -> PoseSetpoint:
        """The reference `dt_s` later. `pace`: share of its speeds; that of the thesis does not wait."""
        wanted = self._wanted()
        if wanted is not self._active:
            self._change(wanted)
        self._last = self._active.update(dt_s, pace)
        return self._last

    def _wanted(self) -> ReferenceGenerator | ThesisReference:
        return self._kinds[1 if self._parameters["DP_LAW"] == _THESIS else 0]

    def _change(self, new: ReferenceGenerator | ThesisReference) -> None:
        """Change the generator: the new one takes over state and target."""
        target, last = self._active.target, self._last
        if last is not None:
            new.start(last.north_m, last.east_m, last.yaw_rad, last.surge_mps, last.sway_mps, last.yaw_rate_radps)
        else:
            new.start(*target)
        new.retarget(*target, self._speed_mps, self._hurries)
        self._active = new
