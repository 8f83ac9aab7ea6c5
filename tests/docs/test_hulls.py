"""The uncertainties that are stated for a model from dimensions hold for the published hulls."""

import pytest

from docs.generate.hulls import Compared, comparison, hulls

ROWS = list(comparison())


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.hull} {row.name}")
def test_the_stated_factor_covers_the_published_figure(row: Compared) -> None:
    if not row.set_aside:
        assert row.covered, f"off by {row.off:.2f}, stated {row.factor:.2f}"


def test_at_least_five_hulls_are_compared_and_little_is_set_aside() -> None:
    names = {row.hull for row in ROWS}
    assert {"ReVolt", "CyberShip II", "Otter", "Heron", "WAM-V 16", "ÅBOAT"} <= names
    assert sum(bool(row.set_aside) for row in ROWS) <= 3


def test_a_factor_that_is_too_small_would_be_seen() -> None:
    assert any(row.off > 1.3 for row in ROWS if not row.set_aside)


def test_the_page_names_formulae_hulls_and_motors() -> None:
    text = hulls()
    assert "`hull.m22_kg`" in text and "CyberShip II" in text and "`t200`" in text and "set aside" not in text
