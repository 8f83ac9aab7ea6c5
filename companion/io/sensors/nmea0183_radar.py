"""NMEA 0183 sentences of a radar that tracks targets: TTM by bearing and distance, TLL by position."""

from __future__ import annotations

import math
from collections.abc import Mapping

from companion.core.readings import RadarTarget, Reading
from companion.io.sensors.nmea0183_fields import MPS, Sentence, not_negative, number, place, within_turn
from companion.io.sensors.nmea0183_gnss import Handler

_LENGTH_M = {"K": 1000.0, "N": 1852.0, "S": 1609.344}
_LOST = "L"


class RadarSentences:
    """TTM, TLL → `RadarTarget`. A target without a number, place or unit is ignored."""

    def __init__(self, name: str) -> None:
        self._name = name
        self.handlers: Mapping[str, Handler] = {"TTM": self._ttm, "TLL": self._tll}

    def _ttm(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """The unit counts for distance and speed (N: nautical miles and knots)."""
        target, distance = number(sentence.get("target_number")), not_negative(sentence.get("distance"))
        bearing = within_turn(sentence.get("bearing"))
        unit, lost = sentence.get("dist_unit", ""), sentence.get("status") == _LOST
        placed = distance is not None and bearing is not None
        if target is None or unit not in _LENGTH_M or not (placed or lost):
            return
        speed, course = not_negative(sentence.get("speed")), within_turn(sentence.get("cog"))
        readings.append(
            RadarTarget(
                t_s,
                self._name,
                int(target),
                None if distance is None else distance * _LENGTH_M[unit],
                None if bearing is None else math.radians(bearing),
                sentence.get("brg_ref") == "R",
                None,
                None,
                None if course is None else math.radians(course),
                None if speed is None else speed * MPS[unit],
                sentence.get("cog_unit") == "R",
                lost,
                sentence.get("name") or None,
            )
        )

    def _tll(self, sentence: Sentence, t_s: float, readings: list[Reading]) -> None:
        """Position alone: such a target counts as lying."""
        target, where = number(sentence.get("target_number")), place(sentence)
        lost = sentence.get("target_status") == _LOST
        if target is None or (where is None and not lost):
            return
        lat_deg, lon_deg = (None, None) if where is None else where
        name = sentence.get("target_name") or None
        readings.append(
            RadarTarget(
                t_s, self._name, int(target), None, None, False, lat_deg, lon_deg, None, None, False, lost, name
            )
        )
