"""Receiver, accelerometers and hull model, each against the other two: the one that is alone lies.

Each of them tells the velocity over ground: the receiver measures it; the inertial sensor carries on that of some
seconds ago by its forces, in lanes that no measurement reaches; the model carries it on by thrust, damping and wind.
One difference alone does not tell who is wrong; the one that differs from both others, in the same way, is. The model
itself is never blamed: collisions, moorings and failed thrusters make it wrong. Of an inertial sensor that is alone the
accelerometers are blamed while gyro and heading agree: a gyro that is off turns away sooner than its forces.

Against a receiver there are two witnesses that are wrong for different reasons, so each need not be sure alone. Against
an inertial sensor there is in fact one, since model and receiver both differ from the same lane: a filter that has
taken a tilt for a bias makes the next turn look like a lying sensor, so more is asked for.

Lanes are judged by their own covariance, and what an honest sensor adds to that; the model by what hulls, gusts and
waves have been seen to add.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.nav.integrity.evidence import (
    Channel,
    Evidence,
    Hypothesis,
    InertialStep,
    LaneStep,
    LieFound,
    ModelStep,
    Sense,
    VelocitySeen,
)
from companion.nav.integrity.statistics import NoiseSize

_LANE_MPS = 0.06
_LANE_SIGMAS = 5.0
_LANE_SEAS = 0.3  # errors of scale and of timing grow with the motion
_MODEL_MPS = 0.15
_MODEL_MPS2 = 0.015  # what wind and hull that are not known add with time
_MODEL_USUALS = 5.0  # of what receiver and model usually differ by: no model fits every boat
_MODEL_KNOWN_S = 30.0  # how long that is learnt before the model has a vote
_SEAS = 2.0  # of the waves' velocity, which the model does not know
_NOISES = 1.5  # of one velocity, of which the mean of a second is judged
_MEAN_S = 1.0
_SEA_TIME_S, _SEA_PERIOD_S = 10.0, 3.0
_RECEIVER_ALONE = 0.75  # of the limits
_INERTIAL_ALONE = 1.5  # of the lane's limit
_ALIKE = 0.5  # share of the larger difference by which the two of an inertial sensor may differ
_SAME_WAY = 0.9  # cosine of the angle between the two of a receiver: a lane may have followed a part of its lie
_GAP_S = 1.5
_JUST_AFTER_S = 0.01
_MODEL_TICKS = 1000
_FORGOTTEN_S = 1.0
_AGREES, _AGREES_S = 0.5, 2.0  # share of the threshold below which the receiver agrees with the estimate again; so long

Pair = tuple[float, float]


class _Sea:
    """Velocities that the accelerometers have added up to → the size of their quick part, the waves. Remembers a mean
    and the size."""

    def __init__(self) -> None:
        self._mean: Pair | None = None
        self.size_mps = 0.0

    def update(self, dt_s: float, inertial: InertialStep) -> None:
        """Take the sums after a further `dt_s`."""
        mean = self._mean or (inertial.north_mps, inertial.east_mps)
        share = min(dt_s / _SEA_PERIOD_S, 1.0)
        north, east = inertial.north_mps - mean[0], inertial.east_mps - mean[1]
        self._mean = (mean[0] + share * north, mean[1] + share * east)
        self.size_mps += min(dt_s / _SEA_TIME_S, 1.0) * (math.hypot(north, east) - self.size_mps)

    def clear(self) -> None:
        """The sums begin anew."""
        self._mean = None


@dataclass(slots=True)
class _Receiver:
    """`apart`: mean of the last second, of the receiver's velocity less that of each lane. `model`: the size of what
    receiver and model usually differ by."""

    last: VelocitySeen | None = None
    model: NoiseSize = field(default_factory=lambda: NoiseSize(_MODEL_TICKS))
    model_s: float | None = None  # since when that is learnt
    noise: NoiseSize = field(default_factory=NoiseSize)
    apart: dict[float, Pair] = field(default_factory=dict)
    since_s: float | None = None
    found_s: float = 0.0
    limit_mps: float = 0.0  # by which it was found to differ from a lane
    agrees_s: float = math.inf  # since when all its velocities have been near the estimate


class VelocityVote(Hypothesis):
    """Remembers for each receiver how far it is from the lanes, what the model had added up to when each began, and the
    waves."""

    def __init__(self) -> None:
        self._receivers: dict[str, _Receiver] = {}
        self._starts: dict[float, ModelStep] = {}
        self._sea = _Sea()
        self._run: int | None = None
        self._last_s = math.inf
        self._imu: tuple[Channel, float] | None = None  # what lies, and since when
        self._agrees_s = -math.inf  # when gyro and heading were last seen to agree

    def clear(self) -> None:
        """Begin anew."""
        self._imu = None
        self._receivers.clear()
        self._starts.clear()

    def accept(self, channel: Channel) -> None:
        """The boat moves as that receiver says."""
        if channel.sense is Sense.VELOCITY:
            self._receivers.pop(channel.source, None)

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Receivers whose velocity, or the inertial sensor whose forces, differ from both others."""
        self.doubt = 0.0
        dt_s, self._last_s = min(max(now_s - self._last_s, 0.0), 1.0), now_s
        inertial, model = evidence.inertial, evidence.model
        if inertial is None or inertial.run != self._run:
            self._sea.clear()
            self._starts.clear()
        self._run = None if inertial is None else inertial.run
        if inertial is None or not inertial.settled or model is None or not evidence.driven:
            return self._findings()
        if any(seen.turned_rad is not None for seen in evidence.headings) and not evidence.distrusted:
            self._agrees_s = now_s
        self._sea.update(dt_s, inertial)
        self._begin(inertial.lanes, model)
        for seen in evidence.velocities:
            self._take(self._receiver(seen.source), seen, inertial)
            self._compare(self._receiver(seen.source), seen, now_s)
        for receiver in self._receivers.values():
            for i, lane in enumerate(inertial.lanes):
                apart = self._differences(receiver, lane, model)
                if apart is not None:
                    self._judge(receiver, lane, apart, i == 0, evidence, now_s)
        return self._findings()

    def _begin(self, lanes: Sequence[LaneStep], model: ModelStep) -> None:
        """Note what the model adds up to where a lane begins; forget lanes that have ended."""
        starts = self._starts
        begun = {lane.from_s for lane in lanes}
        for from_s in [from_s for from_s, start in starts.items() if from_s not in begun or start.run != model.run]:
            del starts[from_s]
            for receiver in self._receivers.values():
                receiver.apart.pop(from_s, None)
        for from_s in begun - starts.keys():
            starts[from_s] = model

    @staticmethod
    def _take(receiver: _Receiver, seen: VelocitySeen, inertial: InertialStep) -> None:
        last, receiver.last = receiver.last, seen
        if last is None or not 0.0 < seen.t_s - last.t_s <= _GAP_S:
            receiver.apart.clear()
            return
        if seen.inertial_north_mps is None or seen.inertial_east_mps is None or last.inertial_north_mps is None:
            return
        felt = seen.inertial_north_mps - inertial.north_mps, seen.inertial_east_mps - inertial.east_mps
        share = min((seen.t_s - last.t_s) / _MEAN_S, 1.0)
        step = math.hypot(
            seen.north_mps - last.north_mps - (seen.inertial_north_mps - last.inertial_north_mps),
            seen.east_mps - last.east_mps - (seen.inertial_east_mps - (last.inertial_east_mps or 0.0)),
        )
        receiver.noise.update(step)
        for lane in inertial.lanes:
            north = seen.north_mps - lane.north_mps - felt[0]
            east = seen.east_mps - lane.east_mps - felt[1]
            before = receiver.apart.get(lane.from_s, (0.0, 0.0))
            receiver.apart[lane.from_s] = (
                before[0] + share * (north - before[0]),
                before[1] + share * (east - before[1]),
            )

    def _differences(self, receiver: _Receiver, lane: LaneStep, model: ModelStep) -> tuple[Pair, Pair] | None:
        """(receiver less lane, lane less model); None: not known yet."""
        start, apart = self._starts.get(lane.from_s), receiver.apart.get(lane.from_s)
        if start is None or apart is None:
            return None
        return apart, (
            lane.north_mps - lane.first_north_mps - (model.north_mps - start.north_mps),
            lane.east_mps - lane.first_east_mps - (model.east_mps - start.east_mps),
        )

    def _judge(
        self,
        receiver: _Receiver,
        lane: LaneStep,
        differences: tuple[Pair, Pair],
        learns: bool,
        evidence: Evidence,
        now_s: float,
    ) -> None:
        by_lane, lane_model = differences
        by_model = by_lane[0] + lane_model[0], by_lane[1] + lane_model[1]
        noise_mps, sea_mps = _NOISES * receiver.noise.size, self._sea.size_mps
        lane_mps = _LANE_MPS + _LANE_SIGMAS * lane.sigma_mps + noise_mps + _LANE_SEAS * sea_mps
        if receiver.since_s is not None:
            self.doubt = 1.0
            return
        if learns:
            receiver.model_s = now_s if receiver.model_s is None else receiver.model_s
            receiver.model.update(math.hypot(*by_model))
        if receiver.model_s is None or now_s - receiver.model_s < _MODEL_KNOWN_S:
            return
        model_mps = _MODEL_MPS + _MODEL_MPS2 * (now_s - lane.from_s) + _SEAS * sea_mps
        model_mps = max(model_mps, _MODEL_USUALS * receiver.model.size)
        apart = math.hypot(*by_lane) / lane_mps
        receiver_alone = min(apart, math.hypot(*by_model) / (model_mps + noise_mps)) / _RECEIVER_ALONE
        imu_alone = min(apart / _INERTIAL_ALONE, math.hypot(*lane_model) / model_mps)
        self.doubt = max(self.doubt, min(receiver_alone, 1.0), min(imu_alone, 1.0))
        since_s = lane.from_s + _JUST_AFTER_S  # it has begun in this lane, nobody knows when
        if receiver_alone >= 1.0 and _same_way(by_lane, by_model):
            receiver.since_s, receiver.found_s, receiver.limit_mps = since_s, now_s, lane_mps
        elif imu_alone >= 1.0 and _opposite(by_lane, lane_model) and evidence.imu:
            agrees = now_s - self._agrees_s <= _GAP_S
            self._imu = Channel(Sense.ACCELEROMETER if agrees else Sense.IMU, evidence.carrying), since_s

    @staticmethod
    def _compare(receiver: _Receiver, seen: VelocitySeen, now_s: float) -> None:
        """Whether a receiver that was found to lie agrees with the estimate again, which has forgotten it meanwhile.
        By the limit of then: dead reckoning that gets worse agrees with anything in the end. All velocities for some
        time: an estimate that had begun to follow a lie is nearer to it, and noise brings one of them near enough."""
        if receiver.since_s is None:
            return
        forgotten = now_s - receiver.found_s >= _FORGOTTEN_S
        if not forgotten or math.hypot(seen.off_north_mps, seen.off_east_mps) >= _AGREES * receiver.limit_mps:
            receiver.agrees_s = math.inf
            return
        receiver.agrees_s = min(receiver.agrees_s, now_s)
        if now_s - receiver.agrees_s >= _AGREES_S:
            receiver.since_s = None

    def _receiver(self, source: str) -> _Receiver:
        found = self._receivers.get(source)
        if found is None:
            found = self._receivers[source] = _Receiver()
        return found

    def _findings(self) -> Sequence[LieFound]:
        found = [
            LieFound(Channel(Sense.VELOCITY, source), "fits no force", receiver.since_s, asks=True)
            for source, receiver in self._receivers.items()
            if receiver.since_s is not None
        ]
        if self._imu is not None:
            fault = "force fits neither fix nor thrust"
            found.append(LieFound(self._imu[0], fault, self._imu[1], lasting=True))
        return found


def _same_way(first: Pair, second: Pair) -> bool:
    """Whether two differences have the same direction."""
    product = first[0] * second[0] + first[1] * second[1]
    return product >= _SAME_WAY * math.hypot(*first) * math.hypot(*second)


def _opposite(first: Pair, second: Pair) -> bool:
    """Whether two differences are each other's opposite."""
    apart = math.hypot(first[0] + second[0], first[1] + second[1])
    return apart <= _ALIKE * max(math.hypot(*first), math.hypot(*second))
