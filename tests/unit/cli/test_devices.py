"""What `companion devices` proposes for a vessel's file."""

from __future__ import annotations

import tomllib

from companion.cli.devices import toml_lines
from companion.config.devices import SensorConfig
from companion.io.recognise import Recogniser
from tests.unit.io.sensors.test_vectornav import VNINS, VNYMR


def proposed(data: bytes) -> SensorConfig:
    recogniser = Recogniser()
    recogniser.feed(50 * data)
    assert recogniser.verdict is not None
    [row] = tomllib.loads("\n".join(toml_lines(recogniser.verdict, "serial:/dev/x:115200", 1.0, set())))["sensor"]
    return SensorConfig(**row)


def test_a_vectornav_that_sends_something_else_is_to_be_configured() -> None:
    for data, configure in ((VNYMR, False), (VNINS, True)):
        row = proposed(data)
        assert (row.name, row.driver, row.configure, row.rate_hz) == ("imu", "vectornav", configure, 50.0)
