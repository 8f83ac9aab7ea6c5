"""All parameters as one file: the packed file that ArduPilot's clients fetch, and the text file of QGroundControl.

Source of the packed form: ArduPilot, AP_Filesystem, "param.pck". Each name leaves out what it has in common with the
beginning of the name before.
"""

from __future__ import annotations

import struct

from companion.params.spec import ParamType
from companion.params.store import Parameters

_MAGIC, _MAGIC_WITH_DEFAULTS = 0x671B, 0x671C
_INT32, _FLOAT = 3, 4
_HAS_DEFAULT = 1
_MAV_PARAM_TYPE = {ParamType.INT32: 6, ParamType.REAL32: 9}


def param_pck(parameters: Parameters, with_defaults: bool = False) -> bytes:
    """The file `param.pck`. `with_defaults`: a value that differs from its default is followed by the default."""
    parts = [
        struct.pack(
            "<HHH", _MAGIC_WITH_DEFAULTS if with_defaults else _MAGIC, len(parameters.specs), len(parameters.specs)
        )
    ]
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


def params_text(parameters: Parameters, system: int, component: int) -> str:
    """A `.params` file of QGroundControl: system, component, name, value, MAV_PARAM_TYPE, separated by tabs."""
    rows = ["# Onboard parameters of the USV companion", "# Vehicle-Id Component-Id Name Value Type"]
    for spec in parameters.specs:
        value = parameters[spec.name]
        shown = str(int(value)) if spec.type is ParamType.INT32 else f"{value:.9g}"
        rows.append(f"{system}\t{component}\t{spec.name}\t{shown}\t{_MAV_PARAM_TYPE[spec.type]}")
    return "\n".join(rows) + "\n"
