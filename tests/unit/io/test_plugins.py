"""Drivers of other packages: found by entry points, imported only when a file names them, their faults told by name."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from companion.app import load_vessel
from companion.config import vessel as config
from companion.config.vessel import ConfigError
from companion.io.actuators import open_actuator
from companion.io.sensors import open_sensor
from companion.leader_module.app import load_leader
from companion.leader_module.config import find_leader
from sitl.memory import MemoryStream

ABOAT = config.find("aboat").read_text(encoding="utf-8")
BRIDGE = 'driver = "microcontroller"\nport = "serial:/dev/usv-mcu:115200"\n'
PACKAGE = """
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.devices import ActuatorConfig, SensorConfig
from companion.config.fields import FROM_DEGREES, Positive
from companion.config.kinds import BridgeKind, SensorKind
from companion.io.actuators import ActuatorDriver
from companion.io.sensors import SensorDriver


@dataclass(frozen=True, slots=True)
class WinchConfig(ActuatorConfig):
    gain: Positive = 1.0
    tilt_rad: Annotated[float, Field(alias="tilt_deg"), FROM_DEGREES] = 0.0


@dataclass(frozen=True, slots=True)
class SonarConfig(SensorConfig):
    beams: Annotated[int, Field(ge=1)] = 1


def problems(row, at, equipment):
    return [((*at, "gain"), "should be below 10")] if row.gain >= 10.0 else []


BRIDGE = ActuatorDriver(BridgeKind(WinchConfig, problems, pulses=True), lambda row, vessel, stream: (row, vessel.name, stream.name))
SONAR = SensorDriver(SensorKind(SonarConfig), lambda row, stream: (row, stream.name))
BROKEN = ActuatorDriver(BridgeKind(), lambda row, vessel, stream: 1 / 0)
TEXT = "no driver"
"""
ENTRY_POINTS = """[usv_companion.actuators]
acme = acme_usv:BRIDGE
acme_broken = acme_usv:BROKEN
acme_missing = acme_usv:NOTHING
acme_gone = acme_gone:BRIDGE
acme_text = acme_usv:TEXT

[usv_companion.sensors]
acme_sonar = acme_usv:SONAR
"""


@pytest.fixture
def acme(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The package acme-usv 1.2, installed; returns where."""
    site = tmp_path / "site"
    installed(site, "acme-usv", "1.2")
    (site / "acme_usv.py").write_text(PACKAGE)
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.delitem(sys.modules, "acme_usv", raising=False)
    return site


def installed(site: Path, name: str, version: str) -> None:
    info = site / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (info / "entry_points.txt").write_text(ENTRY_POINTS)


def boat(folder: Path, driver: str, keys: str = "", sensor: str = "", output: str = "") -> Path:
    """ÅBOAT's file with that bridge, that sensor, and that calibration of its first thruster."""
    assert BRIDGE in ABOAT
    text = ABOAT.replace(BRIDGE, f'driver = "{driver}"\nport = "tcpout:10.0.0.2:99"\n{keys}')
    at = text.index("[[thruster]]", text.index("[[thruster]]") + 1)
    path = folder / "boat.toml"
    path.write_text(f"{text[:at]}{output}{text[at:]}\n{sensor}", encoding="utf-8")
    return path


def problems(path: Path) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        load_vessel(str(path))
    assert all(problem.startswith(f"{path}:") for problem in caught.value.problems)
    return [problem.removeprefix(f"{path}:") for problem in caught.value.problems]


def test_a_package_is_imported_when_a_file_names_its_driver_and_not_before(acme: Path, tmp_path: Path) -> None:
    load_vessel("aboat")
    with pytest.raises(ConfigError, match="no driver 'acmee'; known: acme, acme_broken, acme_gone"):
        open_actuator(
            config.load(boat(tmp_path, "acmee")).actuators[0], config.load(config.find("aboat")), MemoryStream("x")
        )
    assert "acme_usv" not in sys.modules
    load_vessel(str(boat(tmp_path, "acme")))
    assert "acme_usv" in sys.modules


def test_its_rows_have_keys_of_their_own_and_those_of_all_rows(acme: Path, tmp_path: Path) -> None:
    sonar = '[[sensor]]\nname = "sonar"\ndriver = "acme_sonar"\nport = "udpin:0.0.0.0:5000"\nheading_offset_deg = 90\nbeams = 3\n'
    vessel = load_vessel(str(boat(tmp_path, "acme", "timeout_s = 3\ngain = 2\ntilt_deg = 90\n", sonar)))
    row, name, port = open_actuator(vessel.actuators[0], vessel, MemoryStream("x"))  # type: ignore[misc]
    assert (row.gain, row.timeout_s, row.thrusters, name, port) == (2.0, 3.0, ("bow", "stern"), "aboat", "x")
    assert round(row.tilt_rad, 6) == 1.570796 and row.others == ()
    row, port = open_sensor(vessel.sensors[-1], MemoryStream("y"))  # type: ignore[misc]
    assert (row.beams, round(row.heading_offset_rad, 6), port) == (3, 1.570796, "y")


@pytest.mark.parametrize(
    ("driver", "keys", "expected"),
    [
        ("acme", "gain = -1\n", "actuator[1].gain: should be greater than 0"),
        ("acme", "gian = 1\n", "actuator[1].gian: unknown key; check the spelling"),
        ("acme", "gain = 10\n", "actuator[1].gain: should be below 10"),
        (
            "acme_gone",
            "",
            "driver: driver 'acme_gone' of acme-usv 1.2 fails: ModuleNotFoundError: No module named 'acme_gone'",
        ),
        (
            "acme_missing",
            "",
            "driver 'acme_missing' of acme-usv 1.2 fails: AttributeError: module 'acme_usv' has no attribute 'NOTHING'",
        ),
        (
            "acme_text",
            "",
            "driver 'acme_text' of acme-usv 1.2: 'acme_usv:TEXT' is no ActuatorDriver: update or remove the package",
        ),
        ("acme_nowhere", "", "actuator[1].driver: no driver 'acme_nowhere'; known: acme, "),
    ],
)
def test_what_is_wrong_with_it_is_told_with_place_line_and_package(
    acme: Path, tmp_path: Path, driver: str, keys: str, expected: str
) -> None:
    (problem,) = problems(boat(tmp_path, driver, keys))
    line, _, text = problem.partition(": ")
    assert line.isdigit() and expected in text


def test_its_calibration_is_judged_in_its_own_unit(acme: Path, tmp_path: Path) -> None:
    load_vessel(str(boat(tmp_path, "acme", output="[thruster.output]\ntrim = 1520\n")))
    found = problems(boat(tmp_path, "acme", output="[thruster.output]\nahead = 0.9\n"))
    assert any("output.ahead: should be within 500 to 2500 µs" in problem for problem in found)


def test_a_driver_that_fails_when_it_is_opened_is_told_with_its_package(acme: Path, tmp_path: Path) -> None:
    vessel = load_vessel(str(boat(tmp_path, "acme_broken")))
    with pytest.raises(ConfigError, match=r"driver 'acme_broken' of acme-usv 1\.2 fails: ZeroDivisionError"):
        open_actuator(vessel.actuators[0], vessel, MemoryStream("x"))


def test_two_packages_with_one_driver_are_both_named(acme: Path, tmp_path: Path) -> None:
    installed(acme, "other-usv", "0.1")
    (problem,) = problems(boat(tmp_path, "acme"))
    assert "driver 'acme' is in 2 packages, acme-usv 1.2 and other-usv 0.1: remove all but one" in problem


def test_a_leader_module_takes_sensors_of_other_packages_too(acme: Path, tmp_path: Path) -> None:
    path = tmp_path / "module.toml"
    text = find_leader("viknes").read_text(encoding="utf-8")
    row = '\n[[sensor]]\nname = "sonar"\ndriver = "acme_sonar"\nport = "udpin:0.0.0.0:5000"\nbeams = '
    path.write_text(f"{text}{row}2\n")
    assert load_leader(str(path)).sensors[-1].others == (("beams", 2),)
    path.write_text(f"{text}{row}0\n")
    with pytest.raises(ConfigError, match=r"module.toml:\d+: sensor\[\d\].beams: should be greater than or equal to 1"):
        load_leader(str(path))
