"""Keeps where the mission stands, so that a restart in mid-mission can go on."""

from __future__ import annotations

from collections.abc import Callable

from companion.core.types import MissionProgress, Tick
from companion.mission.executor import MissionExecutor
from companion.record.state_file import StateFile


class ProgressKeeper:
    """Recorder that saves the executor's snapshot whenever the progress has changed. Restores it when it is made."""

    def __init__(self, executor: MissionExecutor, state: StateFile, on_warning: Callable[[str], None]) -> None:
        self._executor = executor
        self._state = state
        kept, warnings = state.load_progress()
        for text in warnings:
            on_warning(text)
        if kept and (refusal := executor.restore(kept)) is not None:
            on_warning(f"mission progress not taken over: {refusal}")
        self._saved: MissionProgress = executor.progress

    def record(self, tick: Tick) -> None:
        if tick.status.mission != self._saved:
            self._saved = tick.status.mission
            self._state.save_progress(self._executor.snapshot())

    def close(self) -> None:
        self._state.save_progress(self._executor.snapshot())
