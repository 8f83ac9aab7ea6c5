"""The note about weather that is more than a boat holds."""

from __future__ import annotations

import pytest

from companion.cli.held_weather import more_than_it_holds
from companion.config.vessel import find, load


def note(vessel: str, wind: str = "", current: str = "") -> str:
    return more_than_it_holds(load(find(vessel)), {"wind": wind, "current": current, "gnss": "rtk"})


def test_it_names_what_is_too_much_with_the_remedy() -> None:
    assert note("revolt", "6@90/npd", "0.3@45") == (
        "note: wind of 6 m/s, of which it holds 4.7 and current of 0.3 m/s, of which it holds 0.2 "
        "(companion check prints it): try less, --set wind=, --set current="
    )
    assert "current" not in note("revolt", "6")


@pytest.mark.parametrize("vessel", ["aboat", "rescuerunner", "sailbot"])
def test_it_says_nothing_of_weather_that_the_boat_holds(vessel: str) -> None:
    """Of a boat under sail nothing is known."""
    assert note(vessel, "6", "0.3") == ""
    assert note(vessel) == ""
    assert more_than_it_holds(load(find(vessel)), {}) == ""
