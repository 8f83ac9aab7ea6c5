"""What is checked of a vessel's file beyond its keys, and the parameters with which a boat starts."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.config.vessel import ConfigError, find
from companion.params.store import Parameters
from companion.record.state_file import StateFile
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions

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


def parameters_of(state: StateFile, told: list[str]) -> Parameters:
    """Those of a boat that starts with that state; `told`: warnings."""
    config = load_vessel("revolt")
    world = World(config, WorldConditions())
    around = Surroundings(SimulatedClock(EPOCH_UNIX_NS), world, world, [], state)
    vessel = build(config, around)
    told += [event.text for event in vessel.events.drain()]
    return vessel.parameters


def test_a_stored_value_that_this_version_refuses_is_kept_until_another_is_set(tmp_path: Path) -> None:
    """It was gone from the file as soon as any parameter was set."""
    stored = {"WP_SPEED": 99.0, "ALLOC_ITER": 4, "OF_ANOTHER": 1.0}
    (tmp_path / "parameters.json").write_text(json.dumps({"format": 1, "parameters": stored}), encoding="utf-8")

    def in_the_file() -> dict[str, float]:
        found: dict[str, float] = json.loads((tmp_path / "parameters.json").read_bytes())["parameters"]
        return found

    told: list[str] = []
    parameters = parameters_of(StateFile(tmp_path), told)
    assert "Stored WP_SPEED = 99 ignored: value out of range" in told
    assert parameters["WP_SPEED"] == parameters.defaults["WP_SPEED"] and parameters["ALLOC_ITER"] == 4
    assert parameters.set("ALLOC_ITER", 5) is None
    assert in_the_file() == {**stored, "ALLOC_ITER": 5}
    assert parameters.set("WP_SPEED", parameters.defaults["WP_SPEED"]) is None
    assert in_the_file() == {"ALLOC_ITER": 5, "OF_ANOTHER": 1.0}
