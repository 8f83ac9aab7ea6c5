"""Heading against gyro: which of the two has drifted off is told by how that began."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, Sense
from companion.nav.integrity.heading_drift import HeadingDrift
from companion.nav.integrity.imu_reversed import ImuReversed
from companion.nav.integrity.velocity_vote import VelocityVote
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil, sped, turned, with_spare

BOAT = Boat()
HEADING, GYRO = Channel(Sense.HEADING, "gnss"), Channel(Sense.GYRO, "imu")


def known(for_s: float = 30.0) -> Passage:
    passage = Passage(HeadingDrift(), BOAT)
    assert passage.go(for_s) == []
    return passage


@pytest.mark.parametrize(("creep_degps", "within_s"), [(5.0, 1.0), (1.0, 3.0), (0.4, 12.0)])
def test_a_heading_that_creeps_is_blamed(creep_degps: float, within_s: float) -> None:
    found = known().go(within_s, lambda evidence, age_s: turned(evidence, math.radians(creep_degps * age_s)))
    assert found and {finding.channel for _, finding in found} == {HEADING}
    assert found[0][1].asks


def test_a_creep_is_blamed_while_the_receiver_may_be_late() -> None:
    """A creep that a turn makes look like latency: nothing was judged for 10 s, and WAM-V's bow went 10° off."""

    def creeps(evidence: Evidence, age_s: float) -> None:
        evidence.driven, evidence.maybe_late = False, True
        turned(evidence, math.radians(age_s))

    found = known().go(9.0, creeps)
    assert found and {finding.channel for _, finding in found} == {HEADING}


def test_a_creep_as_slow_as_a_gyro_drifts_is_not_told() -> None:
    assert known().go(60.0, lambda evidence, age_s: turned(evidence, math.radians(0.1 * age_s))) == []


@pytest.mark.parametrize("off_deg", [1.0, 1.4, 3.0, 20.0])
def test_a_single_outlier_is_no_drift(off_deg: float) -> None:
    """Just short of the threshold it came on top of what noise had left in the sum."""
    for once_s in (0.5, 1.0, 7.0):
        passage = known()
        assert passage.go(10.0, lambda evidence, age_s, at=once_s: turned(evidence, _once(off_deg, at, age_s))) == []


@pytest.mark.parametrize("off_deg", [-2.2, 2.2])
def test_an_outlier_just_after_the_filter_began_is_no_drift(off_deg: float) -> None:
    """It is the first to be compared; another one follows a second later."""
    passage, began = known(), []

    def anew(evidence: Evidence, age_s: float) -> None:
        assert evidence.inertial is not None
        evidence.inertial = evidence.inertial._replace(run=2)
        if not began and evidence.headings:
            began.append(age_s)
        if began:
            turned(evidence, _once(off_deg, began[0], age_s) + _once(0.5 * off_deg, began[0] + 1.0, age_s))

    assert passage.go(10.0, anew) == []


def _once(off_deg: float, once_s: float, age_s: float) -> float:
    return math.radians(off_deg) if abs(age_s - once_s) < 0.04 else 0.0


def gyro_off(radps: float) -> Spoil:
    """The samples, and what they add up to."""

    def spoil(evidence: Evidence, age_s: float) -> None:
        evidence.imu = [replace(imu, yaw_rate_radps=imu.yaw_rate_radps + radps) for imu in evidence.imu]
        evidence.headings = [
            seen._replace(turned_rad=(seen.turned_rad or 0.0) + radps * age_s) for seen in evidence.headings
        ]

    return spoil


def test_a_gyro_that_steps_is_blamed() -> None:
    _, finding = known().go(4.0, gyro_off(math.radians(3.0)))[0]
    assert (finding.channel, finding.fault, finding.lasting) == (GYRO, "yaw rate is off", True)


def beside_a_spare(evidence: Evidence, age_s: float) -> None:
    gyro_off(math.radians(3.0))(evidence, age_s)
    with_spare(evidence, age_s)
    evidence.imu = [
        replace(imu, yaw_rate_radps=imu.yaw_rate_radps - math.radians(3.0)) if imu.source == "imu2" else imu
        for imu in evidence.imu
    ]


def test_of_two_gyros_the_one_that_carries_the_estimate_is_blamed() -> None:
    """The honest spare was, whose samples came last in each tick."""
    passage = Passage(HeadingDrift(), BOAT)
    assert passage.go(30.0, with_spare) == []
    _, finding = passage.go(4.0, beside_a_spare)[0]
    assert (finding.channel, finding.fault) == (GYRO, "yaw rate is off")


def test_a_heading_that_creeps_is_blamed_after_a_gyro_was() -> None:
    """The spare carries the estimate by then."""

    def by_the_spare(evidence: Evidence, age_s: float) -> None:
        with_spare(evidence, age_s)
        evidence.imu_used = "imu2"

    passage = Passage(HeadingDrift(), BOAT)
    assert passage.go(30.0, with_spare) == [] and passage.go(4.0, beside_a_spare)
    assert {finding.channel for _, finding in passage.go(30.0, by_the_spare)} == {GYRO}

    def creeps(evidence: Evidence, age_s: float) -> None:
        by_the_spare(evidence, age_s)
        turned(evidence, math.radians(age_s))

    assert HEADING in {finding.channel for _, finding in passage.go(4.0, creeps)}


def gyro_reversed() -> Spoil:
    """From its first tick on the turn goes the other way."""
    began: list[float] = []

    def spoil(evidence: Evidence, age_s: float) -> None:
        began.append(evidence.headings[0].turned_rad or 0.0)
        evidence.imu = [replace(imu, yaw_rate_radps=-imu.yaw_rate_radps) for imu in evidence.imu]
        evidence.headings = [
            seen._replace(turned_rad=2.0 * began[0] - (seen.turned_rad or 0.0)) for seen in evidence.headings
        ]

    return spoil


def test_a_gyro_that_turns_the_other_way_is_blamed() -> None:
    """From a moment without turn on: it does not step."""
    passage = known(36.6)
    _, finding = passage.go(20.0, gyro_reversed())[0]
    assert (finding.channel, finding.fault) == (GYRO, "yaw axis reversed")
    assert passage.go(5.0), "only disarming clears a sensor whose axis is wrong"


def unused(spoil: Spoil) -> Spoil:
    """As `spoil`; no thrust tells who turns, and from 10 s on the heading is not used."""

    def spoiled(evidence: Evidence, age_s: float) -> None:
        spoil(evidence, age_s)
        evidence.model = None
        evidence.distrusted = frozenset({HEADING} if age_s > 10.0 else ())

    return spoiled


def test_a_heading_that_goes_on_to_turn_against_the_gyro_while_it_is_not_used_was_right() -> None:
    """In a calm nothing told them apart: the compass was blamed, and the boat was 64° off after half a minute."""
    found = known(36.6).go(40.0, unused(gyro_reversed()))
    assert found[0][1].channel == HEADING
    assert (found[-1][1].channel, found[-1][1].fault) == (GYRO, "yaw axis reversed")


def test_a_heading_that_creeps_on_while_it_is_not_used_stays_blamed() -> None:
    found = known().go(60.0, unused(lambda evidence, age_s: turned(evidence, math.radians(1.0 * age_s))))
    assert {finding.channel for _, finding in found} == {HEADING}


def test_without_a_gyro_it_is_silent() -> None:
    def bare(evidence: Evidence, age_s: float) -> None:
        evidence.headings = [seen._replace(turned_rad=None) for seen in evidence.headings]
        turned(evidence, math.radians(age_s))

    assert Passage(HeadingDrift(), BOAT).go(20.0, bare) == []


def test_the_wander_of_a_compass_is_allowed() -> None:
    """3° of deviation that change as the boat turns."""

    def compass(evidence: Evidence, age_s: float) -> None:
        evidence.headings = [seen._replace(wander_rad=math.radians(3.0)) for seen in evidence.headings]
        turned(evidence, math.radians(3.0) * math.sin(0.1 * age_s))

    assert Passage(HeadingDrift(), BOAT).go(120.0, compass) == []


COMPASS_RAD = math.radians(1.5)


def compass(evidence: Evidence) -> None:
    evidence.headings = [seen._replace(wander_rad=COMPASS_RAD) for seen in evidence.headings]


def test_a_compass_that_creeps_is_found_long_before_it_is_10_degrees_off() -> None:
    passage = Passage(HeadingDrift(), BOAT)
    assert passage.go(30.0, lambda evidence, _: compass(evidence)) == []

    def creeps(evidence: Evidence, age_s: float) -> None:
        compass(evidence)
        turned(evidence, math.radians(age_s))

    assert passage.go(6.0, creeps)


class TurningBoat(Boat):
    """Turns by 45° to either side."""

    def yaw(self, t_s: float) -> float:
        return 0.8 * math.sin(0.2 * t_s)

    def turn_radps(self, t_s: float) -> float:
        return 0.16 * math.cos(0.2 * t_s)


@pytest.mark.parametrize("orders", [1, 2])
def test_a_compass_may_deviate_with_the_heading(orders: int) -> None:
    """Iron aboard: by twice its slow error once in a turn, or by as much twice."""

    def deviates(evidence: Evidence, age_s: float) -> None:
        compass(evidence)
        turned(evidence, COMPASS_RAD * 2.0 / orders * math.sin(orders * evidence.velocities[-1].yaw_rad))

    assert Passage(HeadingDrift(), TurningBoat()).go(120.0, deviates) == []


def test_it_ends_when_the_heading_is_steady_where_the_estimate_is() -> None:
    passage = known()
    assert passage.go(3.0, lambda evidence, age_s: turned(evidence, math.radians(age_s)))
    assert passage.go(20.0)[-1][0] < 8.0


def test_a_filter_that_begins_anew_is_no_drift() -> None:
    passage = known()

    def anew(evidence: Evidence, age_s: float) -> None:
        assert evidence.inertial is not None
        evidence.inertial = evidence.inertial._replace(run=2)
        evidence.headings = [seen._replace(turned_rad=(seen.turned_rad or 0.0) + 1.0) for seen in evidence.headings]

    assert passage.go(20.0, anew) == []


@pytest.mark.parametrize("hypothesis", [HeadingDrift, VelocityVote, ImuReversed])
def test_a_filter_that_has_not_settled_tells_nothing(hypothesis: Callable[[], Hypothesis]) -> None:
    """It began in a hard turn, so its sums are wrong: heading, velocity and sensor are not to blame."""

    def unsettled(evidence: Evidence, age_s: float) -> None:
        assert evidence.inertial is not None
        evidence.inertial = evidence.inertial._replace(turn_sigma_radps=math.radians(0.2))
        turned(evidence, math.radians(age_s))
        sped(evidence, 0.1 * age_s)

    passage = Passage(hypothesis(), BOAT)
    passage.go(30.0)
    assert passage.go(20.0, unsettled) == []


class CorneringBoat(Boat):
    """Turns by 60° every ten seconds, at up to 30°/s, as a catamaran does at a waypoint."""

    def yaw(self, t_s: float) -> float:
        corners, after_s = divmod(t_s, 10.0)
        share = min(after_s / 4.0, 1.0)
        return math.radians(60.0) * (corners + share - math.sin(2.0 * math.pi * share) / (2.0 * math.pi))

    def turn_radps(self, t_s: float) -> float:
        share = min((t_s % 10.0) / 4.0, 1.0)
        return math.radians(15.0) * (1.0 - math.cos(2.0 * math.pi * share))


def cornered(for_s: float, then: Spoil | None = None, doubted: bool = False) -> list[Channel]:
    """Whom a late heading has blamed for some time; or, with a lie that begins then, in the next 9 s. `doubted`: the
    receiver's times are in doubt."""
    boat = CorneringBoat()
    passage = Passage(HeadingDrift(), boat)

    def late(evidence: Evidence, age_s: float) -> None:
        evidence.driven, evidence.maybe_late = not doubted, doubted
        evidence.headings = [
            seen._replace(yaw_rad=seen.yaw_rad - boat.yaw(seen.t_s) + boat.yaw(seen.t_s - 0.3))
            for seen in evidence.headings
        ]

    def lying(evidence: Evidence, age_s: float) -> None:
        late(evidence, age_s)
        assert then is not None
        then(evidence, age_s)

    found = passage.go(for_s, late)
    return [finding.channel for _, finding in (found if then is None else passage.go(9.0, lying))]


@pytest.mark.parametrize("doubted", [False, True])
def test_what_a_late_heading_makes_of_a_turn_is_blamed_on_nobody(doubted: bool) -> None:
    """It lags by 9° and comes back: once the gyro was blamed for that, for good, and the heading was 20° off."""
    assert cornered(60.0, doubted=doubted) == []


@pytest.mark.parametrize(
    ("from_s", "spoil", "channel"),
    [
        (32.0, lambda evidence, age_s: turned(evidence, math.radians(2.0 * age_s)), HEADING),
        (35.0, gyro_off(math.radians(5.0)), GYRO),
    ],
)
def test_a_late_receiver_hides_no_lie(from_s: float, spoil: Spoil, channel: Channel) -> None:
    assert cornered(from_s, spoil)[0] == channel


class StandingBoat(Boat):
    """Does not turn."""

    def yaw(self, t_s: float) -> float:
        return 0.0

    def turn_radps(self, t_s: float) -> float:
        return 0.0


def test_a_compass_that_creeps_is_blamed_where_waves_turn_a_boat_whose_thrusters_rest() -> None:
    """The boat follows it with a third of its rate, so that both turn opposite ways, and waves happen to turn the boat
    against the little that the model feels: once the gyro was thought to be reversed, and the heading was 60° off."""
    passage = Passage(HeadingDrift(), StandingBoat())
    assert passage.go(30.0) == []

    def creeps(evidence: Evidence, age_s: float) -> None:
        wave = math.sin(5.0 * age_s)
        gyro_off(math.radians(-0.33))(evidence, age_s)
        evidence.imu = [
            replace(imu, yaw_rate_radps=imu.yaw_rate_radps + math.radians(0.5) * wave) for imu in evidence.imu
        ]
        turned(evidence, math.radians(0.67 * age_s))
        assert evidence.model is not None
        evidence.model = evidence.model._replace(turn_radps=-math.radians(0.02) * wave)

    found = passage.go(8.0, creeps)
    assert found and {finding.channel for _, finding in found} == {HEADING}
