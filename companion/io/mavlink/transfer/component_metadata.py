"""Component metadata: names, units, ranges and texts of the parameters for ground stations, served over MAVLink FTP.

Generated from the table of parameters. Source: MAVLink guide, "Component Metadata Protocol" (general and parameter
metadata, version 1, as QGroundControl reads them).
"""

from __future__ import annotations

import json
import lzma
import zlib
from dataclasses import dataclass
from typing import Any

from companion.params.spec import ParamSpec
from companion.params.store import Parameters

GENERAL, PARAMETERS = "general.json", "parameters.json.xz"
_TYPE_PARAMETER = 1  # COMP_METADATA_TYPE_PARAMETER


@dataclass(frozen=True, slots=True)
class Metadata:
    """The two files as they are served; checksum and URI of the first, for COMPONENT_METADATA."""

    general: bytes
    parameters: bytes

    @property
    def crc(self) -> int:
        """MAVLink's CRC32 of the general metadata."""
        return crc32(self.general)

    @property
    def uri(self) -> bytes:
        """Where the general metadata is served."""
        return f"mftp:///{GENERAL}".encode()


def metadata(parameters: Parameters) -> Metadata:
    """The metadata of a table of parameters, with this vessel's defaults. The same table gives the same bytes."""
    rows = [parameter_row(spec, parameters.defaults[spec.name]) for spec in parameters.specs]
    text = json.dumps({"version": 1, "parameters": rows}, separators=(",", ":"), ensure_ascii=False)
    packed = lzma.compress(text.encode(), format=lzma.FORMAT_XZ, check=lzma.CHECK_CRC32)
    types = [{"type": _TYPE_PARAMETER, "uri": f"mftp:///{PARAMETERS}", "fileCrc": crc32(packed)}]
    return Metadata(json.dumps({"version": 1, "metadataTypes": types}).encode(), packed)


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
