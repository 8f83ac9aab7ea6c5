"""A heading that is a quarter or half of a turn off, from the start."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.heading_turned import HeadingTurned
from companion.nav.integrity.imu_reversed import ImuReversed
from tests.unit.nav.integrity.honest_boat import Boat, Passage, feed
from tests.unit.nav.integrity.lies import pushed, swapped

HEADING = Channel(Sense.HEADING, "gnss")


@pytest.mark.parametrize(("off_deg", "told_deg"), [(180.0, 180), (90.0, 90), (-90.0, 90), (165.0, 180)])
def test_the_angle_is_told(off_deg: float, told_deg: int) -> None:
    def lie(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        evidence.yaw_rad += math.radians(off_deg)

    _, finding = Passage(HeadingTurned(), Boat()).go(60.0, lie)[0]
    assert (finding.channel, finding.fault) == (HEADING, f"is off by {told_deg} deg")
    assert finding.loses and finding.asks and finding.lasting


@pytest.mark.parametrize("off_deg", [0.0, 20.0, -30.0])
def test_a_heading_that_is_a_little_off_is_not(off_deg: float) -> None:
    def off(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        evidence.yaw_rad += math.radians(off_deg)

    assert Passage(HeadingTurned(), Boat()).go(120.0, off) == []


def test_no_current_looks_like_one() -> None:
    """A race that sets the boat back at 3 m/s from one moment to the next does it once."""

    def race(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        if age_s > 30.0:
            evidence.velocities = [seen._replace(north_mps=seen.north_mps - 3.0) for seen in evidence.velocities]

    passage = Passage(HeadingTurned(), Boat())
    assert passage.go(120.0, race) == []


def test_an_inertial_sensor_that_is_turned_is_not_the_headings_fault() -> None:
    """Thrust is against it."""

    def turned(evidence: Evidence, age_s: float) -> None:
        pushed(evidence, age_s)
        evidence.imu = [
            replace(imu, x_mps2=-imu.x_mps2, y_mps2=-imu.y_mps2, roll_rate_radps=-imu.roll_rate_radps)
            for imu in evidence.imu
        ]

    assert Passage(HeadingTurned(), Boat()).go(120.0, turned) == []


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
