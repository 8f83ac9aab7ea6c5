"""The velocity of a receiver jumps: by more than the accelerometers felt, and more than they felt of it."""

from __future__ import annotations

import math

from companion.nav.integrity.continuity import Continuity
from companion.nav.integrity.evidence import Sense, VelocitySeen
from companion.nav.integrity.jump import JumpHypothesis, Tracked
from companion.nav.integrity.statistics import StepNoise
from companion.nav.outliers import Verdict

_LEAST_MPS = 0.2
_CLAIMS = 4.0  # of the accuracy that the vessel's file gives
_NOISES = 8.0  # of its usual step beside the accelerometers', which is learned in sigmas: another grade has another
_GAP_S = 2.0
_FASTEST_MPS2 = 3.0  # a boat's own acceleration, where no accelerometer tells
_AGREES_MPS = 0.15
_BACK = 0.5  # of the jump: nearer to the estimate than to where it has jumped to, or it is not back


_Receiver = Tracked[VelocitySeen, StepNoise]


class VelocityJump(JumpHypothesis[VelocitySeen, StepNoise]):
    """`screen` is asked for each velocity before it is used. Remembers the last velocity, the noise and
    the track of each receiver."""

    def __init__(self) -> None:
        super().__init__(Sense.VELOCITY, StepNoise)

    def suspects(self, source: str) -> bool:
        """Whether the velocity of that receiver is off its own track."""
        receiver = self._sources.get(source)
        return receiver is not None and receiver.track.suspect

    def screen(self, seen: VelocitySeen, driven: bool) -> Verdict | None:
        """REJECT a velocity beside its own track; None: the usual rule."""
        receiver = self._known(seen)
        if receiver is None:
            return None
        last = receiver.last
        if seen.raw != last.raw:  # else it repeats: no step of the receiver
            receiver.last = seen
            self._compare(receiver, last, seen, driven)
        return receiver.verdict

    @staticmethod
    def _compare(receiver: _Receiver, last: VelocitySeen, seen: VelocitySeen, driven: bool) -> None:
        track, dt_s = receiver.track, seen.t_s - last.t_s
        if dt_s > _GAP_S or not driven:
            track.clear()
        if not 0.0 < dt_s <= _GAP_S:
            return
        own = seen.north_mps - last.north_mps, seen.east_mps - last.east_mps
        felt, unfelt = _felt(last, seen, own)
        sigma_mps = max(last.sigma_mps, seen.sigma_mps)
        noise_mps = receiver.noise.size * sigma_mps
        bound_mps = max(_LEAST_MPS, _CLAIMS * sigma_mps, _NOISES * noise_mps)
        if felt is None:
            bound_mps += _FASTEST_MPS2 * dt_s
        excused = felt is not None and math.hypot(*felt) > math.hypot(*own)
        if driven:
            track.take(seen.t_s, *unfelt, bound_mps, excused)
            off_mps = math.hypot(seen.off_north_mps, seen.off_east_mps)
            track.compare(seen.t_s, off_mps, min(max(_AGREES_MPS, 4.0 * noise_mps), _BACK * track.size))
        if not track.suspect and (not excused or math.hypot(*unfelt) <= bound_mps):
            receiver.noise.update(unfelt[0] / sigma_mps, unfelt[1] / sigma_mps)

    @staticmethod
    def _size(track: Continuity) -> str:
        return f"{track.size:.1f} m/s"


def _felt(
    last: VelocitySeen, seen: VelocitySeen, own: tuple[float, float]
) -> tuple[tuple[float, float] | None, tuple[float, float]]:
    """(the accelerometers' change of velocity, or None; the receiver's less that)."""
    if (
        seen.inertial_north_mps is None
        or seen.inertial_east_mps is None
        or last.inertial_north_mps is None
        or last.inertial_east_mps is None
    ):
        return None, own
    felt = seen.inertial_north_mps - last.inertial_north_mps, seen.inertial_east_mps - last.inertial_east_mps
    return felt, (own[0] - felt[0], own[1] - felt[1])
