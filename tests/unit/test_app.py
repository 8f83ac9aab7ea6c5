"""What is checked of a vessel's file beyond its keys: drivers, ports, parameters."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.app import load_vessel
from companion.config.vessel import ConfigError, find

GNSS = "serial:/dev/usv-gnss:115200"


def changed(tmp_path: Path, *changes: tuple[str, str], mark: bytes = b"") -> str:
    """ReVolt's file with other text in its place, and `mark` before it."""
    text = find("revolt").read_text(encoding="utf-8")
    for right, wrong in changes:
        assert right in text
        text = text.replace(right, wrong, 1)
    file = tmp_path / "boat.toml"
    file.write_bytes(mark + text.encode())
    return str(file)


def test_a_mark_of_windows_hides_no_mistake(tmp_path: Path) -> None:
    """Drivers and ports were not looked at in a file that begins with one."""
    mistakes = (('driver = "mtdata2"', 'driver = "mtdata9"'), (GNSS, "serial:"))
    with pytest.raises(ConfigError) as plain:
        load_vessel(changed(tmp_path, *mistakes))
    with pytest.raises(ConfigError) as marked:
        load_vessel(changed(tmp_path, *mistakes, mark=b"\xef\xbb\xbf"))
    assert len(plain.value.problems) == 2
    assert marked.value.problems == plain.value.problems


@pytest.mark.parametrize("port", ["serial:/dev/usv-gnss:57600", "serial:/dev/usv-gnss:115200?parity=even"])
@pytest.mark.parametrize(("table", "own"), [("sensor[2]", "usv-imu:115200"), ("actuator[1]", "usv-mcu:115200")])
def test_a_serial_port_has_one_setting(tmp_path: Path, port: str, table: str, own: str) -> None:
    """The second device found the port busy, with the companion itself."""
    place = rf"boat\.toml:\d+: {table}.port: ".replace("[", r"\[").replace("]", r"\]")
    text = f"sensor 'gnss' has /dev/usv-gnss too, as '{GNSS}': give both the same, or each a port of its own"
    with pytest.raises(ConfigError, match=place + text):
        load_vessel(changed(tmp_path, (f"serial:/dev/{own}", port)))
