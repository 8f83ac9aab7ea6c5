"""All parameters as one file: packed as ArduPilot's clients fetch it, and as the text that QGroundControl saves.

Source of the packed form: ArduPilot, AP_Filesystem, "param.pck" (names share their beginning with the one before).
"""

from __future__ import annotations

import struct

from companion.params import Parameters, ParamType

_MAGIC, _MAGIC_WITH_DEFAULTS = 0x671B, 0x671C
_INT32, _FLOAT = 3, 4
_HAS_DEFAULT = 1
_MAV_PARAM_TYPE = {ParamType.INT32: 6, ParamType.REAL32: 9}


def packed(parameters: Parameters, with_defaults: bool = False) -> bytes:
    """`param.pck`. With defaults, each value that is not its default is followed by that."""
    parts = [struct.pack("<HHH", _MAGIC_WITH_DEFAULTS if with_defaults else _MAGIC, len(parameters.specs), len(parameters.specs))]
    before = b""
    for spec in parameters.specs:
        name, value, default = spec.name.encode(), parameters[spec.name], parameters.defaults[spec.name]
        whole = spec.type is ParamType.INT32
        common = 0
        while common < min(15, len(before), len(name) - 1) and before[common] == name[common]:
            common += 1
        differs = with_defaults and value != default
        kind = (_INT32 if whole else _FLOAT) | (_HAS_DEFAULT if differs else 0) << 4
        values = (value, default) if differs else (value,)
        number = struct.pack(f"<{len(values)}{'i' if whole else 'f'}", *(int(v) if whole else v for v in values))
        parts.append(struct.pack("<BB", kind, common | (len(name) - common - 1) << 4) + name[common:] + number)
        before = name
    return b"".join(parts)


def text(parameters: Parameters, system: int, component: int) -> str:
    """A `.params` file: system, component, name, value, MAV_PARAM_TYPE, by tabs."""
    rows = ["# Onboard parameters of the USV companion", "# Vehicle-Id Component-Id Name Value Type"]
    for spec in parameters.specs:
        value = parameters[spec.name]
        shown = str(int(value)) if spec.type is ParamType.INT32 else f"{value:.9g}"
        rows.append(f"{system}\t{component}\t{spec.name}\t{shown}\t{_MAV_PARAM_TYPE[spec.type]}")
    return "\n".join(rows) + "\n"
