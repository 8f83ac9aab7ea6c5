"""Charge of a battery whose board measures voltage and current but does not count."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config import BatteryConfig
from companion.core.types import Battery

_SECONDS_PER_HOUR = 3600.0


class ChargeCounter:
    """`update(battery)` → the same with `remaining` filled in, where the device gives none but a current; as it is otherwise.

    Begins with what the voltage at rest says, V + R·I between that of an empty and of a full battery, and counts the current from there (trapezoids
    over the readings' own times, gaps included), as far as full and empty. Remembers charge, time and current of each source.
    """

    def __init__(self, config: BatteryConfig | None) -> None:
        """Without a configuration nothing is filled in."""
        self._config = config
        self._counts: dict[str, tuple[float, float, float]] = {}  # share, time, current by source

    def update(self, battery: Battery) -> Battery:
        config = self._config
        current_a = battery.current_a
        if config is None or battery.remaining is not None or current_a is None or not math.isfinite(current_a) or not math.isfinite(battery.voltage_v):
            return battery
        before = self._counts.get(battery.source)
        if before is None:
            rest_v = battery.voltage_v + config.resistance_ohm * current_a
            share = (rest_v - config.empty_v) / (config.full_v - config.empty_v)
        else:
            share, last_s, last_a = before
            hours = max(0.0, battery.t_s - last_s) / _SECONDS_PER_HOUR
            share -= 0.5 * (last_a + current_a) * hours / config.capacity_ah
        share = min(1.0, max(0.0, share))
        self._counts[battery.source] = share, battery.t_s, current_a
        return replace(battery, remaining=share)
