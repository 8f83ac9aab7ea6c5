"""An axis with the wrong sign: what it adds to the velocity is twice there, the other way."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.imu_reversed import ImuReversed
from tests.unit.nav.integrity.honest_boat import GRAVITY, ROLL_RAD, ROLL_RADPS, Boat, Passage, Spoil
from tests.unit.nav.integrity.lies import reversed_x

ROUGH = Boat()


def reversed_roll(evidence: Evidence, age_s: float) -> None:
    """Roll is felt the other way, so gravity pulls twice to the side."""
    evidence.imu = [replace(imu, roll_rate_radps=-imu.roll_rate_radps) for imu in evidence.imu]
    pulled = 2.0 * GRAVITY * ROLL_RAD / ROLL_RADPS
    evidence.velocities = [
        seen._replace(inertial_east_mps=(seen.inertial_east_mps or 0.0) + pulled * math.cos(ROLL_RADPS * seen.t_s))
        for seen in evidence.velocities
    ]


@pytest.mark.parametrize(("lie", "axis"), [(reversed_x, "x"), (reversed_roll, "roll")])
def test_a_reversed_axis_is_named(lie: Spoil, axis: str) -> None:
    passage = Passage(ImuReversed(), ROUGH)
    assert passage.go(12.0 * math.pi / ROLL_RADPS) == []  # upright then: what was felt before the lie does not stay
    _, finding = passage.go(15.0, lie)[0]
    assert finding.fault == f"{axis} axis reversed" and finding.lasting
    assert passage.go(1.0), "until disarmed"


def test_a_velocity_that_lies_is_not_the_sensors_fault() -> None:
    def spoofed(evidence: Evidence, age_s: float) -> None:
        reversed_x(evidence, age_s)
        evidence.distrusted = frozenset({Channel(Sense.VELOCITY, "gnss")})

    passage = Passage(ImuReversed(), ROUGH)
    passage.go(30.0)
    assert passage.go(20.0, spoofed) == []


def test_a_boat_that_does_not_rock_tells_nothing() -> None:
    still = Boat(rocking=0.0)

    def smooth(evidence: Evidence, age_s: float) -> None:
        evidence.imu = [replace(imu, x_mps2=-0.0, roll_rate_radps=0.0) for imu in evidence.imu]

    assert Passage(ImuReversed(), still).go(60.0, smooth) == []


def test_a_noisier_receiver_is_given_its_noise() -> None:
    """Velocities three times as noisy as the vessel's file says, from the beginning."""

    def noisy(evidence: Evidence, age_s: float) -> None:
        evidence.velocities = [
            seen._replace(
                north_mps=seen.north_mps + 2.0 * seen.off_north_mps, east_mps=seen.east_mps + 2.0 * seen.off_east_mps
            )
            for seen in evidence.velocities
        ]

    assert Passage(ImuReversed(), ROUGH).go(120.0, noisy) == []


def test_nor_is_a_heading_that_lies() -> None:
    """The sums are those of a boat that points elsewhere."""

    def turned(evidence: Evidence, age_s: float) -> None:
        reversed_x(evidence, age_s)
        evidence.distrusted = frozenset({Channel(Sense.HEADING, "gnss")})

    passage = Passage(ImuReversed(), ROUGH)
    passage.go(30.0)
    assert passage.go(20.0, turned) == []
