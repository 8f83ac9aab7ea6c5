"""A fast boat points where it goes."""

from __future__ import annotations

import math

import pytest

from companion.core.angles import wrap_pi
from companion.nav.integrity.evidence import Evidence
from companion.nav.integrity.heading_course import HeadingCourse
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil, turned

FAST = Boat(6.0)


@pytest.mark.parametrize(
    ("angle_deg", "found"), [(12.0, False), (40.0, False), (60.0, True), (180.0, True), (-90.0, True)]
)
def test_on_one_course_only_what_no_current_explains_is_found(angle_deg: float, found: bool) -> None:
    passage = Passage(HeadingCourse(), FAST)
    findings = passage.go(20.0, lambda evidence, _: turned(evidence, math.radians(angle_deg)))
    assert bool(findings) is found
    for _, finding in findings:
        assert finding.asks and finding.widens


def under_way(
    speed_mps: float, yaw_rad: float, current: tuple[float, float] = (0.0, 0.0), off_rad: float = 0.0
) -> Spoil:
    """A boat that makes that speed through the water on that heading; `off_rad`: what its compass is off by."""

    def spoil(evidence: Evidence, age_s: float) -> None:
        evidence.north_mps = speed_mps * math.cos(yaw_rad) + current[0]
        evidence.east_mps = speed_mps * math.sin(yaw_rad) + current[1]
        evidence.headings = [seen._replace(yaw_rad=wrap_pi(yaw_rad + off_rad)) for seen in evidence.headings]

    return spoil


@pytest.mark.parametrize("speed_mps", [0.0, 2.0, 4.0, 8.0])
def test_no_boat_in_a_tidal_race_is_told_that_its_compass_lies(speed_mps: float) -> None:
    """It began at 1.7 m/s across the heading."""
    for towards in range(0, 360, 30):
        current = 3.0 * math.cos(math.radians(towards)), 3.0 * math.sin(math.radians(towards))
        passage = Passage(HeadingCourse(), FAST)
        for yaw_deg in (0, 90, 180, 270, 45, 200, 20, 160):
            assert passage.go(12.0, under_way(speed_mps, math.radians(yaw_deg), current)) == []


@pytest.mark.parametrize("off_deg", [25.0, -25.0])
@pytest.mark.parametrize("speed_mps", [4.0, 8.0])
def test_a_compass_that_is_off_is_found_on_the_way_back(off_deg: float, speed_mps: float) -> None:
    passage, off_rad = Passage(HeadingCourse(), FAST), math.radians(off_deg)
    assert passage.go(60.0, under_way(speed_mps, 0.3, off_rad=off_rad)) == []
    assert passage.go(60.0, under_way(speed_mps, 0.3 + 0.5 * math.pi, off_rad=off_rad)) == []
    assert passage.go(9.0, under_way(speed_mps, 0.3 + math.pi, off_rad=off_rad))


def test_a_course_that_agrees_clears_the_compass() -> None:
    passage, off_rad = Passage(HeadingCourse(), FAST), math.radians(25.0)
    assert passage.go(20.0, under_way(4.0, 0.3, off_rad=off_rad)) == []
    assert passage.go(1.0, under_way(4.0, 1.8)) == []
    assert passage.go(20.0, under_way(4.0, 0.3 + math.pi, off_rad=off_rad)) == []


def test_a_tide_later_the_current_is_another() -> None:
    passage = Passage(HeadingCourse(), FAST)
    assert passage.go(20.0, under_way(4.0, 0.3, (0.0, 2.0))) == []
    assert passage.go(1000.0, under_way(2.0, 0.3)) == []
    assert passage.go(20.0, under_way(4.0, 0.3 + math.pi, (0.0, -2.0))) == []


def test_slow_boats_may_go_sideways() -> None:
    assert Passage(HeadingCourse(), Boat(2.0)).go(20.0, lambda evidence, _: turned(evidence, 1.5)) == []


@pytest.mark.parametrize(("angle_deg", "found"), [(180.0, False), (170.0, False), (0.0, False), (120.0, True)])
def test_boats_that_push_astern_may_go_stern_first(angle_deg: float, found: bool) -> None:
    """A RIB that sailed a leg stern first at 3 m/s was told that its compass lies."""

    def astern(evidence: Evidence, age_s: float) -> None:
        evidence.astern = True
        turned(evidence, math.radians(angle_deg))

    assert bool(Passage(HeadingCourse(), FAST).go(20.0, astern)) is found


def test_boats_slip_in_turns() -> None:
    def turning(evidence: Evidence, age_s: float) -> None:
        evidence.turn_radps = 0.2
        turned(evidence, 0.6)

    assert Passage(HeadingCourse(), FAST).go(20.0, turning) == []


def test_boats_that_slide_now_and_then_are_told_of_no_lie() -> None:
    """For a moment at a time, and slowly in between; the second slide came to the end of the eight seconds."""

    def slides(evidence: Evidence, age_s: float) -> None:
        evidence.north_mps = 6.0 if age_s % 60.0 < 1.0 else 1.0
        turned(evidence, 0.7)

    assert Passage(HeadingCourse(), FAST).go(600.0, slides) == []


def test_a_lie_shows_between_turns() -> None:
    def zigzag(evidence: Evidence, age_s: float) -> None:
        evidence.turn_radps = 0.0 if age_s % 10.0 < 4.0 else 0.3
        turned(evidence, 1.0)

    found = Passage(HeadingCourse(), FAST).go(30.0, zigzag)
    assert found and found[0][1].since_s < 1.0


def test_the_deviation_of_a_compass_is_allowed() -> None:
    def compass(evidence: Evidence, age_s: float) -> None:
        evidence.headings = [seen._replace(wander_rad=math.radians(5.0)) for seen in evidence.headings]
        turned(evidence, math.radians(25.0))

    assert Passage(HeadingCourse(), FAST).go(20.0, compass) == []


def test_dead_reckoning_that_has_drifted_is_no_course() -> None:
    """No receiver measures the velocity: it is the estimate that is off, not the compass."""

    def unmeasured(evidence: Evidence, age_s: float) -> None:
        evidence.velocities = []
        turned(evidence, 1.0)

    passage = Passage(HeadingCourse(), FAST)
    assert passage.go(5.0, lambda evidence, _: turned(evidence, 1.0)) == []
    assert passage.go(30.0, unmeasured) == []
    assert passage.go(5.0, lambda evidence, _: turned(evidence, 1.0)) == []
    assert passage.go(5.0, lambda evidence, _: turned(evidence, 1.0))


def test_it_ends_when_heading_and_course_agree() -> None:
    passage = Passage(HeadingCourse(), FAST)
    assert passage.go(10.0, lambda evidence, _: turned(evidence, 1.0))
    assert passage.go(1.0) == []
