"""A battery that the thrusters drain."""

from __future__ import annotations

_FULL_V = 12.8
_EMPTY_V = 11.2
_RESISTANCE_OHM = 0.02
_JOULE_PER_WH = 3600.0


class BatteryModel:
    """In: power drawn; out: voltage, current, share left. Remembers the energy used. Voltages are those of a 12 V lead battery."""

    __slots__ = ("_capacity_j", "_used_j", "current_a")

    def __init__(self, capacity_wh: float, used: float = 0.0) -> None:
        """`used`: share of the capacity gone at the start."""
        self._capacity_j = capacity_wh * _JOULE_PER_WH
        self._used_j = used * self._capacity_j
        self.current_a = 0.0

    @property
    def remaining(self) -> float:
        """0…1."""
        return max(0.0, 1.0 - self._used_j / self._capacity_j)

    @property
    def voltage_v(self) -> float:
        return _EMPTY_V + (_FULL_V - _EMPTY_V) * self.remaining - _RESISTANCE_OHM * self.current_a

    def step(self, power_w: float, dt_s: float) -> None:
        self._used_j += power_w * dt_s
        self.current_a = power_w / (_EMPTY_V + (_FULL_V - _EMPTY_V) * self.remaining)
