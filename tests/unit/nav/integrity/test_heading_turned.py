"""A heading that is a quarter or half of a turn off, from the start."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from companion.core.frames import body_to_ned, ned_to_body
from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, Sense
from companion.nav.integrity.heading_turned import HeadingTurned
from companion.nav.integrity.imu_reversed import ImuReversed
from tests.unit.nav.integrity.honest_boat import GRAVITY, ROLL_RAD, ROLL_RADPS, Boat, Passage, feed
from tests.unit.nav.integrity.lies import pointed, pushed, swapped

HEADING = Channel(Sense.HEADING, "gnss")
LATEST_S = 8.0


@pytest.mark.parametrize(("off_deg", "told_deg"), [(180.0, 180), (90.0, 90), (-90.0, 90), (165.0, 180)])
def test_the_angle_is_told(off_deg: float, told_deg: int) -> None:
    def lie(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        pointed(evidence, math.radians(off_deg))

    _, finding = Passage(HeadingTurned(), Boat()).go(60.0, lie)[0]
    assert (finding.channel, finding.fault) == (HEADING, f"is off by {told_deg} deg")
    assert finding.loses and finding.asks and finding.lasting


@pytest.mark.parametrize("off_deg", [0.0, 20.0, -30.0])
def test_a_heading_that_is_a_little_off_is_not(off_deg: float) -> None:
    def off(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        pointed(evidence, math.radians(off_deg))

    assert Passage(HeadingTurned(), Boat()).go(120.0, off) == []


def test_no_current_looks_like_one() -> None:
    """A race that sets the boat back at 3 m/s from one moment to the next does it once."""

    def race(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        if age_s > 30.0:
            evidence.velocities = [seen._replace(north_mps=seen.north_mps - 3.0) for seen in evidence.velocities]

    passage = Passage(HeadingTurned(), Boat())
    assert passage.go(120.0, race) == []


class Spinning(Boat):
    """A light boat whose pods spin it at 150 °/s and push it sideways, in a current; after 40 s they stop. Its readings
    are 0.2 s old, and five of them in a second are velocities."""

    STOP_S, SPIN_RADPS, TIMES_S = 40.0, -2.7, (0.6, 2.0)  # time constants of the spin and of the way
    OLD_S = 0.2

    def evidence(self, now_s: float, rng: random.Random) -> Evidence:
        evidence = super().evidence(now_s - self.OLD_S, rng)
        evidence.velocities = [seen for seen in evidence.velocities if round(seen.t_s / 0.05) % 4 == 0]
        return evidence

    def _left(self, t_s: float, time_s: float) -> float:
        return math.exp(-max(t_s - self.STOP_S, 0.0) / time_s)

    def yaw(self, t_s: float) -> float:
        return self.SPIN_RADPS * (min(t_s, self.STOP_S) + self.TIMES_S[0] * (1.0 - self._left(t_s, self.TIMES_S[0])))

    def turn_radps(self, t_s: float) -> float:
        return self.SPIN_RADPS * self._left(t_s, self.TIMES_S[0])

    def _way(self, t_s: float) -> tuple[float, float]:
        left = self._left(t_s, self.TIMES_S[1])
        return -0.22 * left, 0.1 * left

    def velocity(self, t_s: float) -> tuple[float, float]:
        north, east = body_to_ned(*self._way(t_s), self.yaw(t_s))
        return north - 0.1, east + 0.05

    def force(self, t_s: float) -> tuple[float, float]:
        (u, v), r = self._way(t_s), self.turn_radps(t_s)
        slowing = 1.0 / self.TIMES_S[1] if t_s > self.STOP_S else 0.0
        return -slowing * u - r * v, -slowing * v + r * u - GRAVITY * ROLL_RAD * math.sin(ROLL_RADPS * t_s)


@pytest.mark.parametrize("hypothesis", [HeadingTurned(), ImuReversed()])
def test_a_boat_that_stops_spinning_points_where_it_says(hypothesis: Hypothesis) -> None:
    """What it felt in the spin was taken off in the wrong direction afterwards."""
    passage = Passage(hypothesis, Spinning())
    for _ in range(60):
        assert passage.go(1.0, pushed) == [] and hypothesis.doubt < 0.5


@pytest.mark.parametrize("off_deg", [180.0, 90.0, -90.0])
def test_a_boat_that_spins_tells_the_angle_too(off_deg: float) -> None:
    def lie(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        pointed(evidence, math.radians(off_deg))

    passage = Passage(HeadingTurned(), Spinning())
    passage.go(50.0, lie)
    assert passage.hypothesis.doubt >= 0.9


def test_an_inertial_sensor_that_is_turned_is_not_the_headings_fault() -> None:
    """Thrust is against it."""

    def turned(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        evidence.imu = [
            replace(imu, x_mps2=-imu.x_mps2, y_mps2=-imu.y_mps2, roll_rate_radps=-imu.roll_rate_radps)
            for imu in evidence.imu
        ]

    assert Passage(HeadingTurned(), Boat()).go(120.0, turned) == []


class Diagonal(Boat):
    """It goes to and fro towards one bow, where a reversed sideways axis looks like a heading that is 90° off."""

    def velocity(self, t_s: float) -> tuple[float, float]:
        north, _ = super().velocity(t_s)
        return north, -north

    def force(self, t_s: float) -> tuple[float, float]:
        felt_mps2, yaw_rad = 0.27 * math.cos(0.9 * t_s), self.yaw(t_s)
        ahead, starboard = ned_to_body(felt_mps2, -felt_mps2, yaw_rad)
        return ahead, starboard - GRAVITY * ROLL_RAD * math.sin(ROLL_RADPS * t_s)


def test_nor_is_a_sideways_axis_that_is_reversed() -> None:
    """Thrust goes with the other axis. The heading was lost, and the boat neutral."""

    def mirrored(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        evidence.imu = [replace(imu, y_mps2=-imu.y_mps2) for imu in evidence.imu]

    hypothesis = HeadingTurned()
    assert Passage(hypothesis, Diagonal()).go(120.0, mirrored) == []
    assert hypothesis.explains == 0.0


def test_a_sensor_that_lies_tells_nothing_of_the_heading() -> None:
    """It is left out already, and what it felt would have the heading left out, too."""

    def known(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        swapped(evidence, age_s)
        evidence.distrusted = frozenset({Channel(Sense.ACCELEROMETER, "imu")})

    assert Passage(HeadingTurned(), Boat()).go(60.0, known) == []


def test_what_is_clear_needs_less_thrust() -> None:
    """An Otter drove off for three minutes, at full speed, before thrust had agreed by three sigmas."""

    def lie(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        swapped(evidence, age_s)

    assert Passage(HeadingTurned(), Boat()).go(60.0, lie)[0][0] < LATEST_S


def test_without_thrust_nobody_is_blamed() -> None:
    assert Passage(HeadingTurned(), Boat()).go(120.0, swapped) == []


def test_what_a_turned_heading_explains_is_no_reversed_axis() -> None:
    """Two antennas that were swapped had the inertial sensor left out, and the boat drove off."""
    heading, boat = HeadingTurned(), Boat()
    imu, passage = ImuReversed(heading), Passage(heading, boat)

    def both(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        swapped(evidence, age_s)
        evidence.velocities = [
            seen._replace(
                inertial_north_mps=-(seen.inertial_north_mps or 0.0), inertial_east_mps=-(seen.inertial_east_mps or 0.0)
            )
            for seen in evidence.velocities
        ]
        found.extend(finding.fault for finding in feed(imu, evidence, age_s))

    found: list[str] = []
    passage.go(60.0, both)
    assert heading.doubt >= 1.0 and found == []


def test_an_accepted_heading_is_right() -> None:
    passage = Passage(HeadingTurned(), Boat())

    def lie(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        swapped(evidence, age_s)

    assert passage.go(60.0, lie)
    passage.hypothesis.accept(HEADING)
    assert passage.go(1.0, lie) == []
