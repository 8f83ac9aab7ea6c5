"""Two receivers that contradict each other."""

from __future__ import annotations

import pytest

from companion.core.readings import FixType
from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.receivers_apart import ReceiversApart
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil, another

SPARE = Channel(Sense.POSITION, "spare")


def apart(distance_m: float, claims: tuple[float, float] = (0.02, 0.02)) -> Spoil:
    def spoil(evidence: Evidence, age_s: float) -> None:
        another(evidence, distance_m)
        evidence.positions = [seen._replace(sigma_m=claims[seen.source == "spare"]) for seen in evidence.positions]

    return spoil


def test_both_are_used_on_by_their_distance() -> None:
    hypothesis = ReceiversApart()
    passage = Passage(hypothesis, Boat())
    assert passage.go(2.5, apart(8.0)) == []
    _, finding = passage.go(2.0, apart(8.0))[0]
    assert finding.channel == SPARE and finding.used
    assert hypothesis.sigma_m("gnss", 0.02) == hypothesis.sigma_m("spare", 0.02) == pytest.approx(8.0, abs=0.1)
    assert hypothesis.sigma_m("third", 0.02) == 0.02
    passage.go(1.0, apart(12.0))
    assert hypothesis.sigma_m("gnss", 0.02) == pytest.approx(12.0, abs=0.1), "the distance as it is now"
    assert passage.go(1.0, apart(0.0)) == []


def test_the_one_that_claims_less_is_named_and_stays_named() -> None:
    passage = Passage(ReceiversApart(), Boat())
    found = passage.go(6.0, apart(8.0, claims=(0.6, 0.02)))
    found += passage.go(6.0, apart(8.0, claims=(0.02, 0.6)))
    assert {finding.channel.source for _, finding in found} == {"gnss"}
    assert found[0][1].fault == "is 8 m from spare"


@pytest.mark.parametrize(("distance_m", "claims"), [(0.4, (0.02, 0.02)), (6.0, (1.5, 1.5)), (4.0, (0.02, 1.5))])
def test_what_they_claim_is_allowed(distance_m: float, claims: tuple[float, float]) -> None:
    assert Passage(ReceiversApart(), Boat()).go(20.0, apart(distance_m, claims)) == []


def test_a_receiver_that_is_not_used_contradicts_nobody() -> None:
    def doubted(evidence: Evidence, age_s: float) -> None:
        apart(8.0)(evidence, age_s)
        evidence.distrusted = frozenset({SPARE})

    assert Passage(ReceiversApart(), Boat()).go(10.0, doubted) == []


def test_nor_does_one_without_a_fix() -> None:
    def searching(evidence: Evidence, age_s: float) -> None:
        apart(8.0)(evidence, age_s)
        evidence.positions = [
            seen._replace(fix=FixType.NONE) if seen.source == "spare" else seen for seen in evidence.positions
        ]

    assert Passage(ReceiversApart(), Boat()).go(10.0, searching) == []


def test_one_that_falls_silent_is_forgotten() -> None:
    passage = Passage(ReceiversApart(), Boat())
    assert passage.go(6.0, apart(8.0))
    assert not [age_s for age_s, _ in passage.go(5.0) if age_s > 2.0]
