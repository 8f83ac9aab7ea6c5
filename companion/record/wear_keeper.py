"""Keeps the wear of the thrusters over restarts: written when the boat is disarmed and at the end, never under way."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from companion.allocation.wear import Wear, WearCount
from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.tick import Tick
from companion.record.state_file import StateFile

_S_PER_H = 3600.0
_WORTH_TELLING_S = 60.0  # of thrust since the last time


class WearKeeper:
    """Recorder that counts every tick. Saves, and tells the sum, when the boat is disarmed."""

    def __init__(self, config: VesselConfig, state: StateFile, say: Announce, warn: Callable[[str], None]) -> None:
        kept, warnings = state.load_wear()
        for text in warnings:
            warn(text)
        self._period_s = 1.0 / config.control_rate_hz
        self._state = state
        self._say = say
        self._strangers = {name: row for name, row in kept.items() if name not in {t.name for t in config.thrusters}}
        self._count = WearCount([t.name for t in config.thrusters], {name: wear_of(row) for name, row in kept.items()})
        self._saved = self._count.by_name
        self._armed = False
        self._told_s = self._thrust_s()

    def record(self, tick: Tick) -> None:
        """Count; save once when the boat is disarmed."""
        armed = tick.status.armed
        self._count.update(tick.command, self._period_s)
        if self._armed and not armed:
            self._save()
            if self._thrust_s() - self._told_s >= _WORTH_TELLING_S:
                self._told_s = self._thrust_s()
                self._tell(tick.t_s)
        self._armed = armed

    def close(self) -> None:
        """Save what has been counted since the last time."""
        if self._count.by_name != self._saved:
            self._save()

    def _save(self) -> None:
        self._saved = self._count.by_name
        rows = {name: asdict(wear) for name, wear in self._saved.items()}
        self._state.save_wear({**self._strangers, **rows})

    def _tell(self, now_s: float) -> None:
        wear = self._count.by_name.values()
        hours = self._thrust_s() / _S_PER_H
        starts, reversals = sum(w.starts for w in wear), sum(w.reversals for w in wear)
        self._say(now_s, TextKind.ROUTINE, "wear", f"Thrusters: {hours:.1f} h, {starts} starts, {reversals} reversals")

    def _thrust_s(self) -> float:
        return sum(wear.thrust_s for wear in self._count.by_name.values())


def wear_of(row: Mapping[str, Any]) -> Wear:
    """The wear in a row of the file; what is missing or no number counts as zero."""

    def number(name: str) -> float:
        value = row.get(name)
        if not isinstance(value, int | float) or isinstance(value, bool) or not 0 <= value < math.inf:
            return 0
        return value

    return Wear(number("thrust_s"), int(number("starts")), int(number("reversals")), number("azimuth_turns"))
