"""The hypotheses: one file each, one row here. They are asked in this order; the first to find a channel names it."""

from __future__ import annotations

from companion.nav.integrity.accuracy_lie import AccuracyLie
from companion.nav.integrity.evidence import Hypothesis
from companion.nav.integrity.heading_course import HeadingCourse
from companion.nav.integrity.heading_drift import HeadingDrift
from companion.nav.integrity.heading_jump import HeadingJump
from companion.nav.integrity.heading_turned import HeadingTurned
from companion.nav.integrity.imu_apart import ImuApart
from companion.nav.integrity.imu_gravity import ImuGravity
from companion.nav.integrity.imu_reversed import ImuReversed
from companion.nav.integrity.imu_stuck import ImuStuck
from companion.nav.integrity.position_drift import PositionDrift
from companion.nav.integrity.position_jump import PositionJump
from companion.nav.integrity.receivers_apart import ReceiversApart
from companion.nav.integrity.repeated import Repeated
from companion.nav.integrity.time_wrong import TimeWrong
from companion.nav.integrity.velocity_jump import VelocityJump
from companion.nav.integrity.velocity_vote import VelocityVote
from companion.nav.integrity.wind_strong import WindStrong


class Hypotheses:
    """One of each. Some are also asked for each reading as it comes, or for an accuracy. `timeless`: what they find is
    none that readings which come late make."""

    def __init__(self) -> None:
        self.position_jump = PositionJump()
        self.velocity_jump = VelocityJump()
        self.heading_jump = HeadingJump()
        self.accuracy_lie = AccuracyLie()
        self.receivers_apart = ReceiversApart()
        self.heading_turned = HeadingTurned()
        repeated, stuck, gravity, apart = Repeated(), ImuStuck(), ImuGravity(), ImuApart()
        time, wind = TimeWrong(), WindStrong()
        self.timeless: tuple[Hypothesis, ...] = (repeated, stuck, gravity, apart, time, wind, self.position_jump)
        self.all: tuple[Hypothesis, ...] = (
            repeated,
            stuck,
            gravity,
            apart,
            self.heading_turned,
            ImuReversed(self.heading_turned),
            self.position_jump,
            self.velocity_jump,
            self.heading_jump,
            VelocityVote(),
            PositionDrift(),
            HeadingDrift(),
            HeadingCourse(),
            time,
            wind,
            self.accuracy_lie,
            self.receivers_apart,
        )
