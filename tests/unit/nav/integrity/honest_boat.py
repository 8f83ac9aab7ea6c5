"""A boat that rocks and turns a little, in closed form, what its honest sensors say of it, and how to spoil that."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace

from companion.core.readings import FixType, Imu, MagneticField, TimeOfDay, Wind
from companion.nav.integrity.evidence import (
    Evidence,
    HeadingSeen,
    Hypothesis,
    InertialStep,
    InertialWay,
    LaneStep,
    LieFound,
    ModelStep,
    PositionSeen,
    VelocitySeen,
)
from companion.nav.integrity.heading_jump import HeadingJump
from companion.nav.integrity.position_jump import PositionJump
from companion.nav.integrity.velocity_jump import VelocityJump
from tests.unit.nav.integrity.seen import METRE_DEG, TICK_S

GRAVITY = 9.81
ROLL_RAD, ROLL_RADPS = 0.03, 1.3  # amplitude and angular frequency
LANE_EVERY_S = 6.0


@dataclass(frozen=True)
class Boat:
    """Makes `ahead_mps` to the north; rocks around that, as much as `rocking` says."""

    ahead_mps: float = 0.0
    rocking: float = 1.0
    seed: int = 1

    def velocity(self, t_s: float) -> tuple[float, float]:
        rocking = self.rocking
        return self.ahead_mps + rocking * 0.3 * math.sin(0.9 * t_s), rocking * 0.3 * math.sin(0.7 * t_s)

    def place(self, t_s: float) -> tuple[float, float]:
        rocking = self.rocking
        return (
            self.ahead_mps * t_s + rocking * 0.3 / 0.9 * (1.0 - math.cos(0.9 * t_s)),
            rocking * 0.3 / 0.7 * (1.0 - math.cos(0.7 * t_s)),
        )

    def yaw(self, t_s: float) -> float:
        return 0.1 * math.sin(0.3 * t_s)

    def turn_radps(self, t_s: float) -> float:
        return 0.03 * math.cos(0.3 * t_s)

    def force(self, t_s: float) -> tuple[float, float]:
        """Specific force ahead and to starboard."""
        north, east = self.rocking * 0.27 * math.cos(0.9 * t_s), self.rocking * 0.21 * math.cos(0.7 * t_s)
        c, s = math.cos(self.yaw(t_s)), math.sin(self.yaw(t_s))
        return c * north + s * east, c * east - s * north - GRAVITY * ROLL_RAD * math.sin(ROLL_RADPS * t_s)

    def evidence(self, now_s: float, rng: random.Random) -> Evidence:
        """A tick: fixes, velocities, headings at 20 Hz, inertial samples at 100 Hz, the rest at 10 Hz."""
        north_mps, east_mps = self.velocity(now_s)
        evidence = Evidence(
            driven=True, turn_radps=self.turn_radps(now_s),
            north_mps=north_mps, east_mps=east_mps, model=ModelStep(1, north_mps, east_mps, self.turn_radps(now_s)),
            inertial=InertialStep(1, north_mps, east_mps, self.yaw(now_s), math.radians(0.01), self.lanes(now_s)),
        )  # fmt: skip
        for t_s in (now_s - 0.05, now_s):
            self._receiver(evidence, t_s, rng)
        for i in range(10):
            evidence.imu.append(self._sample(now_s - 0.09 + 0.01 * i, rng))
        evidence.raw_imu = list(evidence.imu)
        evidence.fields.append(MagneticField(now_s, "imu", rng.gauss(0.2, 0.01), 0.0, 0.4))
        evidence.winds.append(Wind(now_s, "wind", 3.0 + abs(rng.gauss(0.0, 0.3)), 1.0))
        evidence.times.append(TimeOfDay(now_s, "gnss", round((1.7e9 + now_s) * 1e9)))
        return evidence

    def _receiver(self, evidence: Evidence, t_s: float, rng: random.Random) -> None:
        (vn, ve), (n, e), yaw = self.velocity(t_s), self.place(t_s), self.yaw(t_s)
        dn, de = rng.gauss(0.0, 0.005), rng.gauss(0.0, 0.005)
        lat, lon = 60.0 + (n + dn) * METRE_DEG, 10.0 + (e + de) * METRE_DEG / math.cos(math.radians(60.0))
        evidence.positions.append(
            PositionSeen(
                t_s,
                "gnss",
                lat,
                lon,
                n + dn,
                e + de,
                dn,
                de,
                vn,
                ve,
                0.01,
                0.02,
                FixType.RTK_FIXED,
                InertialWay(n, e, 0.0, 0.0),
            )
        )
        dn, de = rng.gauss(0.0, 0.02), rng.gauss(0.0, 0.02)
        evidence.velocities.append(
            VelocitySeen(t_s, "gnss", (vn + dn, ve + de), vn + dn, ve + de, dn, de, vn, ve, 0.03, yaw)
        )
        off = rng.gauss(0.0, 0.003)
        evidence.headings.append(HeadingSeen(t_s, "gnss", yaw + off, yaw + off, off, 0.007, 0.0017, yaw))

    def _sample(self, t_s: float, rng: random.Random) -> Imu:
        ahead, starboard = self.force(t_s)
        roll_radps = ROLL_RAD * ROLL_RADPS * math.cos(ROLL_RADPS * t_s)
        truth = (ahead, starboard, -GRAVITY, roll_radps, 0.0, self.turn_radps(t_s))
        noise = (0.01, 0.01, 0.01, 0.0017, 0.0017, 0.0017)
        return Imu(t_s, "imu", *(value + rng.gauss(0.0, sigma) for value, sigma in zip(truth, noise, strict=True)))

    def lanes(self, now_s: float) -> tuple[LaneStep, ...]:
        """Dead reckoning without an error, from the last two times that one begins."""
        newest = math.floor(now_s / LANE_EVERY_S) * LANE_EVERY_S
        begun = [from_s for from_s in (newest - LANE_EVERY_S, newest) if from_s >= 0.0]
        return tuple(LaneStep(from_s, *self.velocity(from_s), *self.velocity(now_s), 0.005) for from_s in begun)


Spoil = Callable[[Evidence, float], None]
"""Changes the evidence of a tick; the other argument is the time since the lie began."""


def moved(evidence: Evidence, north_m: float, source: str = "gnss") -> None:
    """The positions lie that far to the north."""
    evidence.positions = [
        seen._replace(
            lat_deg=seen.lat_deg + north_m * METRE_DEG,
            north_m=seen.north_m + north_m,
            off_north_m=seen.off_north_m + north_m,
        )
        if seen.source == source
        else seen
        for seen in evidence.positions
    ]


def sped(evidence: Evidence, north_mps: float) -> None:
    """The velocities are that much too fast to the north."""
    evidence.velocities = [
        seen._replace(
            raw=(seen.raw[0] + north_mps, seen.raw[1]),
            north_mps=seen.north_mps + north_mps,
            off_north_mps=seen.off_north_mps + north_mps,
        )
        for seen in evidence.velocities
    ]


def turned(evidence: Evidence, angle_rad: float) -> None:
    """The headings are turned by that much."""
    evidence.headings = [
        seen._replace(raw=seen.raw + angle_rad, yaw_rad=seen.yaw_rad + angle_rad, off_rad=seen.off_rad + angle_rad)
        for seen in evidence.headings
    ]


def another(evidence: Evidence, north_m: float, source: str = "spare") -> None:
    """A second receiver, as accurate, whose positions are that far to the north of the first one's."""
    evidence.positions += [
        seen._replace(
            source=source,
            lat_deg=seen.lat_deg + (north_m + 0.003) * METRE_DEG,
            north_m=seen.north_m + north_m + 0.003,
            off_north_m=seen.off_north_m + north_m + 0.003,
        )
        for seen in evidence.positions
        if seen.source == "gnss"
    ]


def with_spare(evidence: Evidence, age_s: float) -> None:
    """A second inertial sensor, with a bias of its own, speaks after the one that carries the estimate."""
    evidence.imu_used = "imu"
    evidence.imu += [
        replace(imu, t_s=imu.t_s + 0.003, source="imu2", yaw_rate_radps=imu.yaw_rate_radps + 0.003)
        for imu in evidence.imu
    ]
    evidence.imu.sort(key=lambda imu: imu.t_s)


def feed(hypothesis: Hypothesis, evidence: Evidence, now_s: float) -> list[LieFound]:
    """As the monitor does: each reading is screened first where the hypothesis screens it."""
    if isinstance(hypothesis, PositionJump):
        for position in evidence.positions:
            hypothesis.screen(position, evidence.driven)
    elif isinstance(hypothesis, VelocityJump):
        for velocity in evidence.velocities:
            hypothesis.screen(velocity, evidence.driven)
    elif isinstance(hypothesis, HeadingJump):
        for heading in evidence.headings:
            hypothesis.screen(heading, evidence.driven)
    return list(hypothesis.update(evidence, now_s))


@dataclass
class Passage:
    """The same boat on and on; what a hypothesis finds at each tick."""

    hypothesis: Hypothesis
    boat: Boat
    now_s: float = 0.0
    rng: random.Random | None = None

    def go(self, seconds: float, spoil: Spoil | None = None, driven: bool = True) -> list[tuple[float, LieFound]]:
        """Sail on, lied to by `spoil` from the first tick; (time since then, finding) of each."""
        self.rng = self.rng or random.Random(self.boat.seed)
        found, from_s = [], self.now_s
        for _ in range(round(seconds / TICK_S)):
            self.now_s += TICK_S
            evidence = self.boat.evidence(self.now_s, self.rng)
            evidence.driven = driven
            if spoil is not None:
                spoil(evidence, self.now_s - from_s)
            found += [(self.now_s - from_s, finding) for finding in feed(self.hypothesis, evidence, self.now_s)]
        return found
