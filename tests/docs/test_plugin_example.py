"""The driver on the page of what can be added is one that the companion opens, and it reads its lines."""

from __future__ import annotations

from typing import Any

from companion.config.devices import SensorConfig
from companion.core.readings import Depth
from companion.io.sensors import DRIVERS, SensorDriver
from sitl.memory import MemoryDevice, MemoryStream
from tests.docs.pages import DOCS, blocks_of

PAGES = DOCS / "inside" / "adding.md", DOCS / "start" / "sensors.md"
PROGRAM = next(block.text for block in blocks_of(PAGES[0]) if block.title == "lab_sonar.py")


def test_the_example_of_a_driver_reads_depths_and_counts_what_it_cannot_read() -> None:
    names: dict[str, Any] = {}
    exec(compile(PROGRAM, "lab_sonar.py", "exec"), names)
    driver = names["DRIVER"]
    assert isinstance(driver, SensorDriver)
    stream = MemoryStream("sonar")
    device = MemoryDevice(stream)
    sonar = driver.open(SensorConfig("sonar", "lab_sonar", "udpin:127.0.0.1:15151"), stream)
    device.send(b"D,3.20\nD,", 1.0)
    assert sonar.read(1.0) == [Depth(1.0, "sonar", 3.2)]
    device.send(b"3.40\nnoise\n", 2.0)
    assert sonar.read(2.0) == [Depth(2.0, "sonar", 3.4)]
    assert "2 depth lines, 1 bad" in sonar.health(2.0).text


def test_every_driver_of_a_sensor_stands_on_the_page() -> None:
    first_table = PAGES[1].read_text(encoding="utf-8").partition("| driver | device |")[2].partition("\n\n")[0]
    assert [name for name in DRIVERS if f"`{name}`" not in first_table] == []
