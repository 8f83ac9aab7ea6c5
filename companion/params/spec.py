"""What a parameter is, and short ways to write one as a row of the table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

FAILSAFE_ACTIONS = {0: "Ignore", 1: "Hold", 2: "RTL", 3: "Neutral"}
FEEDFORWARD_KINDS = {0: "Off", 1: "Thesis, as printed", 2: "Thesis, scaled at sea", 3: "Full"}
YES_NO = {0: "No", 1: "Yes"}
DEGREES_PER_S = "deg/s"


class ParamType(Enum):
    """Type of a parameter on MAVLink; the value is its name in the component metadata."""

    REAL32 = "Float"
    INT32 = "Int32"


@dataclass(frozen=True, slots=True, eq=False)
class ParamSpec:
    """One parameter: a row of the table, equal to itself alone. `default`, `minimum` and `maximum` are in `unit`;
    `choices` names the values of an enumeration."""

    name: str
    default: float
    minimum: float
    maximum: float
    unit: str
    group: str
    text: str
    type: ParamType = ParamType.REAL32
    decimals: int = 2
    reboot: bool = False
    read_only: bool = False
    choices: Mapping[int, str] = field(default_factory=dict)

    @property
    def takes(self) -> str:
        """The values that it takes, for people."""
        if self.choices:
            return ", ".join(map(str, self.choices))
        return f"{self.minimum:g} to {self.maximum:g} {self.unit}".rstrip()


class ParamRefusal(Enum):
    """Why a value is refused; the names are those of MAVLink's MAV_PARAM_ERROR."""

    DOES_NOT_EXIST = 1
    VALUE_OUT_OF_RANGE = 2
    READ_ONLY = 5


def real(
    name: str, default: float, minimum: float, maximum: float, unit: str, group: str, text: str, **more: Any
) -> ParamSpec:
    """A parameter with a real value."""
    return ParamSpec(name, default, minimum, maximum, unit, group, text, **more)


def integer(
    name: str, default: int, minimum: int, maximum: int, unit: str, group: str, text: str, **more: Any
) -> ParamSpec:
    """A parameter with a whole number."""
    return ParamSpec(name, default, minimum, maximum, unit, group, text, ParamType.INT32, 0, **more)


def choice(name: str, default: int, choices: Mapping[int, str], group: str, text: str, **more: Any) -> ParamSpec:
    """A parameter whose values are the keys of `choices`."""
    return integer(name, default, min(choices), max(choices), "", group, text, choices=choices, **more)


def fixed(name: str, value: float, text: str, shown: str = "", whole: bool = True) -> ParamSpec:
    """A read-only name that QGroundControl's PX4 pages look up: without it they report a missing parameter. `shown`:
    the value's name, where a page lists values by name. `whole`: INT32, as in PX4; else REAL32."""
    kind, decimals = (ParamType.INT32, 0) if whole else (ParamType.REAL32, 1)
    names = {int(value): shown} if shown else {}
    return ParamSpec(
        name, value, value, value, "", "Compatibility", text, kind, decimals, read_only=True, choices=names
    )
