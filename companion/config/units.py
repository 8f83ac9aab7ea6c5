"""Units from names: a name of a value ends in its unit."""

from __future__ import annotations

import re
from collections.abc import Mapping

_DERIVATIVE = re.compile(r"[xyn]_[uvr]{1,3}")  # of damping, after Fossen: `y_v` is no voltage

_SUFFIXES: Mapping[str, str] = {  # longer endings first
    "_mps2_rthz": "m/s²/√Hz",
    "_dps_rthz": "deg/s/√Hz",
    "_unix_ns": "ns since 1970, UTC",
    "_kgpm": "kg/m",
    "_kgm2": "kg·m²",
    "_kgm": "kg·m",
    "_radps2": "rad/s²",
    "_radps": "rad/s",
    "_dps2": "deg/s²",
    "_dps": "deg/s",
    "_mps2": "m/s²",
    "_mps": "m/s",
    "_nps": "N/s",
    "_ohm": "Ω",
    "_rad": "rad",
    "_deg": "deg",
    "_ah": "Ah",
    "_wh": "Wh",
    "_hz": "Hz",
    "_nm": "Nm",
    "_us": "µs",
    "_ms": "ms",
    "_ns": "ns",
    "_m2": "m²",
    "_kg": "kg",
    "_ps": "1/s",
    "_m": "m",
    "_n": "N",
    "_s": "s",
    "_v": "V",
    "_a": "A",
    "_w": "W",
}


def unit_of(name: str) -> str:
    """The unit in which a value of this name is; empty for one without."""
    if _DERIVATIVE.fullmatch(name):
        return ""
    return next((unit for suffix, unit in _SUFFIXES.items() if name.endswith(suffix)), "")
