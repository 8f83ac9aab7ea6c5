"""One row a hypothesis: a boat, a lie that it finds, and what it says of that."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace

from companion.core.frames import ned_to_body
from companion.nav.integrity.accuracy_lie import AccuracyLie
from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, Sense
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
from tests.unit.nav.integrity.honest_boat import Boat, Spoil, another, moved, sped, turned

BOAT, CALM = Boat(), Boat(rocking=0.1)
POSITION, VELOCITY, HEADING = (
    Channel(Sense.POSITION, "gnss"),
    Channel(Sense.VELOCITY, "gnss"),
    Channel(Sense.HEADING, "gnss"),
)
IMU, TIME = Channel(Sense.IMU, "imu"), Channel(Sense.TIME, "gnss")
ACCELEROMETER, GYRO = Channel(Sense.ACCELEROMETER, "imu"), Channel(Sense.GYRO, "imu")


def frozen_imu(evidence: Evidence, age_s: float) -> None:
    evidence.raw_imu = [replace(imu, **_SAMPLE) for imu in evidence.raw_imu]


_SAMPLE = {
    "x_mps2": 0.1, "y_mps2": 0.1, "z_mps2": -9.8,
    "roll_rate_radps": 0.0, "pitch_rate_radps": 0.0, "yaw_rate_radps": 0.0,
}  # fmt: skip


def stuck_yaw(evidence: Evidence, age_s: float) -> None:
    evidence.raw_imu = [replace(imu, yaw_rate_radps=0.01) for imu in evidence.raw_imu]


def heavy(evidence: Evidence, age_s: float) -> None:
    evidence.imu = [replace(imu, z_mps2=1.3 * imu.z_mps2) for imu in evidence.imu]


def two_more(evidence: Evidence, age_s: float) -> None:
    """Inertial sensors with biases of their own."""
    evidence.imu += [
        replace(imu, source=name, x_mps2=imu.x_mps2 + bias, yaw_rate_radps=imu.yaw_rate_radps + 0.02 * bias)
        for name, bias in (("imu2", 0.2), ("imu3", -0.2))
        for imu in evidence.imu
        if imu.source == "imu"
    ]


def turning(evidence: Evidence, age_s: float) -> None:
    evidence.imu = [
        replace(imu, yaw_rate_radps=imu.yaw_rate_radps + 0.1) if imu.source == "imu" else imu for imu in evidence.imu
    ]


def reversed_x(evidence: Evidence, age_s: float) -> None:
    """The rocking ahead is felt astern, so the sums of the accelerometers go the other way."""
    evidence.imu = [replace(imu, x_mps2=-imu.x_mps2) for imu in evidence.imu]
    evidence.velocities = [
        seen._replace(inertial_north_mps=-seen.north_mps + seen.off_north_mps) for seen in evidence.velocities
    ]


def noisy() -> Spoil:
    rng = random.Random(7)

    def spoil(evidence: Evidence, age_s: float) -> None:
        evidence.positions = [
            seen._replace(north_m=seen.north_m + rng.gauss(0.0, 0.15), east_m=seen.east_m + rng.gauss(0.0, 0.15))
            for seen in evidence.positions
        ]

    return spoil


def pushed(evidence: Evidence, age_s: float) -> None:
    """Half of what rocks the boat along its hull is its own thrust."""
    assert evidence.model is not None
    ahead_mps, _ = ned_to_body(evidence.north_mps, evidence.east_mps, evidence.headings[-1].yaw_rad)
    evidence.model = evidence.model._replace(pushed_ahead_mps=0.5 * ahead_mps)


def pointed(evidence: Evidence, off_rad: float) -> None:
    """The estimate points elsewhere by that much, as the heading does."""
    evidence.velocities = [seen._replace(yaw_rad=seen.yaw_rad + off_rad) for seen in evidence.velocities]


def swapped(evidence: Evidence, age_s: float) -> None:
    """The antennas are swapped: the estimate points the other way, as the heading does."""
    pointed(evidence, math.pi)


def ahead_of_time(evidence: Evidence, age_s: float) -> None:
    evidence.times = [replace(time, time_unix_ns=time.time_unix_ns + 60 * 10**9) for time in evidence.times]


def stormy(evidence: Evidence, age_s: float) -> None:
    evidence.winds = [replace(wind, speed_mps=60.0) for wind in evidence.winds]


@dataclass(frozen=True)
class Row:
    """`within_s`: how soon the hypothesis must find `lie` on `boat`, which it has known for 40 s; `fault`: what it says
    of `channel`. `always`: what the boat's sensors are like before the lie, too."""

    make: Callable[[], Hypothesis]
    lie: Spoil
    channel: Channel
    fault: str
    within_s: float
    boat: Boat = BOAT
    always: Spoil | None = None

    @property
    def name(self) -> str:
        return self.make().__class__.__name__


ROWS = (
    Row(Repeated, frozen_imu, IMU, "repeats", 0.5),
    Row(ImuStuck, stuck_yaw, GYRO, "yaw axis stuck", 1.0),
    Row(ImuGravity, heavy, ACCELEROMETER, "force is not gravity", 3.0),
    Row(ImuApart, turning, GYRO, "is not as the others", 2.0, always=two_more),
    Row(HeadingTurned, swapped, HEADING, "is off by 180 deg", 30.0, always=pushed),
    Row(ImuReversed, reversed_x, ACCELEROMETER, "x axis reversed", 15.0),
    Row(PositionJump, lambda evidence, _: moved(evidence, 5.0), POSITION, "jumped 5.0 m", 0.6),
    Row(VelocityJump, lambda evidence, _: sped(evidence, 0.5), VELOCITY, "jumped 0.5 m/s", 0.6),
    Row(HeadingJump, lambda evidence, _: turned(evidence, math.pi / 2), HEADING, "jumped 90 deg", 0.6),
    Row(VelocityVote, lambda evidence, age_s: sped(evidence, 0.05 * age_s), VELOCITY, "fits no force", 10.0, CALM),
    Row(PositionDrift, lambda evidence, age_s: moved(evidence, 0.5 * age_s), POSITION, "drifts", 1.0),
    Row(HeadingDrift, lambda evidence, age_s: turned(evidence, math.radians(age_s)), HEADING, "drifts", 4.0),
    Row(HeadingCourse, lambda evidence, _: turned(evidence, 0.7), HEADING, "is not on course", 9.0, Boat(8.0)),
    Row(TimeWrong, ahead_of_time, TIME, "is off by 60.0 s", 0.2),
    Row(WindStrong, stormy, Channel(Sense.WIND, "wind"), "says 60 m/s", 3.0),
    Row(AccuracyLie, noisy(), POSITION, "is noisier than it claims", 5.0),
    Row(
        ReceiversApart,
        lambda evidence, _: moved(evidence, 8.0, "spare"),
        Channel(Sense.POSITION, "spare"),
        "is 8 m from gnss",
        4.0,
        always=lambda evidence, _: another(evidence, 0.0),
    ),
)
