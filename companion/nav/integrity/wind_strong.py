"""A wind that no small boat lies in: an anemometer whose unit, or whose decimal point, is another one.

Fed forward, a wind that is told ten times too strong is a hundred times too large a force: full thrust into a breeze.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.readings import Wind
from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, LieFound, Sense

_MOST_MPS = 33.0  # hurricane force, 12 on the scale of Beaufort
_AGAIN, _AGAIN_S = 0.7, 30.0  # of that: below for so long, as in no lull, it is believed again
_TIME_S = 2.0  # of the mean
_GAP_S = 5.0


@dataclass(slots=True)
class _Sensor:
    """Mean apparent wind, and the newest one, of when, since when it has been too strong, and when it last was near
    that."""

    speed_mps: float
    newest_mps: float
    t_s: float
    since_s: float | None = None
    near_s: float = 0.0


class WindStrong(Hypothesis):
    """Remembers the mean of each sensor."""

    def __init__(self) -> None:
        self._sensors: dict[str, _Sensor] = {}

    def clear(self) -> None:
        """Begin the means anew."""
        self._sensors.clear()

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Sensors whose mean wind is beyond any that a boat lies in, whichever way it sails."""
        self.doubt = 0.0
        most_mps = _MOST_MPS + math.hypot(evidence.north_mps, evidence.east_mps)
        for wind in evidence.winds:
            self._take(wind, most_mps)
        if not evidence.driven:
            return ()
        found = []
        for source, sensor in self._sensors.items():
            if now_s - sensor.t_s > _GAP_S:
                continue
            self.doubt = max(self.doubt, min(sensor.speed_mps / most_mps, 1.0))
            if sensor.since_s is not None:
                fault = f"says {sensor.newest_mps:.0f} m/s"
                found.append(LieFound(Channel(Sense.WIND, source), fault, sensor.since_s))
        return found

    def _take(self, wind: Wind, most_mps: float) -> None:
        sensor = self._sensors.get(wind.source)
        if sensor is None or wind.t_s - sensor.t_s > _GAP_S:
            sensor = self._sensors[wind.source] = _Sensor(wind.speed_mps, wind.speed_mps, wind.t_s)
        share = min(max(wind.t_s - sensor.t_s, 0.0) / _TIME_S, 1.0)
        sensor.speed_mps += share * (wind.speed_mps - sensor.speed_mps)
        sensor.t_s, sensor.newest_mps = wind.t_s, wind.speed_mps
        if sensor.speed_mps > _AGAIN * most_mps:
            sensor.near_s = wind.t_s
        if sensor.speed_mps > most_mps and sensor.since_s is None:
            sensor.since_s = wind.t_s
        elif wind.t_s - sensor.near_s >= _AGAIN_S:
            sensor.since_s = None
