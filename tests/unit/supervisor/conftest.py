"""A lead boat for the tests of following."""

from __future__ import annotations

from typing import Any

import pytest

from tests.unit.following.lead_boat import LeadBoat


@pytest.fixture
def lead(boat: Any) -> LeadBoat:
    return LeadBoat(boat)
