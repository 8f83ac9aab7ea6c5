"""Saves mission progress and home, so that the boat can resume after a restart in mid-mission."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from companion.core.decision import Home, MissionProgress, MissionState
from companion.core.storing import Ticket, durable
from companion.core.tick import Tick
from companion.mission.executor import MissionExecutor
from companion.record.state_file import StateFile
from companion.supervisor.homing import is_on_earth
from companion.supervisor.supervisor import Supervisor

_INTERRUPTED = (MissionState.ACTIVE, MissionState.PAUSED)


class ProgressKeeper:
    """Recorder that saves the executor's snapshot and home when either changes. Restores both when it is created.
    `save` does so at once.

    Home is restored only with an interrupted mission: after any other start, home is where the boat is.
    """

    def __init__(
        self, executor: MissionExecutor, supervisor: Supervisor, state: StateFile, on_warning: Callable[[str], None]
    ) -> None:
        self._executor = executor
        self._supervisor = supervisor
        self._state = state
        self._ticket = durable()
        kept, warnings = state.load_progress()
        for text in warnings:
            on_warning(text)
        mission = kept.get("mission")
        if isinstance(mission, Mapping):
            if (refusal := executor.restore(mission)) is not None:
                on_warning(f"mission progress refused: {refusal}")
            elif executor.progress.state in _INTERRUPTED and (home := _home_of(kept.get("home"))) is not None:
                supervisor.set_home(home, 0.0)
        self._saved: tuple[MissionProgress, Home | None] = executor.progress, None

    def record(self, tick: Tick) -> None:
        """Save if progress or home changed with this tick."""
        self._keep(tick.status.mission, tick.status.home)

    def save(self) -> Ticket:
        """Save if progress or home has changed; the ticket of the newest."""
        self._keep(self._executor.progress, self._supervisor.parts.home.home)
        return self._ticket

    def _keep(self, progress: MissionProgress, home: Home | None) -> None:
        if (progress, home) != self._saved:
            self._saved = progress, home
            place = None if home is None else [home.lat_deg, home.lon_deg, home.altitude_m]
            self._ticket = self._state.save_progress({"mission": self._executor.snapshot(), "home": place})

    def close(self) -> None:
        """Nothing to do: every change is already saved."""


def _home_of(kept: Any) -> Home | None:
    """The home in a state file; None where it is invalid."""
    if not isinstance(kept, list) or len(kept) != 3 or not all(isinstance(value, (int, float)) for value in kept):
        return None
    lat_deg, lon_deg, altitude_m = map(float, kept)
    return Home(lat_deg, lon_deg, altitude_m) if is_on_earth(lat_deg, lon_deg) else None
