"""A position that creeps away from the way that the velocities make."""

from __future__ import annotations

import math
import random

import pytest

from companion.core.readings import FixType
from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.position_drift import PositionDrift
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil, moved, sped

BOAT = Boat()


@pytest.mark.parametrize(("creep_mps", "within_s"), [(2.0, 0.6), (0.5, 1.0), (0.1, 10.0)])
def test_a_creep_is_found_the_sooner_the_faster_it_is(creep_mps: float, within_s: float) -> None:
    passage = Passage(PositionDrift(), BOAT)
    passage.go(30.0)
    age_s, finding = passage.go(within_s, lambda evidence, age_s: moved(evidence, creep_mps * age_s))[0]
    assert finding.asks and not finding.jump
    assert finding.since_s <= 30.0 + age_s


def test_a_creep_within_the_errors_of_an_honest_receiver_is_not_told() -> None:
    passage = Passage(PositionDrift(), BOAT)
    assert passage.go(120.0, lambda evidence, age_s: moved(evidence, 0.04 * age_s)) == []


def test_a_receiver_that_wanders_by_its_accuracy_is_honest() -> None:
    """1.5 m without corrections, within half a minute."""

    def plain(evidence: Evidence, age_s: float) -> None:
        moved(evidence, 1.5 * min(age_s / 30.0, 1.0))
        evidence.positions = [seen._replace(sigma_m=1.5, fix=FixType.FIX_3D) for seen in evidence.positions]

    assert Passage(PositionDrift(), BOAT).go(60.0, plain) == []


def test_a_change_of_the_kind_of_fix_is_no_drift() -> None:
    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)

    def worse(evidence: Evidence, age_s: float) -> None:
        moved(evidence, 0.25)
        evidence.positions = [seen._replace(sigma_m=0.3, fix=FixType.DGPS) for seen in evidence.positions]

    assert passage.go(20.0, worse) == []
    assert passage.go(20.0) == []


def test_an_arm_that_is_guessed_is_no_drift_of_the_receiver() -> None:
    """Without roll, pitch and a good heading the lever arm jumps about, and the fixes with it: not the antenna."""
    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)

    def silent(evidence: Evidence, age_s: float) -> None:
        evidence.positions = [seen._replace(antenna=(seen.north_m, seen.east_m)) for seen in evidence.positions]
        moved(evidence, 0.4 * min(age_s, 0.5) + (0.15 if age_s > 1.5 else 0.0))

    assert passage.go(10.0, silent) == []
    assert passage.go(10.0) == []


def test_a_creep_is_found_without_an_inertial_sensor() -> None:
    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)

    def creeping(evidence: Evidence, age_s: float) -> None:
        moved(evidence, 0.5 * age_s)
        evidence.positions = [seen._replace(antenna=(seen.north_m, seen.east_m)) for seen in evidence.positions]

    assert passage.go(3.0, creeping)


def test_a_jump_is_not_taken_for_a_drift() -> None:
    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)
    assert passage.go(20.0, lambda evidence, _: moved(evidence, 9.0)) == []


def test_it_ends_where_the_position_agrees_with_the_estimate() -> None:
    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)
    assert passage.go(3.0, lambda evidence, age_s: moved(evidence, 0.5 * age_s))
    assert passage.go(10.0)[-1][0] < 5.0


def test_a_noisy_receiver_that_creeps_on_does_not_agree() -> None:
    """By the time that it is found it is not yet far off, and the estimate is not sure."""
    draw = random.Random(4)

    def noisy(evidence: Evidence, age_s: float) -> None:
        evidence.positions = [
            seen._replace(
                north_m=seen.north_m + draw.gauss(0.0, 0.02),
                east_m=seen.east_m + draw.gauss(0.0, 0.02),
                estimate_sigma_m=0.2,
            )
            for seen in evidence.positions
        ]

    def creeping(evidence: Evidence, age_s: float) -> None:
        noisy(evidence, age_s)
        moved(evidence, 0.3 * age_s)

    passage = Passage(PositionDrift(), BOAT)
    assert passage.go(20.0, noisy) == []
    ages_s = [age_s for age_s, _ in passage.go(30.0, creeping)]
    assert ages_s[0] < 3.0
    assert len(ages_s) == round((30.0 - ages_s[0]) * 10.0) + 1, "without a break"


def test_a_creep_of_a_plain_receiver_does_not_agree_either() -> None:
    """It takes a quarter of a minute to tell that it creeps, and as long to tell that it goes on."""

    def plain(evidence: Evidence, _: float) -> None:
        evidence.positions = [
            seen._replace(sigma_m=2.0, estimate_sigma_m=0.5, fix=FixType.FIX_3D) for seen in evidence.positions
        ]

    gone_m, following = 0.0, PositionDrift()

    def creeping(evidence: Evidence, age_s: float) -> None:
        nonlocal gone_m
        plain(evidence, age_s)
        moved(evidence, 0.5 * age_s)
        if following.update(Evidence(), age_s) == []:  # not found: the estimate goes along
            gone_m = 0.5 * age_s
        evidence.positions = [seen._replace(off_north_m=seen.off_north_m - gone_m) for seen in evidence.positions]

    passage = Passage(following, BOAT)
    passage.go(20.0, plain)
    ages_s = [age_s for age_s, _ in passage.go(60.0, creeping)]
    assert 10.0 < ages_s[0] < 20.0
    assert len(ages_s) == round((60.0 - ages_s[0]) * 10.0) + 1, "without a break"
    assert passage.go(45.0, plain)[-1][0] < 40.0, "until it agrees"


def spoofed(distrusted: bool) -> Spoil:
    def spoil(evidence: Evidence, age_s: float) -> None:
        moved(evidence, 0.5 * age_s)
        sped(evidence, 0.5)
        if distrusted:
            evidence.distrusted = frozenset({Channel(Sense.VELOCITY, "gnss")})

    return spoil


def test_a_velocity_that_lies_cannot_excuse_the_position() -> None:
    """Both creep together: as long as the velocity is believed, nothing is seen; then the inertial sensor is asked."""
    believed = Passage(PositionDrift(), BOAT)
    believed.go(30.0)
    assert believed.go(10.0, spoofed(False)) == []
    doubted = Passage(PositionDrift(), BOAT)
    doubted.go(30.0)
    assert doubted.go(2.0, spoofed(True))


def test_without_velocities_it_is_silent() -> None:
    def bare(evidence: Evidence, age_s: float) -> None:
        evidence.velocities = []
        moved(evidence, 0.5 * age_s)

    assert Passage(PositionDrift(), BOAT).go(20.0, bare) == []


def test_gaps_are_not_bridged() -> None:
    passage = Passage(PositionDrift(), BOAT)
    draw = random.Random(3)

    def gaps(evidence: Evidence, age_s: float) -> None:
        if int(age_s) % 3 or draw.random() < 0.5:
            evidence.positions = evidence.velocities = []

    assert passage.go(60.0, gaps) == []


def test_a_pause_in_waves_is_not_bridged() -> None:
    """In a second without the receiver, waves of 0.4 m/s and 2.3 s carry a boat to and fro: the mean of the velocities
    before and after is not its way."""
    passage = Passage(PositionDrift(), BOAT)

    def waves(evidence: Evidence, age_s: float) -> None:
        moved(evidence, 0.15 * math.sin(2.7 * age_s))
        sped(evidence, 0.15 * 2.7 * math.cos(2.7 * age_s))
        if age_s % 7.3 < 1.0:
            evidence.positions = evidence.velocities = []

    assert passage.go(120.0, waves) == []


def test_a_velocity_that_has_just_jumped_is_not_the_positions_fault() -> None:
    """It is suspected from its first moment on, before it has lasted long enough to be found."""

    def suspected(evidence: Evidence, age_s: float) -> None:
        sped(evidence, 1.0)
        evidence.suspected = frozenset({Channel(Sense.VELOCITY, "gnss")})

    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)
    assert passage.go(5.0, suspected) == []


def with_its_velocity(mps: float, found_s: float, moves: float = 1.0) -> Spoil:
    """A receiver whose velocity lies, by wide accuracies, which is found after some seconds. `moves`: the share by
    which its positions go along."""

    def spoil(evidence: Evidence, age_s: float) -> None:
        sped(evidence, mps)
        moved(evidence, moves * mps * age_s)
        evidence.positions = [seen._replace(sigma_m=0.5) for seen in evidence.positions]
        if age_s >= found_s:
            evidence.distrusted = frozenset({Channel(Sense.VELOCITY, "gnss")})

    return spoil


def test_positions_that_go_along_with_a_velocity_that_lies_lie_with_it() -> None:
    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)
    age_s, finding = passage.go(6.0, with_its_velocity(0.3, 4.0))[0]
    assert age_s <= 4.3 and finding.channel == Channel(Sense.POSITION, "gnss") and finding.asks
    assert 20.0 - 5.5 <= finding.since_s <= 20.1, "as far back as the estimate must forget"


def test_positions_beside_a_velocity_that_lies_alone_are_honest() -> None:
    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)
    assert passage.go(14.0, with_its_velocity(0.3, 4.0, moves=0.0)) == []


def test_positions_beside_an_honest_velocity_that_is_blamed_are_honest() -> None:
    passage = Passage(PositionDrift(), BOAT)
    passage.go(20.0)
    assert passage.go(20.0, with_its_velocity(0.0, 4.0)) == []
