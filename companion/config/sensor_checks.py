"""What must be true of sensors, of a vessel or of a lead boat."""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.devices import SensorConfig
from companion.config.fields import Vector
from companion.config.kinds import Problem, foreign_problems
from companion.config.sensors import SENSORS


def sensor_problems(sensors: Sequence[SensorConfig]) -> list[Problem]:
    """Faults of all sensors, with their places. Of a driver that is not in the table `io` judges: it may be a
    plug-in."""
    problems: list[Problem] = []
    for i, sensor in enumerate(sensors):
        if (kind := SENSORS.get(sensor.driver)) is not None:
            problems += foreign_problems(sensor, ("sensor", i), SENSORS) + kind.problems(sensor, ("sensor", i))
        if not abs(_determinant(sensor.mag_matrix)) > 0.0:
            text = "has no inverse: a row is missing, or two are the same"
            problems.append((("sensor", i, "mag_matrix"), text))
    return problems


def _determinant(matrix: tuple[Vector, Vector, Vector]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
