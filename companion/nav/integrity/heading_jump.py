"""The heading jumps: by more than the gyro felt, and more than the gyro jumped itself."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.nav.integrity.continuity import Continuity
from companion.nav.integrity.evidence import HeadingSeen, Sense
from companion.nav.integrity.jump import JumpHypothesis, Tracked
from companion.nav.integrity.statistics import NoiseSize
from companion.nav.outliers import Verdict

_LEAST_RAD = math.radians(5.0)
_NOISES = 8.0
_GAP_S = 2.0
_FASTEST_RADPS = math.radians(90.0)  # a boat's own turn, where no gyro tells
_GYRO_RADPS = math.radians(0.2)  # drift of the gyro over a gap


_Source = Tracked[HeadingSeen, NoiseSize]


class HeadingJump(JumpHypothesis[HeadingSeen, NoiseSize]):
    """`screen` is asked for each heading before it is used. Remembers the last heading, the noise and
    the track of each source."""

    def __init__(self) -> None:
        super().__init__(Sense.HEADING, NoiseSize)

    def screen(self, seen: HeadingSeen, driven: bool) -> Verdict | None:
        """What is to become of a heading: REJECT one beside its own track; None: the usual rule."""
        source = self._known(seen)
        if source is None:
            return None
        last = source.last
        if seen.raw == last.raw:
            return source.verdict  # it repeats: no step of the source
        source.last = seen
        track, dt_s = source.track, seen.t_s - last.t_s
        if not driven:
            track.clear()
        if dt_s <= 0.0:
            return None
        self._compare(source, last, seen, driven)
        return source.verdict

    @staticmethod
    def _compare(source: _Source, last: HeadingSeen, seen: HeadingSeen, driven: bool) -> None:
        track, own_rad, dt_s = source.track, wrap_pi(seen.yaw_rad - last.yaw_rad), seen.t_s - last.t_s
        bound_rad = max(_LEAST_RAD, 3.0 * seen.sigma_rad + _NOISES * source.noise.size)
        unfelt_rad, excused = own_rad, False
        if seen.turned_rad is None or last.turned_rad is None:
            bound_rad += _FASTEST_RADPS * dt_s
        else:
            felt_rad = seen.turned_rad - last.turned_rad
            unfelt_rad, excused = wrap_pi(own_rad - felt_rad), abs(felt_rad) > abs(own_rad)
        if dt_s > _GAP_S:
            if driven:
                track.place(seen.t_s, seen.off_rad, 0.0, bound_rad + _GYRO_RADPS * dt_s)
            return
        if driven:
            track.take(seen.t_s, unfelt_rad, 0.0, bound_rad, excused)
            track.compare(seen.t_s, abs(seen.off_rad), bound_rad)
        if not track.suspect and (not excused or abs(unfelt_rad) <= bound_rad):
            source.noise.update(abs(unfelt_rad))

    @staticmethod
    def _size(track: Continuity) -> str:
        return f"{abs(math.degrees(wrap_pi(track.north))):.0f} deg"
