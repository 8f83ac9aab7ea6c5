"""What must be true of sensors, of a vessel or of a lead boat."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.devices import SensorConfig
from companion.config.fields import Vector
from companion.config.kinds import Place, Problem, foreign_problems
from companion.config.sensors import SENSORS

_LEAST_BASELINE_M = 0.1


def sensor_problems(sensors: Sequence[SensorConfig]) -> list[Problem]:
    """Faults of all sensors, with their places. Of a driver that is not in the table `io` judges: it may be a
    plug-in."""
    problems: list[Problem] = []
    for i, sensor in enumerate(sensors):
        if (kind := SENSORS.get(sensor.driver)) is not None:
            problems += foreign_problems(sensor, ("sensor", i), SENSORS) + kind.problems(sensor, ("sensor", i))
        problems += _pair_problems(sensor, ("sensor", i, "heading_with"), sensors)
        if not abs(_determinant(sensor.mag_matrix)) > 0.0:
            text = "has no inverse: a row is missing, or two are the same"
            problems.append((("sensor", i, "mag_matrix"), text))
    return problems


def _pair_problems(sensor: SensorConfig, place: Place, sensors: Sequence[SensorConfig]) -> list[Problem]:
    """Of a heading by the antennas of two receivers."""
    if sensor.heading_with is None:
        return []
    other = next((row for row in sensors if row.name == sensor.heading_with), None)
    if other is None or other.name == sensor.name:
        return [(place, f"'{sensor.heading_with}' is no other sensor of this file")]
    if baseline_m(sensor, other) < _LEAST_BASELINE_M:
        return [(place, f"'{other.name}' has its antenna at the same x_m, y_m: the two give no heading")]
    return []


def baseline_m(sensor: SensorConfig, other: SensorConfig) -> float:
    """Horizontal distance between two antennas."""
    return math.hypot(other.x_m - sensor.x_m, other.y_m - sensor.y_m)


def _determinant(matrix: tuple[Vector, Vector, Vector]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
