"""The yaw that an inertial sensor works out for itself, as a compass."""

from __future__ import annotations

import math

from companion.config.devices import SensorConfig
from companion.core.angles import wrap_pi
from companion.core.readings import Heading, HeadingBy

_WORTH = {"none": None, "ahrs": None, "magnetic": HeadingBy.MAGNETIC, "true": HeadingBy.COMPASS}
_PERIOD_S = 0.095  # its errors are slow: ten a second are enough


class OwnYaw:
    """Yaw in rad at `t_s` → a `Heading` ten times a second, where `heading` in the vessel's file allows it. Remembers
    when it last gave one."""

    def __init__(self, config: SensorConfig) -> None:
        self._name = config.name
        self._by = _WORTH[config.heading]
        self._offset_rad = config.heading_offset_rad
        self._last_s = -math.inf

    def heading(self, t_s: float, yaw_rad: float | None) -> Heading | None:
        """The heading of the hull, or None while it is not due or not to be used."""
        if self._by is None or yaw_rad is None or 0.0 <= t_s - self._last_s < _PERIOD_S:
            return None
        self._last_s = t_s
        return Heading(t_s, self._name, wrap_pi(yaw_rad + self._offset_rad), None, self._by)
