"""Which device's measurement of the battery counts (BAT1_SOURCE), and how full the battery is."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.vessel import VesselConfig
from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.readings import Battery
from companion.nav.charge import ChargeCounter
from companion.params.devices import ANY_DEVICE
from companion.params.store import Parameters

_PACK_AGE_S = 10.0  # an older measurement of another pack does not count
_SAG_S = 10.0  # time constant: a pull of the thrusters lowers the voltage for seconds


class BatteryGauge:
    """Battery readings of all devices → the battery as the boat sees it.

    `remaining` is the device's; else counted from the current with the vessel's `[battery]`; else judged by the voltage
    of BAT1_N_CELLS cells, smoothed. Of several packs the one with the least left counts. Remembers the count of charge,
    the newest measurement and the smoothed voltage of each device, and the source that was announced as missing.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, say: Announce) -> None:
        self._bridges = [bridge.name for bridge in config.actuators]
        self._parameters = parameters
        self._say = say
        self._counter = ChargeCounter(config.battery)
        self._voltages: dict[str, tuple[float, float]] = {}
        self._missed = ANY_DEVICE
        self._packs: dict[str, Battery] = {}

    def update(self, reading: Battery, before: Battery | None, now_s: float) -> Battery | None:
        """The newest measurement that counts: `reading`, or `before`, the one until now; None for none."""
        counted = self._counter.update(reading)
        if counted.remaining is None:
            counted = replace(counted, remaining=self._by_voltage(counted))
        self._packs[counted.source] = counted
        if not self._counts(reading.source, now_s):
            return before if before is not None and self._counts(before.source, now_s) else None
        return self._emptiest(counted, now_s)

    def packs(self, now_s: float) -> tuple[Battery | None, ...]:
        """The newest measurement of every pack, also of those that do not count: bridges first, in the vessel's order,
        then others by name. None for one that was not heard of late. Empty where BAT1_SOURCE wants none."""
        if self._parameters["BAT1_SOURCE"] < ANY_DEVICE:
            return ()
        others = sorted(name for name in self._packs if name not in self._bridges)
        heard = [self._packs[name] for name in (*self._bridges, *others) if name in self._packs]
        return tuple(one if now_s - one.t_s <= _PACK_AGE_S else None for one in heard)

    def _emptiest(self, battery: Battery, now_s: float) -> Battery:
        """Of several packs that count, the one with the least left; `battery` where of none the charge is known."""
        fresh = (one for one in self.packs(now_s) if one is not None and self._counts(one.source, now_s))
        known = [one for one in fresh if one.remaining is not None]
        return min(known, key=lambda one: one.remaining or 0.0, default=battery)

    def _counts(self, source: str, now_s: float) -> bool:
        number = int(self._parameters["BAT1_SOURCE"])
        if number <= len(self._bridges):
            self._missed = ANY_DEVICE
            return number == ANY_DEVICE or (number > 0 and source == self._bridges[number - 1])
        if self._missed != number:
            self._missed = number
            text = f"No battery: BAT1_SOURCE is {number}, bridges are {len(self._bridges)}"
            self._say(now_s, TextKind.ATTENTION, "battery_source", text)
        return False

    def _by_voltage(self, battery: Battery) -> float | None:
        p = self._parameters
        cells, span_v = p["BAT1_N_CELLS"], p["BAT1_V_CHARGED"] - p["BAT1_V_EMPTY"]
        if cells <= 0.0 or span_v <= 0.0 or not math.isfinite(battery.voltage_v):
            return None
        return min(1.0, max(0.0, (self._smoothed_v(battery) / cells - p["BAT1_V_EMPTY"]) / span_v))

    def _smoothed_v(self, battery: Battery) -> float:
        voltage_v, t_s = self._voltages.get(battery.source, (battery.voltage_v, battery.t_s))
        weight = 1.0 - math.exp(-max(0.0, battery.t_s - t_s) / _SAG_S)
        voltage_v += weight * (battery.voltage_v - voltage_v)
        self._voltages[battery.source] = voltage_v, battery.t_s
        return voltage_v
