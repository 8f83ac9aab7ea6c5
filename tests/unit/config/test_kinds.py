"""Rows that are read by their driver: the tables agree, and a new driver is a file and a row in each."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any

import pytest
from pydantic import Field, TypeAdapter

from companion.analysis.log_reader import open_log
from companion.config import vessel as config
from companion.config.actuators import BRIDGES
from companion.config.actuators.nanotec import NanotecConfig, StepperConfig
from companion.config.devices import OTHER_KEYS, ActuatorConfig, SensorConfig
from companion.config.fields import FROM_DEGREES, Positive, means
from companion.config.kinds import BridgeKind, Equipment, Place, Problem, SensorKind, keys
from companion.config.sensors import SENSORS
from companion.config.vessel import ConfigError, VesselConfig
from companion.io import actuators, sensors
from companion.io.actuators import open_actuator
from companion.io.sensors import open_sensor
from sitl.memory import MemoryStream

ABOAT = config.find("aboat").read_text(encoding="utf-8")
BRIDGE = 'driver = "microcontroller"\nport = "serial:/dev/usv-mcu:115200"\n'
SONAR = '[[sensor]]\nname = "sonar"\ndriver = "toy_sonar"\nport = "udpin:0.0.0.0:5000"\nx_m = 1.5\nheading_offset_deg = 90\n'


def test_the_tables_of_config_and_io_name_the_same_drivers() -> None:
    assert set(BRIDGES) == set(actuators.DRIVERS) and set(SENSORS) == set(sensors.DRIVERS)


@pytest.mark.parametrize("table", [BRIDGES, SENSORS], ids=["bridges", "sensors"])
def test_no_driver_has_a_key_that_another_one_reads_as_something_else(table: dict[str, Any]) -> None:
    base = SensorConfig if table is SENSORS else ActuatorConfig
    own = [keys(kind.row) - keys(base) for kind in table.values()]
    assert all(issubclass(kind.row, base) for kind in table.values())
    assert sum(map(len, own)) == len(frozenset().union(*own))


# --- a throw-away driver --------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ToyConfig(ActuatorConfig):
    """What a file of companion/config/actuators holds."""

    gain: Annotated[Positive, means("Gain.")] = 1.0
    tilt_rad: Annotated[float, Field(alias="tilt_deg", le=45.0), FROM_DEGREES, means("Tilt.")] = 0.0


def toy_problems(bridge: ToyConfig, at: Place, equipment: Equipment) -> list[Problem]:
    if bridge.gain > len(equipment.thrusters):
        return [((*at, "gain"), "should not be above the number of thrusters")]
    return []


@dataclass(frozen=True, slots=True)
class ToySonarConfig(SensorConfig):
    """What a file of companion/config/sensors holds."""

    beams: Annotated[int, Field(ge=1), means("Beams.")] = 1


@pytest.fixture
def toys(monkeypatch: pytest.MonkeyPatch) -> None:
    """The one row in each table."""
    monkeypatch.setitem(BRIDGES, "toy", BridgeKind(ToyConfig, toy_problems))  # type: ignore[arg-type]
    monkeypatch.setitem(actuators.DRIVERS, "toy", lambda row, vessel, stream: ("toy", row, stream.name))  # type: ignore[arg-type]
    kind = SensorKind(ToySonarConfig, lambda row, at: [((*at, "beams"), "even, please")] if row.beams % 2 else [])
    monkeypatch.setitem(SENSORS, "toy_sonar", kind)  # type: ignore[arg-type]
    monkeypatch.setitem(sensors.DRIVERS, "toy_sonar", lambda row, stream: ("sonar", row))  # type: ignore[arg-type]


def with_toys(bridge: str, sonar: str = SONAR + "beams = 2\n") -> VesselConfig:
    assert BRIDGE in ABOAT
    text = ABOAT.replace(BRIDGE, f'driver = "toy"\nport = "tcpout:10.0.0.2:99"\n{bridge}')
    return config.parse(f"{text}\n{sonar}", "boat.toml")


def test_a_driver_with_keys_of_its_own_is_a_file_and_a_row(toys: None) -> None:
    vessel = with_toys("gain = 1.5\ntilt_deg = 30\n")
    bridge, sonar = vessel.actuators[0], vessel.sensors[-1]
    assert isinstance(bridge, ToyConfig) and (bridge.gain, round(bridge.tilt_rad, 6)) == (1.5, 0.523599)
    assert isinstance(sonar, ToySonarConfig) and (sonar.beams, sonar.x_m) == (2, 1.5)
    assert open_actuator(bridge, vessel, MemoryStream("x")) == ("toy", bridge, "x")
    assert open_sensor(sonar, MemoryStream("x")) == ("sonar", sonar)


@pytest.mark.parametrize(
    ("bridge", "sonar", "expected"),
    [
        (
            "gain = 0\ntilt_deg = 50\n",
            SONAR + "beams = 2\n",
            ["actuator[1].gain: should be greater than 0", "actuator[1].tilt_deg: should be less"],
        ),
        ("gian = 2\n", SONAR + "beams = 2\n", ["actuator[1].gian: unknown key; check the spelling"]),
        (
            "gain = 9\n",
            SONAR + "beams = 1\n",
            ["sensor[4].beams: even, please", "actuator[1].gain: should not be above"],
        ),
        ("motor = []\n", SONAR + "beams = 2\n", ["actuator[1].motor: only for the driver 'nmea2000', not 'toy'"]),
        ("", SONAR + "beams = 0\n", ["sensor[4].beams: should be greater"]),
    ],
)
def test_its_faults_have_their_place_their_line_and_the_remedy(
    toys: None, bridge: str, sonar: str, expected: list[str]
) -> None:
    with pytest.raises(ConfigError) as caught:
        with_toys(bridge, sonar)
    found = [problem for problem in caught.value.problems if "at least 1 item" not in problem]  # ÅBOAT has one bridge
    assert len(found) == len(expected)
    for text in expected:
        assert any(text in problem and problem.startswith("boat.toml:") for problem in found), found


def test_a_key_of_another_driver_is_told_with_its_owner(toys: None) -> None:
    with pytest.raises(
        ConfigError, match=r"boat.toml:\d+: sensor\[4\].beams: only for the driver 'toy_sonar', not 'ais'"
    ):
        config.parse(f"{ABOAT}\n{SONAR.replace('toy_sonar', 'ais')}beams = 2\n", "boat.toml")


# --- logs and editors -----------------------------------------------------------------------------------------------


def test_a_log_brings_back_the_rows_of_today_and_those_of_before(tmp_path: Path) -> None:
    vessel = config.load(config.find("revolt"))
    common = {f.name: getattr(vessel.actuators[0], f.name) for f in fields(ActuatorConfig)}
    drives = NanotecConfig(**{**common, "driver": "nanotec", "drives": (StepperConfig("bow", 3, 4800.0),)})
    vessel = replace(vessel, actuators=(drives, vessel.actuators[0]))
    content = json.loads(json.dumps(config.as_dict(vessel)))
    manifest = tmp_path / "manifest.json"
    manifest.write_text(json.dumps({"configuration": content, "parameters": {}}))
    assert open_log(tmp_path).config == vessel
    board = content["actuators"][1]
    del board["others"]
    board |= {"drives": [], "motors": [], "mavlink": None}  # as all rows had them
    manifest.write_text(json.dumps({"configuration": content, "parameters": {}}))
    assert open_log(tmp_path).config == vessel


def test_the_schema_for_editors_has_the_rows_of_all_drivers() -> None:
    schema = TypeAdapter(VesselConfig).json_schema()
    rows = schema["properties"]["actuator"]["items"]["anyOf"]
    assert {key for row in rows for key in row["properties"]} == set().union(
        *(keys(k.row) for k in BRIDGES.values())
    ) - {OTHER_KEYS}
