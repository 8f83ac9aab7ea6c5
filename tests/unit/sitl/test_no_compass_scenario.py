"""When the scenario without a compass takes the heading for found."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from sitl.scenarios import no_compass
from sitl.scenarios.ground_station import GroundStation


@pytest.mark.parametrize(
    "text, expected",
    [("Heading source: motion", True), ("Heading source: course over ground", True), ("Heading lost: neutral", False)],
)
def test_a_fast_boat_has_found_its_heading_by_its_course(text: str, expected: bool) -> None:
    """A jet that was pushed steered by its course within a second, and was pushed for two minutes more."""
    gcs = cast(GroundStation, SimpleNamespace(texts=["Armed", text]))
    assert no_compass.found(gcs) is expected
