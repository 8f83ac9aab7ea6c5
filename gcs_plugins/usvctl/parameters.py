"""Parameters: read, set, and keep in a file of QGroundControl's form (system, component, name, value, MAV_PARAM_TYPE,
by tabs)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from mavsdk.plugins.param import Param, ParamError, ParamResult

from gcs_plugins.usvctl.boat import Boat, Mistake, NoVessel, Refused

_INT32, _REAL32 = 6, 9
Values = Mapping[str, float]
"""By name; whole numbers are ints."""


def read_all(boat: Boat) -> Values:
    """Every parameter. Raises NoVessel when the boat does not answer."""
    found = Param(boat.system).get_all_params()
    values = {p.name: p.value for p in found.int_params} | {p.name: p.value for p in found.float_params}
    if not values:
        raise NoVessel("no parameters came")
    return dict(sorted(values.items()))


def write(boat: Boat, name: str, value: float, whole: bool) -> None:
    """Set one. Raises Refused with the boat's reason."""
    parameters, heard = Param(boat.system), boat.texts_heard
    if whole and value != int(value):
        raise Mistake(f"{name} takes whole numbers")
    try:
        if whole:
            parameters.set_param_int(name, int(value))
        else:
            parameters.set_param_float(name, value)
    except ParamError as error:
        if error.result in (ParamResult.TIMEOUT, ParamResult.NO_SYSTEM):
            raise NoVessel(f"{name}: no answer") from error
        raise Refused(boat.reason(heard) or f"{name}: {error.result.name.lower().replace('_', ' ')}") from error


def to_text(values: Values, system_id: int) -> str:
    """A `.params` file."""
    rows = ["# Onboard parameters, saved by usvctl", "# Vehicle-Id Component-Id Name Value Type"]
    for name, value in values.items():
        whole = isinstance(value, int)
        rows.append(
            f"{system_id}\t1\t{name}\t{value if whole else format(value, '.9g')}\t{_INT32 if whole else _REAL32}"
        )
    return "\n".join(rows) + "\n"


def from_file(path: Path) -> dict[str, float]:
    """Names and values of a `.params` file, or of lines `NAME VALUE` as ArduPilot's tools write. Raises Mistake with
    file and line."""
    values: dict[str, float] = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        words = line.replace(",", " ").replace("=", " ").split()
        if not words or words[0].startswith("#"):
            continue
        name, value = (words[2], words[3]) if len(words) == 5 else (words[0], words[1] if len(words) == 2 else "")
        try:
            values[name] = float(value)
        except ValueError:
            raise Mistake(f"{path}, line {number}: should be NAME VALUE, or a line of a .params file") from None
        if not math.isfinite(values[name]):
            raise Mistake(f"{path}, line {number}: {name} is {value}; give a finite number")
    return values
