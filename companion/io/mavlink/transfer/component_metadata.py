"""Component metadata: what parameters and events mean, and which thrusters there are, for ground stations, served over
MAVLink FTP.

Generated from the tables of parameters and events and from the vessel's file. Source: MAVLink guide, "Component
Metadata Protocol" (general and parameter metadata, version 1, as QGroundControl reads them).
"""

from __future__ import annotations

import json
import lzma
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from companion.config.devices import ThrusterConfig
from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.transfer.actuator_metadata import actuators
from companion.io.mavlink.transfer.events_metadata import events_json
from companion.io.mavlink.wire.personas import PERSONAS, Persona
from companion.params.spec import ParamSpec
from companion.params.store import Parameters

GENERAL, PARAMETERS, EVENTS, ACTUATORS = "general.json", "parameters.json.xz", "events.json.xz", "actuators.json.xz"
_FILTERS = ({"id": lzma.FILTER_LZMA2, "preset": 3, "dict_size": 1 << 18},)
"""A quarter of the time of the usual preset, 6, for files that are 6 % larger. A window of twice the largest file: that
of 8 MB takes longer to set up."""
_TYPES = {PARAMETERS: 1, EVENTS: 4, ACTUATORS: 5}  # COMP_METADATA_TYPE


@dataclass(frozen=True, slots=True)
class Metadata:
    """The files as they are served, by name; checksum and URI of the first, for COMPONENT_METADATA."""

    files: Mapping[str, bytes]

    @property
    def crc(self) -> int:
        """MAVLink's CRC32 of the general metadata."""
        return crc32(self.files[GENERAL])

    @property
    def uri(self) -> bytes:
        """Where the general metadata is served."""
        return f"mftp:///{GENERAL}".encode()


class Descriptions:
    """The metadata of one vessel, for each persona. The same tables give the same bytes."""

    def __init__(self, parameters: Parameters, events: ArmingEvents, thrusters: Sequence[ThrusterConfig] = ()) -> None:
        """`parameters`: their table, with this vessel's defaults; `events`: with this vessel's names."""
        same = {PARAMETERS: parameters_file(parameters), ACTUATORS: _packed(_json(actuators(thrusters)))}
        self._by_persona = {persona.name: _metadata(persona, same, events) for persona in PERSONAS.values()}

    def of(self, persona: Persona) -> Metadata:
        """The metadata on links of that persona."""
        return self._by_persona[persona.name]


def parameters_file(parameters: Parameters) -> bytes:
    """The parameter metadata as it is served."""
    return _rows_file(parameters.specs, tuple(parameters.defaults[spec.name] for spec in parameters.specs))


@lru_cache(16)
def _rows_file(specs: tuple[ParamSpec, ...], defaults: tuple[float, ...]) -> bytes:
    """The boats of a process have the table in common, and most of them their defaults."""
    rows = [parameter_row(spec, default) for spec, default in zip(specs, defaults, strict=True)]
    return _packed(_json({"version": 1, "parameters": rows}))


def _metadata(persona: Persona, same: Mapping[str, bytes], events: ArmingEvents) -> Metadata:
    """`same`: the files that are the same for all personas."""
    files = dict(same)
    if persona.has_events:
        files[EVENTS] = _events_file(events.devices, events.thrusters, persona)
    types = [
        {"type": _TYPES[name], "uri": f"mftp:///{name}", "fileCrc": crc32(content)} for name, content in files.items()
    ]
    return Metadata({GENERAL: json.dumps({"version": 1, "metadataTypes": types}).encode(), **files})


@lru_cache(32)
def _events_file(devices: tuple[str, ...], thrusters: tuple[str, ...], persona: Persona) -> bytes:
    return _packed(events_json(ArmingEvents(devices, thrusters), persona))


def _json(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content, separators=(",", ":"), ensure_ascii=False).encode()


@lru_cache(32)
def _packed(content: bytes) -> bytes:
    """QGroundControl reads no other container. Personas have files in common, and so have the boats of a process."""
    return lzma.compress(content, format=lzma.FORMAT_XZ, check=lzma.CHECK_CRC32, filters=_FILTERS)


def parameter_row(spec: ParamSpec, default: float) -> dict[str, Any]:
    """One parameter's row in the parameter metadata. Its type is that of its PARAM_VALUE."""
    whole = spec.type.value == "Int32"
    number = int if whole else _short
    row: dict[str, Any] = {
        "name": spec.name,
        "type": spec.type.value,
        "group": spec.group,
        "category": "System" if spec.read_only else "Standard",
        "shortDesc": spec.text,
        "default": number(default),
        "min": number(spec.minimum),
        "max": number(spec.maximum),
        "rebootRequired": spec.reboot,
    }
    if spec.unit:
        row["units"] = spec.unit
    if not whole:
        row |= {"decimalPlaces": spec.decimals, "increment": _short(10.0**-spec.decimals)}
    if spec.choices:
        row["values"] = [{"value": value, "description": text} for value, text in spec.choices.items()]
    return row


def crc32(data: bytes) -> int:
    """MAVLink's CRC32: reflected, polynomial 0xEDB88320, initial value 0, not inverted at the end (MAVLink guide,
    "CRC")."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def _short(value: float) -> float:
    """The value with the 7 digits of a 32-bit float."""
    return float(f"{value:.7g}")
