"""The table of parameters, and the store of their values.

The table has everything that can be tuned under way. Its names, defaults, units, ranges, groups and texts feed MAVLink,
the state file, the metadata for ground stations and the documentation. The `[parameters]` table of a vessel's TOML
overrides the defaults; an operator's values override those and are kept in the state file
(`companion/record/state_file.py`). Blocks hold the `Parameters` object and read `parameters["NAME"]` each time, so that
every change takes effect at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from companion.config.vessel import NavigatedBoat
from companion.params import (
    calibration,
    compatibility,
    devices,
    following,
    general,
    path,
    positioning,
    sailing,
    thrusters,
    transmitter,
)
from companion.params.spec import ParamSpec

TABLE: tuple[ParamSpec, ...] = (
    *general.ROWS,
    *transmitter.ROWS,
    *positioning.ROWS,
    *path.ROWS,
    *following.ROWS,
    *thrusters.ROWS,
    *sailing.ROWS,
    *devices.ROWS,
    *calibration.ROWS,
    *compatibility.ROWS,
)
"""Every parameter, in the order in which ground stations list them."""


def table_of(config: NavigatedBoat) -> tuple[ParamSpec, ...]:
    """The table of one boat: read-only values that tell ground stations what it has."""
    facts = _facts(config)
    return tuple(
        replace(spec, default=facts[spec.name], minimum=facts[spec.name], maximum=facts[spec.name])
        if spec.name in facts
        else spec
        for spec in TABLE
    )


def _facts(config: NavigatedBoat) -> Mapping[str, int]:
    return {"SYS_HAS_MAG": int(any(row.heading == "ahrs" for row in config.sensors))}
