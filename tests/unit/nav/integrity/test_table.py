"""What holds for every hypothesis of the table: honest sensors are not doubted, a disarmed boat judges nothing."""

from __future__ import annotations

import random

import pytest

from companion.nav.integrity.evidence import Evidence
from companion.nav.integrity.table import Hypotheses
from tests.unit.nav.integrity.honest_boat import Passage, Spoil
from tests.unit.nav.integrity.lies import ROWS, Row

ROW = pytest.mark.parametrize("row", ROWS, ids=[row.name for row in ROWS])
KNOWN_S = 40.0


def lying(row: Row) -> Spoil:
    def spoil(evidence: Evidence, age_s: float) -> None:
        if row.always is not None:
            row.always(evidence, age_s)
        row.lie(evidence, age_s)

    return spoil


def known(row: Row, driven: bool = True) -> Passage:
    """A hypothesis that has seen the boat for a while, and found nothing."""
    passage = Passage(row.make(), row.boat)
    assert passage.go(KNOWN_S, row.always, driven) == []
    return passage


def test_every_hypothesis_has_a_row() -> None:
    assert [row.name for row in ROWS] == [type(hypothesis).__name__ for hypothesis in Hypotheses().all]


@ROW
def test_honest_sensors_are_not_doubted(row: Row) -> None:
    passage = Passage(row.make(), row.boat)
    assert passage.go(120.0, row.always) == []
    assert passage.hypothesis.doubt < 1.0


@ROW
def test_its_lie_is_found_in_time_and_named(row: Row) -> None:
    passage = known(row)
    age_s, finding = passage.go(row.within_s, lying(row))[0]
    assert (finding.channel, finding.fault) == (row.channel, row.fault)
    assert KNOWN_S - 6.5 <= finding.since_s <= KNOWN_S + age_s + 1e-6


@ROW
def test_nothing_is_found_while_not_driven(row: Row) -> None:
    passage = known(row, driven=False)
    assert passage.go(row.within_s + 5.0, lying(row), driven=False) == []


@ROW
def test_clear_begins_anew(row: Row) -> None:
    passage = known(row)
    assert passage.go(row.within_s, lying(row))
    passage.go(0.2, row.always, driven=False)  # the lie has ended, while the boat is disarmed
    passage.hypothesis.clear()
    assert passage.go(20.0, row.always) == []


@ROW
def test_what_is_accepted_is_believed_from_where_it_is(row: Row) -> None:
    passage = known(row)
    finding = passage.go(row.within_s, lying(row))[-1][1]
    passage.hypothesis.accept(row.channel)
    after = passage.hypothesis.update(Evidence(driven=True), passage.now_s)
    assert finding.asks is not any(found.channel == row.channel for found in after)


@ROW
def test_another_source_is_not_accepted_with_it(row: Row) -> None:
    passage = known(row)
    passage.go(row.within_s, lying(row))
    passage.hypothesis.accept(row.channel._replace(source="other"))
    inertial = passage.boat.evidence(passage.now_s, random.Random(1)).inertial
    assert passage.hypothesis.update(Evidence(driven=True, inertial=inertial), passage.now_s)
