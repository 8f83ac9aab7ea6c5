"""The port of an SBUS receiver: a line of other settings is found before the boat is afloat."""

from __future__ import annotations

import pytest

from companion.config.devices import SensorConfig
from companion.config.sensor_checks import sensor_problems

PORT = "serial:/dev/ttyAMA1:100000"


@pytest.mark.parametrize("port", [PORT, f"{PORT}?parity=even", f"{PORT}?stopbits=2", f"{PORT}?parity=odd&stopbits=2"])
def test_a_line_without_even_parity_and_two_stop_bits(port: str) -> None:
    (problem,) = sensor_problems([SensorConfig("rc", "sbus", port)])
    assert problem[0] == ("sensor", 0, "port") and "?parity=even&stopbits=2" in problem[1]


@pytest.mark.parametrize(
    ("driver", "port"),
    [
        ("sbus", f"{PORT}?parity=even&stopbits=2"),
        ("sbus", "udpin:0.0.0.0:5000"),
        ("crsf", "serial:/dev/ttyAMA1:420000"),
    ],
)
def test_lines_that_are_right(driver: str, port: str) -> None:
    assert not sensor_problems([SensorConfig("rc", driver, port)])
