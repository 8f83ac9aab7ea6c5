"""The Otter's plants turn, swing and stop as its published simulator does."""

import pytest

from docs.generate.manoeuvres import Row, compared, manoeuvres

ROWS = compared()


def named(row: Row) -> str:
    return f"{row.edition} {row.figure}"


@pytest.mark.parametrize("row", [row for row in ROWS if row.edition != "mended"], ids=named)
def test_its_equations_are_those_of_the_program(row: Row) -> None:
    plant = "published" if row.edition == "otter_2024" else "published_2023"
    assert row.ratio(plant) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("row", [row for row in ROWS if "strips" in row.plants], ids=named)
def test_three_degrees_of_freedom_with_strips_come_within_2_percent(row: Row) -> None:
    heels = row.edition == "otter_2024" and row.figure == "drift_deg"  # the program's weight pulls to the side as well
    assert row.ratio("strips") == pytest.approx(1.0, abs=0.04 if heels else 0.02)


def test_a_plant_that_is_off_would_be_seen() -> None:
    assert any(abs(row.ratio("fossen") - 1.0) > 0.2 for row in ROWS)


def test_the_page_has_every_manoeuvre_and_the_stability_of_the_hulls() -> None:
    text = manoeuvres()
    assert all(word in text for word in ("turning circle", "zig-zag", "deceleration", "`slender`", "`inoue`"))
