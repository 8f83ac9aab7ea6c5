"""What the hypotheses see of a tick, and what they find."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from companion.core.named import Named
from companion.core.readings import FixType, Imu, MagneticField, TimeOfDay, Wind
from companion.nav.lever_arms import Vector

SETTLED_RADPS = math.radians(0.1)  # sigma of the gyro's bias


class Sense(Named):
    """What a source measures; the value is the word for people."""

    POSITION = "position"
    VELOCITY = "velocity"
    HEADING = "heading"
    IMU = "IMU"  # all of it
    ACCELEROMETER = "accelerometer"
    GYRO = "gyro"
    FIELD = "magnetic field"
    WIND = "wind"
    TIME = "time"


INERTIAL = frozenset({Sense.IMU, Sense.ACCELEROMETER, Sense.GYRO})


class Channel(NamedTuple):
    """One sense of one source."""

    sense: Sense
    source: str


FORCE_AXES, RATE_AXES = ("x", "y", "z"), ("roll", "pitch", "yaw")
IMU_AXES = (*FORCE_AXES, *RATE_AXES)


def sense_of_axis(axis: str) -> Sense:
    """The part of an inertial sensor that measures along, or about, that axis."""
    return Sense.ACCELEROMETER if axis in FORCE_AXES else Sense.GYRO


class LieFound(NamedTuple):
    """A channel that lies, by one hypothesis. `fault`: what it does, for people, after its name. `since_s`: when that
    began, as far as can be told.

    `asks`: it may be right after all; the operator may accept it. `jump`: it was kept out from its first moment on.
    `used`: it is used in spite of it, as well as it can be. `lasting`: only disarming clears it. `widens`: the estimate
    has followed it, nobody knows how far. `loses`: it has done so from the start, and all of it is void.
    """

    channel: Channel
    fault: str
    since_s: float
    asks: bool = False
    jump: bool = False
    used: bool = False
    lasting: bool = False
    widens: bool = False
    loses: bool = False


class InertialWay(NamedTuple):
    """The way that goes with the velocity which the accelerometers have added up to, and the estimate's velocity less
    that one: it stays while nothing but forces changes the estimate."""

    north_m: float
    east_m: float
    carried_north_mps: float
    carried_east_mps: float


class PositionSeen(NamedTuple):
    """A fix. `lat_deg`, `lon_deg`: as the receiver gave them; the rest is of the boat's origin in the local plane.

    `off_*`: less the estimate, whose velocity and one sigma of position are the others. `way`: by the accelerometers;
    None without them. `antenna`: the fix before the lever arm was taken off; None where roll and pitch for that are
    measured.
    """

    t_s: float
    source: str
    lat_deg: float
    lon_deg: float
    north_m: float
    east_m: float
    off_north_m: float
    off_east_m: float
    estimate_north_mps: float
    estimate_east_mps: float
    estimate_sigma_m: float
    sigma_m: float
    fix: FixType
    way: InertialWay | None = None
    antenna: tuple[float, float] | None = None


class VelocitySeen(NamedTuple):
    """A velocity over ground of the boat's origin. `off_*`: less the estimate. `inertial_*`: what the accelerometers
    have added up to, of the origin, too; None without them. `raw`: as the receiver gave it. `yaw_rad`: where the boat
    pointed then, by the estimate."""

    t_s: float
    source: str
    raw: tuple[float, float]
    north_mps: float
    east_mps: float
    off_north_mps: float
    off_east_mps: float
    inertial_north_mps: float | None
    inertial_east_mps: float | None
    sigma_mps: float = 0.1
    yaw_rad: float = 0.0


class HeadingSeen(NamedTuple):
    """A true heading. `off_rad`: less the estimate. `turned_rad`: what the gyro has added up to; None without one.

    `raw`: as the source gave it; `wander_rad`: its slow error by the vessel's file.
    """

    t_s: float
    source: str
    raw: float
    yaw_rad: float
    off_rad: float
    sigma_rad: float
    wander_rad: float
    turned_rad: float | None


class ModelStep(NamedTuple):
    """Velocity over ground and rate of turn that the model of hull, thrust and wind has added up to. `run` changes when
    that begins anew. `pushed_*`: velocity along the hull, by thrust alone."""

    run: int
    north_mps: float
    east_mps: float
    turn_radps: float
    pushed_ahead_mps: float = 0.0
    pushed_starboard_mps: float = 0.0


class LaneStep(NamedTuple):
    """Dead reckoning by the inertial sensor alone: velocity over ground at the time `from_s` and now, and one sigma on
    an axis."""

    from_s: float
    first_north_mps: float
    first_east_mps: float
    north_mps: float
    east_mps: float
    sigma_mps: float


class InertialStep(NamedTuple):
    """What gyro and accelerometers have added up to, by the filter's attitude and biases. `run` changes when that
    begins anew. The turn is by the gyro's bias of some seconds ago, `turn_sigma_radps` is one sigma of that."""

    run: int
    north_mps: float
    east_mps: float
    turned_rad: float
    turn_sigma_radps: float
    lanes: tuple[LaneStep, ...] = ()

    @property
    def settled(self) -> bool:
        """Whether the filter has known its attitude for some time. One that has begun in a hard turn has not."""
        return self.turn_sigma_radps <= SETTLED_RADPS


@dataclass(slots=True)
class Evidence:
    """The readings of a tick, in order of time, with what they say against the estimate.

    `driven`: the boat is armed: nothing is judged else, since moorings and people move it. `maybe_late`: it is, but the
    times of the receiver's values are in doubt: only what allows for that is judged. `astern`: it may go stern first.
    `imu`: calibrated, in the boat's axes; `raw_imu`: as the sensor gave them; `imu_used`: the sensor in use;
    `levers_m`: where sensors sit, from the boat's origin. `inertial`, `model`: None where there is none. `distrusted`:
    found to lie by the last tick; `suspected`: velocities that have just left their own track.
    """

    positions: list[PositionSeen] = field(default_factory=list)
    velocities: list[VelocitySeen] = field(default_factory=list)
    headings: list[HeadingSeen] = field(default_factory=list)
    imu: list[Imu] = field(default_factory=list)
    raw_imu: list[Imu] = field(default_factory=list)
    fields: list[MagneticField] = field(default_factory=list)
    winds: list[Wind] = field(default_factory=list)
    times: list[TimeOfDay] = field(default_factory=list)
    driven: bool = False
    maybe_late: bool = False
    astern: bool = False
    imu_used: str | None = None
    levers_m: Mapping[str, Vector] = field(default_factory=dict)
    inertial: InertialStep | None = None
    model: ModelStep | None = None
    turn_radps: float = 0.0
    north_mps: float = 0.0
    east_mps: float = 0.0
    distrusted: frozenset[Channel] = frozenset()
    suspected: frozenset[Channel] = frozenset()

    @property
    def carrying(self) -> str:
        """The inertial sensor whose samples carry the estimate. Spares are in `imu`, too."""
        return self.imu_used or (self.imu[-1].source if self.imu else "")


class Hypothesis(ABC):
    """One way in which a source can lie. It sees all sources, also those that are not used.

    `doubt`: the largest statistic of the last update over its threshold; from 1 on there is a finding.
    """

    doubt = 0.0

    @abstractmethod
    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Take the readings of a tick; returns what lies now."""

    def clear(self) -> None:  # noqa: B027  some remember nothing that arming would not renew
        """Begin anew: the boat was disarmed."""

    def accept(self, channel: Channel) -> None:  # noqa: B027  not every lie can be right after all
        """An operator, or independent evidence, says that this channel is right as it is."""
