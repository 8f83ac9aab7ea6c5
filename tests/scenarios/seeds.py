"""Which seeds a scenario is sailed with: a few in `make test`, the others in `make scenarios`."""

from __future__ import annotations

from typing import Any

import pytest


def seeds(quick: int, every: int) -> list[Any]:
    """0 … every − 1, those from `quick` on marked as a sweep."""
    return [*range(quick), *(pytest.param(seed, marks=pytest.mark.sweep) for seed in range(quick, every))]
