"""Metadata and parameter files: every parameter is right, and the clients' own readers can read them."""

from __future__ import annotations

import json
import lzma
from collections.abc import Sequence
from typing import Any

import pytest
from pymavlink.mavftp import MAVFTP

from companion.app import load_vessel
from companion.config.devices import ThrusterConfig
from companion.config.vessel import bundled
from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.transfer.component_metadata import (
    ACTUATORS,
    EVENTS,
    GENERAL,
    PARAMETERS,
    Descriptions,
    Metadata,
    crc32,
    parameters_file,
)
from companion.io.mavlink.transfer.parameter_file import param_pck, params_text
from companion.io.mavlink.wire.personas import PERSONAS, PX4, Persona
from companion.params.store import Parameters
from companion.params.table import TABLE

TYPES = {"Uint8", "Int8", "Uint16", "Int16", "Uint32", "Int32", "Float"}
KNOWN = {
    "name",
    "type",
    "shortDesc",
    "longDesc",
    "units",
    "default",
    "decimalPlaces",
    "min",
    "max",
    "increment",
    "rebootRequired",
    "group",
    "category",
    "volatile",
    "values",
    "bitmask",
}


def metadata(parameters: Parameters, persona: Persona = PX4, thrusters: Sequence[ThrusterConfig] = ()) -> Metadata:
    return Descriptions(parameters, ArmingEvents(["gnss", "imu"], ["stern"]), thrusters).of(persona)


def rows(parameters: Parameters) -> list[dict[str, Any]]:
    content = json.loads(lzma.decompress(parameters_file(parameters), format=lzma.FORMAT_XZ))
    assert content["version"] == 1
    found: list[dict[str, Any]] = content["parameters"]
    return found


def test_every_parameter_is_described_in_the_shape_that_qgroundcontrol_reads() -> None:
    described = rows(Parameters())
    assert [row["name"] for row in described] == sorted(spec.name for spec in TABLE)
    for row in described:
        assert set(row) <= KNOWN and row["type"] in TYPES
        assert row["min"] <= row["default"] <= row["max"]
        assert row["shortDesc"] and row["group"]
        if row["type"] == "Int32":
            assert all(isinstance(row[key], int) for key in ("min", "max", "default"))
        else:
            assert 0 <= row["decimalPlaces"] <= 6 and row["increment"] > 0.0
        for value in row.get("values", []):
            assert set(value) == {"value", "description"} and row["min"] <= value["value"] <= row["max"]


def test_types_units_and_ranges_are_those_of_the_table() -> None:
    described = {row["name"]: row for row in rows(Parameters())}
    for spec in TABLE:
        row = described[spec.name]
        assert row["type"] == spec.type.value and row.get("units", "") == spec.unit and row["group"] == spec.group
        assert row["max"] == pytest.approx(spec.maximum, rel=1e-6) and row["min"] == pytest.approx(
            spec.minimum, rel=1e-6
        )
        assert {value["value"]: value["description"] for value in row.get("values", [])} == dict(spec.choices)


@pytest.mark.parametrize("vessel", bundled())
def test_defaults_are_the_vessels_own(vessel: str) -> None:
    config = load_vessel(vessel)
    described = {row["name"]: row for row in rows(Parameters(config.parameters))}
    for name, value in config.parameters.items():
        assert described[name]["default"] == pytest.approx(value, rel=1e-6)


def test_the_files_are_small_the_same_each_time_and_named_by_their_checksum() -> None:
    first, second = metadata(Parameters()), metadata(Parameters())
    assert first == second and sum(map(len, first.files.values())) < 30_000 and len(first.uri) < 100
    listed = json.loads(first.files[GENERAL])["metadataTypes"]
    assert listed == [
        {"type": number, "uri": f"mftp:///{name}", "fileCrc": crc32(first.files[name])}
        for number, name in ((1, "parameters.json.xz"), (5, "actuators.json.xz"), (4, "events.json.xz"))
    ]
    other = metadata(Parameters({"WP_SPEED": 0.7}))
    assert other.crc != first.crc and other.files[PARAMETERS] != first.files[PARAMETERS]


def test_only_clients_that_may_know_events_are_told_of_them() -> None:
    told = {
        name: [entry["type"] for entry in json.loads(metadata(Parameters(), persona).files[GENERAL])["metadataTypes"]]
        for name, persona in PERSONAS.items()
    }
    assert told == {"px4": [1, 5, 4], "generic": [1, 5, 4], "ardupilot": [1, 5]}


@pytest.mark.parametrize("vessel", bundled())
def test_qgroundcontrol_learns_the_motors(vessel: str) -> None:
    """As its Actuators page goes about it: outputs whose parameter exists, their functions, the type of these."""
    config = load_vessel(vessel)
    parameters = Parameters(config.parameters)
    packed = metadata(parameters, thrusters=config.thrusters).files[ACTUATORS]
    content = json.loads(lzma.decompress(packed, format=lzma.FORMAT_XZ))
    (output,) = content["outputs_v1"]
    (subgroup,) = output["subgroups"]
    (parameter,) = [row for row in subgroup["per-channel-parameters"] if row["function"] == "function"]
    functions = [
        int(parameters[parameter["name"].replace("${i}", str(channel["param-index"]))])
        for channel in subgroup["channels"]
    ]
    assert [channel["label"] for channel in subgroup["channels"]] == [thruster.name for thruster in config.thrusters]
    motor = content["mixer_v1"]["actuator-types"]["motor"]
    assert functions == list(range(motor["function-min"], motor["function-min"] + len(config.thrusters)))
    assert all(content["functions_v1"][str(number)]["label"] for number in functions)
    assert max(functions) <= motor["function-max"] and motor["values"]["max"] == 0.3
    assert (motor["values"]["min"] < 0.0) is (vessel not in ("rescuerunner", "sailbot"))
    (geometry,) = content["mixer_v1"]["config"]
    (group,) = geometry["actuators"]
    assert group["count"] == len(config.thrusters) == len(group["item-label-prefix"])
    assert all(len(row["value"]) == group["count"] for row in group["per-item-parameters"])


def test_mavlinks_checksum() -> None:
    """Against the bitwise definition: reflected 0xEDB88320, begun with 0, not inverted."""

    def bitwise(data: bytes) -> int:
        crc = 0
        for byte in data:
            crc ^= byte
            for _ in range(8):
                crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
        return crc

    for data in (b"", b"a", b"123456789", bytes(range(256))):
        assert crc32(data) == bitwise(data)


@pytest.mark.parametrize("with_defaults", [False, True])
def test_pymavlink_reads_the_packed_file(with_defaults: bool) -> None:
    parameters = Parameters()
    parameters.set("WP_SPEED", 1.25)
    parameters.set("NAV_DLL_ACT", 2)
    decoded = MAVFTP.ftp_param_decode(param_pck(parameters, with_defaults))
    assert decoded is not None
    values = {name.decode(): value for name, value, _ in decoded.params}
    assert values == {spec.name: pytest.approx(parameters[spec.name]) for spec in parameters.specs}
    if with_defaults:
        defaults = {name.decode(): value for name, value, _ in decoded.defaults}
        assert defaults["WP_SPEED"] == pytest.approx(parameters.defaults["WP_SPEED"]) and defaults["NAV_DLL_ACT"] == 1


def test_the_text_has_every_parameter_with_its_type() -> None:
    lines = [line.split("\t") for line in params_text(Parameters(), 3, 1).splitlines() if not line.startswith("#")]
    assert len(lines) == len(TABLE)
    by_name = {name: (system, component, value, kind) for system, component, name, value, kind in lines}
    assert by_name["WP_SPEED"] == ("3", "1", "0.600000024", "9")
    assert by_name["NAV_DLL_ACT"] == ("3", "1", "1", "6")


def test_boats_of_one_process_have_their_own_defaults_and_names() -> None:
    """The files are made once for boats that have all of it in common."""
    defaults = [
        {row["name"]: row["default"] for row in rows(parameters)}["WP_SPEED"]
        for parameters in (Parameters(), Parameters({"WP_SPEED": 1.25}), Parameters())
    ]
    assert defaults[1] == 1.25 and defaults[0] == defaults[2] != 1.25
    first, second = (
        Descriptions(Parameters(), ArmingEvents(["gnss"], [thruster])).of(PX4).files[EVENTS]
        for thruster in ("stern", "bow")
    )
    assert b'"bow"' in lzma.decompress(second) and b'"bow"' not in lzma.decompress(first)
