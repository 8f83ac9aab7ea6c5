"""Receiver, accelerometers and hull model: the one that differs from both others lies."""

from __future__ import annotations

import pytest

from companion.nav.integrity.evidence import Channel, Evidence, ModelStep, Sense
from companion.nav.integrity.velocity_vote import VelocityVote
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil, sped, with_spare

CALM = Boat(rocking=0.1)


def known() -> Passage:
    passage = Passage(VelocityVote(), CALM)
    assert passage.go(40.0) == []
    return passage


def pulled(mps2: float) -> Spoil:
    return lambda evidence, age_s: sped(evidence, mps2 * age_s)


def pushed(mps2: float) -> Spoil:
    """The accelerometers feel a force that is none."""

    def spoil(evidence: Evidence, age_s: float) -> None:
        step, added = evidence.inertial, mps2 * age_s
        assert step is not None
        now_s = evidence.imu[-1].t_s
        lanes = tuple(
            lane._replace(north_mps=lane.north_mps + mps2 * min(age_s, now_s - lane.from_s)) for lane in step.lanes
        )
        evidence.inertial = step._replace(north_mps=step.north_mps + added, lanes=lanes)
        evidence.velocities = [
            seen._replace(inertial_north_mps=(seen.inertial_north_mps or 0.0) + added) for seen in evidence.velocities
        ]

    return spoil


def off(north_mps: float) -> Spoil:
    """All lanes are that much too fast."""

    def spoil(evidence: Evidence, age_s: float) -> None:
        step = evidence.inertial
        assert step is not None
        lanes = tuple(lane._replace(north_mps=lane.north_mps + north_mps, sigma_mps=0.02) for lane in step.lanes)
        evidence.inertial = step._replace(lanes=lanes)

    return spoil


def moored(evidence: Evidence, age_s: float) -> None:
    """Thrust that goes nowhere: only the model is wrong."""
    assert evidence.model is not None
    evidence.model = ModelStep(1, evidence.model.north_mps + 0.2 * age_s, evidence.model.east_mps, 0.0)


@pytest.mark.parametrize("mps2", [0.05, -0.1])
def test_a_receiver_that_is_pulled_away_is_named(mps2: float) -> None:
    age_s, finding = known().go(10.0, pulled(mps2))[0]
    assert finding.channel == Channel(Sense.VELOCITY, "gnss") and finding.asks
    assert finding.since_s <= 40.0 + age_s


def test_a_receiver_is_named_by_lanes_that_have_followed_a_part_of_it() -> None:
    """The filter has taken more than half of the pull for a tilt."""

    def followed(evidence: Evidence, age_s: float) -> None:
        off(0.06 * age_s)(evidence, age_s)
        sped(evidence, 0.1 * age_s)

    _, finding = known().go(12.0, followed)[0]
    assert finding.channel == Channel(Sense.VELOCITY, "gnss")


@pytest.mark.parametrize(("lane_mps", "named"), [(0.28, False), (0.45, True)])
def test_a_lane_that_is_somewhat_off_is_no_lie(lane_mps: float, named: bool) -> None:
    """As of a filter that had a wrong tilt, after a turn. By its sigma 0.2 m/s would be too much."""

    found = known().go(20.0, off(lane_mps))
    assert [finding.channel.sense for _, finding in found[:1]] == ([Sense.ACCELEROMETER] if named else [])


def test_accelerometers_that_feel_a_force_alone_are_named() -> None:
    _, finding = known().go(20.0, pushed(0.1))[0]
    assert finding.channel == Channel(Sense.ACCELEROMETER, "imu") and finding.lasting


def test_a_spare_that_carries_nothing_is_not_blamed() -> None:
    """Its samples came last in each tick: it was not used any more, and the estimate went on with the one that lied."""

    def beside_a_spare(evidence: Evidence, age_s: float) -> None:
        with_spare(evidence, age_s)
        pushed(0.1)(evidence, age_s)

    _, finding = known().go(20.0, beside_a_spare)[0]
    assert finding.channel == Channel(Sense.ACCELEROMETER, "imu")


def test_without_a_heading_nobody_knows_whether_gyro_or_accelerometers_lie() -> None:
    def unheaded(evidence: Evidence, age_s: float) -> None:
        evidence.headings = []
        pushed(0.1)(evidence, age_s)

    _, finding = known().go(20.0, unheaded)[0]
    assert finding.channel == Channel(Sense.IMU, "imu") and finding.lasting


def test_the_model_is_never_blamed() -> None:
    assert known().go(60.0, moored) == []


def test_a_model_that_never_fits_has_no_vote() -> None:
    def misfit(evidence: Evidence, age_s: float) -> None:
        assert evidence.model is not None
        wrong = 0.6 if int(age_s / 6.0) % 2 else -0.6
        evidence.model = evidence.model._replace(north_mps=evidence.model.north_mps + wrong)
        if age_s > 60.0:
            sped(evidence, 0.01 * (age_s - 60.0))

    assert Passage(VelocityVote(), CALM).go(75.0, misfit) == []


@pytest.mark.parametrize("witness", ["model", "inertial"])
def test_two_witnesses_are_not_enough(witness: str) -> None:
    def alone(evidence: Evidence, age_s: float) -> None:
        setattr(evidence, witness, None)
        pulled(0.1)(evidence, age_s)

    assert known().go(20.0, alone) == []


def test_in_the_first_half_minute_the_model_has_no_vote() -> None:
    assert Passage(VelocityVote(), CALM).go(20.0, pulled(0.1)) == []


def test_it_ends_when_the_receiver_agrees_with_the_estimate() -> None:
    passage = known()
    assert passage.go(10.0, pulled(0.1))
    assert not [age_s for age_s, _ in passage.go(5.0) if age_s > 2.5]


def test_an_estimate_that_had_begun_to_follow_it_does_not_agree_with_it() -> None:
    """It is nearer to the lie than the truth is, and noise brings one velocity in five to it."""
    passage = known()
    assert passage.go(10.0, pulled(0.1))

    def nearer(evidence: Evidence, age_s: float) -> None:
        near = round(20.0 * age_s) % 5 == 0
        evidence.velocities = [seen._replace(off_north_mps=0.0 if near else 0.5) for seen in evidence.velocities[-1:]]

    assert [age_s for age_s, _ in passage.go(8.0, nearer) if age_s > 7.5]


def test_dead_reckoning_that_gets_worse_does_not_agree_with_it() -> None:
    """The lanes that begin without a measurement know less and less."""
    passage = known()
    assert passage.go(12.0, pulled(0.1))

    def adrift(evidence: Evidence, age_s: float) -> None:
        step = evidence.inertial
        assert step is not None
        lanes = tuple(lane._replace(sigma_mps=0.05 * (1.0 + age_s)) for lane in step.lanes)
        evidence.inertial = step._replace(lanes=lanes)
        sped(evidence, 1.2)

    assert passage.go(60.0, adrift)[-1][0] == pytest.approx(60.0)
