"""The Otter's plants turn, swing and stop as its published simulator does."""

import pytest

from docs.generate.manoeuvres import Row, compared, manoeuvres, published

EDITIONS = ("otter_2024", "otter_2023")
FIGURES = tuple(name for made in published()["otter_2024"].values() if isinstance(made, dict) for name in made)


def row_of(edition: str, figure: str) -> Row:
    (row,) = (row for row in compared() if (row.edition, row.figure) == (edition, figure))
    return row


@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("edition", EDITIONS)
def test_its_equations_are_those_of_the_program(edition: str, figure: str) -> None:
    plant = "published" if edition == "otter_2024" else "published_2023"
    assert row_of(edition, figure).ratio(plant) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("edition", ["otter_2024", "mended"])
def test_three_degrees_of_freedom_with_strips_come_within_2_percent(edition: str, figure: str) -> None:
    heels = edition == "otter_2024" and figure == "drift_deg"  # the program's weight pulls to the side as well
    assert row_of(edition, figure).ratio("strips") == pytest.approx(1.0, abs=0.04 if heels else 0.02)


def test_every_figure_of_every_edition_is_compared() -> None:
    rows = [(row.edition, row.figure) for row in compared()]
    assert sorted(rows) == sorted((edition, figure) for edition in (*EDITIONS, "mended") for figure in FIGURES)


def test_a_plant_that_is_off_would_be_seen() -> None:
    assert any(abs(row.ratio("fossen") - 1.0) > 0.2 for row in compared())


def test_the_page_has_every_manoeuvre_and_the_stability_of_the_hulls() -> None:
    text = manoeuvres()
    assert all(word in text for word in ("turning circle", "zig-zag", "deceleration", "`slender`", "`inoue`"))
