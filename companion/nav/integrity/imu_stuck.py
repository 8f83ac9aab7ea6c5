"""One axis of an inertial sensor is stuck, also at the end of its range: it repeats while the others go on."""

from __future__ import annotations

from collections.abc import Sequence

from companion.core.readings import Imu
from companion.nav.integrity.evidence import (
    IMU_AXES,
    Channel,
    Evidence,
    Hypothesis,
    LieFound,
    sense_of_axis,
)
from companion.nav.integrity.statistics import RepeatRun

_LEAST_RUN = 50  # samples; an axis of few bits may rest for some


class ImuStuck(Hypothesis):
    """Remembers a run of repeats for each axis of each sensor."""

    def __init__(self) -> None:
        self._runs: dict[str, tuple[RepeatRun, ...]] = {}

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Sensors of which one axis is stuck, but not all."""
        for imu in evidence.raw_imu:
            runs = self._runs.get(imu.source)
            if runs is None:
                runs = self._runs[imu.source] = tuple(RepeatRun() for _ in IMU_AXES)
            RepeatRun.update_each(runs, _values(imu), imu.t_s)
        self.doubt = 0.0
        return [found for source, runs in self._runs.items() for found in self._judged(source, runs, evidence.driven)]

    def _judged(self, source: str, runs: Sequence[RepeatRun], driven: bool) -> Sequence[LieFound]:
        if not driven or not any(run.run == 0 for run in runs):
            return ()
        found = []
        for axis, run in zip(IMU_AXES, runs, strict=True):
            doubt = min(run.doubt, run.run / _LEAST_RUN) if run.run else 0.0
            self.doubt = max(self.doubt, doubt)
            if doubt >= 1.0:
                found.append(LieFound(Channel(sense_of_axis(axis), source), f"{axis} axis stuck", run.since_s))
        return found[:1]


def _values(imu: Imu) -> tuple[float, ...]:
    return imu.x_mps2, imu.y_mps2, imu.z_mps2, imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps
