"""Suggestions for names that do not exist."""

from __future__ import annotations

import pytest

from companion.core.nearest import did_you_mean

KNOWN = ("hold", "mission_square", "lying_senses", "follow")


@pytest.mark.parametrize(
    ("name", "meant"),
    [("hodl", "hold"), ("mission-square", "mission_square"), ("Hold", "hold"), ("lying_sense", "lying_senses")],
)
def test_a_name_with_a_slip(name: str, meant: str) -> None:
    assert did_you_mean(name, KNOWN) == f"; did you mean '{meant}'?"


@pytest.mark.parametrize("name", ["kraken", "", "x"])
def test_nothing_is_made_up(name: str) -> None:
    assert did_you_mean(name, KNOWN) == ""
