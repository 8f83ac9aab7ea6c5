"""What a dead zone leaves of a value."""

from __future__ import annotations

import pytest

from companion.core.dead_zone import beyond_dead_zone


@pytest.mark.parametrize(
    ("value", "left"), [(0.0, 0.0), (0.2, 0.0), (-0.5, 0.0), (0.8, pytest.approx(0.3)), (-2.0, -1.5)]
)
def test_what_is_within_it_counts_as_nothing_and_the_rest_begins_at_its_edge(value: float, left: float) -> None:
    assert beyond_dead_zone(value, 0.5) == left
