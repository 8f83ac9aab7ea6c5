"""A battery that the thrusters drain."""

from __future__ import annotations

FULL_V = 12.8  # without current
_EMPTY_V = 11.2
_RESISTANCE_OHM = 0.02
_JOULE_PER_WH = 3600.0
LOW_VOLTAGE_V, LOW_REMAINING = 10.8, 0.08  # what boards report under the fault battery_low


class BatteryModel:
    """A 12 V lead battery. In: power drawn; out: voltage, current, share left. Remembers the energy used."""

    __slots__ = ("_capacity_j", "_used_j", "current_a")

    def __init__(self, capacity_wh: float, used: float = 0.0) -> None:
        """`used`: share of the capacity that is gone at the start."""
        self._capacity_j = capacity_wh * _JOULE_PER_WH
        self._used_j = used * self._capacity_j
        self.current_a = 0.0

    @property
    def remaining(self) -> float:
        """Share of the capacity left, 0 to 1."""
        return max(0.0, 1.0 - self._used_j / self._capacity_j)

    @property
    def voltage_v(self) -> float:
        """At the terminals, under the present current."""
        return _EMPTY_V + (FULL_V - _EMPTY_V) * self.remaining - _RESISTANCE_OHM * self.current_a

    def step(self, power_w: float, dt_s: float) -> None:
        """Draw `power_w` for `dt_s`."""
        self._used_j += power_w * dt_s
        self.current_a = power_w / (_EMPTY_V + (FULL_V - _EMPTY_V) * self.remaining)
