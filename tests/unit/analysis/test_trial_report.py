"""The boat as the report of a trial takes it, before and after. `test_trial_identify` has the page."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from companion.analysis.trial_report import after
from companion.config.vessel import find, load


def test_the_boat_after_a_trial_has_the_wind_areas_and_limits_that_were_found() -> None:
    """The wind that it holds against was that of the areas before."""
    config = load(find("otter"))
    overlay = "[windage]\nfrontal_m2 = 0.9\n[limits]\nsurge_n = 100.0\nsway_n = 0.0\nyaw_nm = 20.0\n"
    fit = SimpleNamespace(hull=config.hull, thrusters=config.thrusters)
    found: Any = SimpleNamespace(log=SimpleNamespace(config=config), overlay=overlay, better=True, fit=fit)
    now = after(found)
    assert (now.windage.frontal_m2, now.windage.lateral_m2) == (0.9, config.windage.lateral_m2)
    assert now.limits.surge_n == 100.0
