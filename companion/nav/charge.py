"""State of charge of a battery whose board measures voltage and current but does not count charge."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.outputs import BatteryConfig
from companion.core.readings import Battery

_SECONDS_PER_HOUR = 3600.0


class ChargeCounter:
    """Fills in `remaining` for a device that gives a current but no charge.

    The first share follows from the voltage at rest, V + R·I, between those of an empty and a full battery. From there
    it integrates the current (trapezoids over the times of the readings, gaps included), held within 0…1. Remembers
    share, time and current of each source.
    """

    def __init__(self, config: BatteryConfig | None) -> None:
        """`config` None: readings stay as they are."""
        self._config = config
        self._counts: dict[str, tuple[float, float, float]] = {}  # share, time, current by source

    def update(self, battery: Battery) -> Battery:
        """The reading with `remaining` filled in, or as it is if that is known or cannot be computed."""
        config = self._config
        current_a = battery.current_a
        if config is None or battery.remaining is not None or current_a is None:
            return battery
        if not math.isfinite(current_a) or not math.isfinite(battery.voltage_v):
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
