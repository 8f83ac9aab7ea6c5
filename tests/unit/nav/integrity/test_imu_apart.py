"""One inertial sensor of three that is not as the others."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.imu_apart import ImuApart
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil
from tests.unit.nav.integrity.lies import turning, two_more


def three(lie: Spoil | None = None) -> Spoil:
    def spoil(evidence: Evidence, age_s: float) -> None:
        two_more(evidence, age_s)
        if lie is not None:
            lie(evidence, age_s)

    return spoil


def pushed(source: str, mps2: float) -> Spoil:
    def spoil(evidence: Evidence, age_s: float) -> None:
        evidence.imu = [replace(imu, y_mps2=imu.y_mps2 + mps2) if imu.source == source else imu for imu in evidence.imu]

    return spoil


@pytest.mark.parametrize("source", ["imu", "imu2", "imu3"])
def test_whichever_it_is_is_found(source: str) -> None:
    passage = Passage(ImuApart(), Boat())
    assert passage.go(20.0, three()) == []
    age_s, found = passage.go(5.0, three(pushed(source, 1.5)))[0]
    assert found.channel == Channel(Sense.ACCELEROMETER, source) and age_s < 1.5 and found.lasting


def test_of_two_neither_is_right() -> None:
    def two(evidence: Evidence, age_s: float) -> None:
        two_more(evidence, age_s)
        evidence.imu = [imu for imu in evidence.imu if imu.source != "imu3"]
        turning(evidence, age_s)

    assert Passage(ImuApart(), Boat()).go(20.0, two) == []


def test_one_that_sits_apart_feels_more_of_a_turn() -> None:
    """Two metres ahead of the others, in a turn of 35 degrees a second: it was not used any more."""

    def spins(evidence: Evidence, age_s: float) -> None:
        turn_radps = 0.6
        evidence.levers_m = {"imu3": (2.0, 0.0, 0.0)}
        evidence.imu = [
            replace(
                imu,
                yaw_rate_radps=turn_radps,
                x_mps2=imu.x_mps2 - (2.0 * turn_radps**2 if imu.source == "imu3" else 0.0),
            )
            for imu in evidence.imu
        ]

    assert Passage(ImuApart(), Boat()).go(60.0, three(spins)) == []


@pytest.mark.parametrize("roll_deg", [10.0, 20.0, 30.0])
def test_one_on_the_mast_feels_more_of_a_roll(roll_deg: float) -> None:
    """A metre above the others, rolling every 3 s: at 20° it was not used any more."""

    def rolls(evidence: Evidence, age_s: float) -> None:
        evidence.levers_m = {"imu3": (0.0, 0.0, -1.0)}
        roll, rate = math.radians(roll_deg), 2.1
        for k, imu in enumerate(evidence.imu):
            swing = roll * rate * math.cos(rate * imu.t_s), -roll * rate**2 * math.sin(rate * imu.t_s)
            evidence.imu[k] = imu = replace(imu, roll_rate_radps=imu.roll_rate_radps + swing[0])
            if imu.source == "imu3":  # α × l, and ω × (ω × l)
                evidence.imu[k] = replace(imu, y_mps2=imu.y_mps2 + swing[1], z_mps2=imu.z_mps2 + imu.roll_rate_radps**2)

    passage = Passage(ImuApart(), Boat())
    assert passage.go(60.0, three(rolls)) == []
    age_s, found = passage.go(5.0, three(lambda e, a: (rolls(e, a), pushed("imu3", 1.5)(e, a))[0]))[0]
    assert found.channel == Channel(Sense.ACCELEROMETER, "imu3") and age_s < 1.5


def test_a_knock_on_one_is_no_lie() -> None:
    """Three tenths of a second, every five seconds."""

    def knock(evidence: Evidence, age_s: float) -> None:
        if age_s % 5.0 < 0.3:
            pushed("imu2", 1.2)(evidence, age_s)

    assert Passage(ImuApart(), Boat()).go(60.0, three(knock)) == []


def test_one_that_is_known_to_lie_has_no_vote() -> None:
    """Of the two that remain neither is right."""

    def second(evidence: Evidence, age_s: float) -> None:
        evidence.distrusted = frozenset({Channel(Sense.IMU, "imu3")})
        turning(evidence, age_s)

    assert Passage(ImuApart(), Boat()).go(20.0, three(second)) == []
