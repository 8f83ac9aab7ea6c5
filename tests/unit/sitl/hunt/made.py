"""A boat and sails of hunts in tests: the water near a fence, where wind and a dead thruster take from the margin."""

from __future__ import annotations

import json
from pathlib import Path

from companion.config.vessel import find, load
from sitl.hunt.box import Box
from sitl.hunt.search import fault_names
from sitl.scenarios import SCENARIOS
from sitl.sweep.plan import Run

TALE = "sailed.txt"


class Strong:
    """A `Strength` that holds against 10 m/s, and against 5 m/s without a thruster."""

    top_speed_mps = 1.0

    def current_mps(self, most_mps: float, lost: frozenset[str]) -> float:
        return most_mps

    def wind_mps(self, current_mps: float, lost: frozenset[str]) -> float:
        return 5.0 if lost else 10.0


def box(name: str = "hold", vessel: str = "revolt", faults: bool = True) -> Box:
    return Box(SCENARIOS[name], vessel, load(find(vessel)), Strong(), faults=faults)


def margin_m(run: Run) -> float:
    """Wind takes up to 4 m; a receiver without a fix takes 3 m where the wind is above 3 m/s."""
    wind_mps = float(dict(run.settings).get("wind", "2").partition("@")[0] or 0.0)
    lost = "gnss_lost" in fault_names(run)
    return 5.0 - 0.5 * wind_mps - (3.0 if lost and wind_mps > 3.0 else 0.0)


def sail(marks: Path, run: Run, folder: Path) -> None:
    """As a `Sail`, told in `marks`. Seed 9 in a heavy sea ends in an error of the program."""
    with (marks / TALE).open("a", encoding="utf-8") as tale:
        tale.write(f"{run.command}\n")
    margins = [
        {"name": "fence", "value": margin_m(run), "unit": "m", "scale": 5.0, "at_s": 1.0},
        {"name": "disarmed", "value": 0.02, "unit": "", "scale": 0.02, "at_s": 1.0},
    ]
    result = {"ok": margin_m(run) > 0.0, "error": None, "metrics": {}, "checks": [], "margins": margins}
    (folder / "result.json").write_text(json.dumps(result), encoding="utf-8")
