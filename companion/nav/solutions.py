"""Both navigation solutions of a boat, and which of them is in use: the inertial one while it runs."""

from __future__ import annotations

from dataclasses import replace

from companion.nav.inertial import InertialSolution
from companion.nav.integrity.evidence import Sense
from companion.nav.no_imu import PoseSolution
from companion.nav.outliers import Verdict
from companion.nav.way_back import LONGEST_S


class Solutions:
    """`pose`: without inertial sensors. `inertial`: the solution that the inertial sensor carries, None before its
    first sample. Remembers both, and of which senses the next measurement counts anew."""

    def __init__(self) -> None:
        self.pose = PoseSolution()
        self.inertial: InertialSolution | None = None
        self._anew: set[Sense] = set()  # after an inertial sensor has lied

    @property
    def used(self) -> InertialSolution | PoseSolution:
        """The solution in use."""
        inertial = self.inertial
        return inertial if inertial is not None and inertial.running else self.pose

    @property
    def feeling(self) -> InertialSolution | None:
        """The inertial solution while it runs, by forces too; None else."""
        inertial = self.inertial
        return inertial if inertial is not None and inertial.running and inertial.feels else None

    def is_too_late(self, t_s: float) -> bool:
        """Whether the inertial solution has gone on too far from a measurement of that time to use it."""
        inertial = self.inertial
        return inertial is not None and inertial.running and inertial.t_s - t_s > LONGEST_S

    def leave_inertial(self, t_s: float, least_sigma: float = 0.0) -> None:
        """Go on without inertial sensors. `least_sigma`: of position and velocity, in m and m/s."""
        assert self.inertial is not None
        motion = self.inertial.motion(t_s)
        sigma_m, sigma_mps = max(motion.position_sigma_m, least_sigma), max(motion.velocity_sigma_mps, least_sigma)
        self.pose.continue_from(replace(motion, position_sigma_m=sigma_m, velocity_sigma_mps=sigma_mps))
        self.inertial.stop()

    def begin_anew(self) -> None:
        """Forget all but where the inertial sensor is, and its noise."""
        if self.inertial is not None:
            self.inertial.stop()
            self.inertial.forget_biases()
        self.pose = PoseSolution()

    def doubt(self) -> None:
        """An inertial sensor has lied: of each sense, the next measurement that nothing speaks against counts anew."""
        self._anew = {Sense.POSITION, Sense.VELOCITY, Sense.HEADING}

    def begins_anew(self, sense: Sense, rule: Verdict | None) -> Verdict | None:
        """RESET for the first measurement that nothing speaks against, after an inertial sensor has lied: what it has
        added up to counts no longer."""
        if not self._anew or sense not in self._anew or rule is not None:
            return rule
        self._anew.discard(sense)
        return Verdict.RESET
