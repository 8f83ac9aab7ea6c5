"""The table of parameters, and the store of their values.

The table has everything that can be tuned under way. Its names, defaults, units, ranges, groups and texts feed MAVLink,
the state file, the metadata for ground stations and the documentation. The `[parameters]` table of a vessel's TOML
overrides the defaults; an operator's values override those and are kept in the state file
(`companion/record/state_file.py`). Blocks hold the `Parameters` object and read `parameters["NAME"]` each time, so that
every change takes effect at once.
"""

from __future__ import annotations

from companion.params import compatibility, following, general, path, positioning, thrusters
from companion.params.spec import ParamSpec

TABLE: tuple[ParamSpec, ...] = (
    *general.ROWS,
    *positioning.ROWS,
    *path.ROWS,
    *following.ROWS,
    *thrusters.ROWS,
    *compatibility.ROWS,
)
"""Every parameter, in the order in which ground stations list them."""
