"""Positions that scatter by more than the receiver claims."""

from __future__ import annotations

import random

import pytest

from companion.core.readings import FixType
from companion.nav.integrity.accuracy_lie import AccuracyLie
from companion.nav.integrity.evidence import Evidence
from tests.unit.nav.integrity.honest_boat import Boat, Passage, Spoil


def scattered(sigma_m: float, claim_m: float = 0.02, fix: FixType = FixType.RTK_FIXED) -> Spoil:
    draw = random.Random(5)

    def spoil(evidence: Evidence, age_s: float) -> None:
        evidence.positions = [
            seen._replace(
                north_m=seen.north_m + draw.gauss(0.0, sigma_m), east_m=seen.east_m + draw.gauss(0.0, sigma_m),
                sigma_m=claim_m, fix=fix,
            )
            for seen in evidence.positions
        ]  # fmt: skip

    return spoil


def test_what_is_believed_instead() -> None:
    hypothesis = AccuracyLie()
    passage = Passage(hypothesis, Boat())
    passage.go(10.0)
    assert hypothesis.sigma_m("gnss", 0.02) == 0.02
    _, finding = passage.go(20.0, scattered(0.2))[-1]
    assert finding.used
    assert hypothesis.sigma_m("gnss", 0.02) == pytest.approx(0.2, rel=0.4)
    assert hypothesis.sigma_m("gnss", 1.5) == 1.5
    assert hypothesis.sigma_m("spare", 0.02) == 0.02
    assert not [age_s for age_s, _ in passage.go(20.0) if age_s > 15.0]
    assert hypothesis.sigma_m("gnss", 0.02) == 0.02


@pytest.mark.parametrize(("sigma_m", "claim_m"), [(0.04, 0.02), (1.0, 1.5), (2.0, 1.0)])
def test_some_more_than_it_claims_is_honest(sigma_m: float, claim_m: float) -> None:
    assert Passage(AccuracyLie(), Boat()).go(60.0, scattered(sigma_m, claim_m)) == []


def test_another_kind_of_fix_begins_anew() -> None:
    passage = Passage(AccuracyLie(), Boat())
    passage.go(10.0, scattered(1.0, 1.5, FixType.FIX_3D))
    assert passage.go(20.0, scattered(0.0)) == []


def test_one_wild_point_is_no_scatter() -> None:
    def wild(evidence: Evidence, age_s: float) -> None:
        if 10.0 < age_s <= 10.1:
            scattered(50.0)(evidence, age_s)

    assert Passage(AccuracyLie(), Boat()).go(30.0, wild) == []


@pytest.mark.parametrize("from_s", [0.0, 10.0])
def test_every_tenth_position_wild_is_no_scatter_of_the_others(from_s: float) -> None:
    """In waves, with an honest scatter of twice the claim. Each wild position makes two steps."""
    count = 0

    def wild(evidence: Evidence, age_s: float) -> None:
        nonlocal count
        scattered(0.03)(evidence, age_s)
        count += 1
        if age_s >= from_s and count % 10 == 0:
            evidence.positions = [seen._replace(north_m=seen.north_m - 6.0e6) for seen in evidence.positions]

    assert Passage(AccuracyLie(), Boat()).go(60.0, wild) == []
