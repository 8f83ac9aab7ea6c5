"""Absolute time that jumps, or runs at another rate."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.nav.integrity.evidence import Evidence
from companion.nav.integrity.time_wrong import TimeWrong
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil


def ahead(offset_s: float, rate: float = 0.0) -> Spoil:
    def spoil(evidence: Evidence, age_s: float) -> None:
        off_ns = round((offset_s + rate * age_s) * 1e9)
        evidence.times = [replace(time, time_unix_ns=time.time_unix_ns + off_ns) for time in evidence.times]

    return spoil


@pytest.mark.parametrize(
    ("offset_s", "found"), [(0.3, False), (0.6, True), (-1.5, True), (1.0, True), (-60.0, True), (3600.0, True)]
)
def test_jumps(offset_s: float, found: bool) -> None:
    passage = Passage(TimeWrong(), Boat())
    passage.go(5.0)
    findings = passage.go(5.0, ahead(offset_s))
    assert bool(findings) is found
    assert all(finding.fault == f"is off by {offset_s:.1f} s" for _, finding in findings)
    assert passage.go(1.0) == [], "it is over when the time is as it was"


@pytest.mark.parametrize("seconds", [1, 3, 18])
def test_leap_seconds_are_no_lie_once(seconds: int) -> None:
    """A receiver switched on minutes ago gets the almanac: its time was refused for the rest of the voyage, so that the
    wrong one from before stood. A leap second likewise."""
    passage = Passage(TimeWrong(), Boat())
    passage.go(5.0)
    assert passage.go(60.0, ahead(-float(seconds))) == []
    assert passage.go(5.0, ahead(-2.0 * seconds)), "no receiver learns that twice"


@pytest.mark.parametrize(("rate", "found"), [(1e-4, False), (0.02, True)])
def test_rates(rate: float, found: bool) -> None:
    """A crystal that is 100 ppm off, for an hour; and a clock that runs fast."""
    passage = Passage(TimeWrong(), Boat())
    assert bool(passage.go(600.0 if not found else 30.0, ahead(0.0, rate))) is found


def test_the_time_while_disarmed_is_the_one_that_counts() -> None:
    passage = Passage(TimeWrong(), Boat())
    passage.go(5.0)
    assert passage.go(5.0, ahead(60.0), driven=False) == []
    assert passage.go(5.0, ahead(60.0)) == []
