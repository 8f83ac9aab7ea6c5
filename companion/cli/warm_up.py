"""What a run may come to need and a tick has no time to load is loaded beside it, as soon as it is in sight.

Most boats never need scipy, which takes 30 to 50 MB and most of a second of a small board.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from functools import partial

from companion.core.tick import Tick
from companion.loop import Vessel
from companion.mission.plan import PlanKind
from companion.supervisor.calibration import CalibrationKind

_MANY_ITEMS = 30  # of a fence: from here on it may take a grid to find ways


class WarmUp:
    """A `core.ports.Recorder` that lets the vessel's worker import modules, each once, as soon as something may come
    to need it. Begins with the second tick: the first HEARTBEAT is out by then."""

    def __init__(self, vessel: Vessel) -> None:
        self._worker = vessel.worker
        self._begun = False
        self._waiting: Mapping[str, Callable[[], bool]] = {
            "scipy.sparse.csgraph": partial(_may_need_a_grid, vessel),
            "scipy.optimize": partial(_calibrates_a_compass, vessel),
        }

    def record(self, tick: Tick) -> None:
        """See `Recorder`."""
        if not self._begun:
            self._begun = True
            return
        due = [name for name, needed in self._waiting.items() if needed()]
        for name in due:
            self._worker.submit(partial(importlib.import_module, name))
        if due:
            self._waiting = {name: needed for name, needed in self._waiting.items() if name not in due}

    def close(self) -> None:
        """Nothing is open."""


def _may_need_a_grid(vessel: Vessel) -> bool:
    """Whether there are obstacles or zones, perhaps too many to go round by their corners (`fence.roadmap`)."""
    parts = vessel.supervisor.parts
    many = len(vessel.plans.items(PlanKind.FENCE)) > _MANY_ITEMS
    return many or parts.surroundings.heard or parts.chart.water is not None


def _calibrates_a_compass(vessel: Vessel) -> bool:
    """Whether a fit comes at the end of a calibration (`nav.field_fit`)."""
    state = vessel.supervisor.parts.calibration.state
    return state is not None and state.kind is CalibrationKind.COMPASS
