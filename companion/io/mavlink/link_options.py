"""What stands behind the `?` of a link's URL."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from companion.io.mavlink.dialects import DEFAULT_DIALECT, DIALECTS, Dialect
from companion.io.mavlink.signing import Policy

ALL, LEADER = "all", "leader"
TELEMETRY = (ALL, LEADER)  # what a link streams unasked: everything, or what a lead boat wants to know on a narrow line
_YES_NO = {"yes": True, "no": False}


@dataclass(frozen=True, slots=True)
class LinkOptions:
    """`telemetry`: what is streamed there, a name of TELEMETRY. `signing`: what is asked of packets. `trusted`: keys may be set there."""

    telemetry: str = ALL
    signing: Policy = Policy.OFF
    trusted: bool = False


class OptionError(ValueError):
    """An option that cannot be had; one line without the URL."""


_TABLE: Mapping[str, Mapping[str, Any]] = {  # by fields of LinkOptions
    "telemetry": {name: name for name in TELEMETRY},
    "signing": {policy.value: policy for policy in Policy},
    "trusted": _YES_NO,
}
KNOWN = ("dialect", *_TABLE)


def parse_options(options: Mapping[str, str]) -> tuple[Dialect, LinkOptions]:
    """The dialect of a link, and the rest. Raises OptionError with what is allowed."""
    for key in options:
        if key not in KNOWN:
            raise OptionError(f"unknown option '{key}'; known here: {', '.join(KNOWN)}")
    chosen = {key: _one_of(key, options[key], values) for key, values in _TABLE.items() if key in options}
    return _one_of("dialect", options.get("dialect", DEFAULT_DIALECT.name), DIALECTS), LinkOptions(**chosen)


def _one_of(key: str, value: str, values: Mapping[str, Any]) -> Any:
    if value not in values:
        raise OptionError(f"{key} should be one of {', '.join(values)}")
    return values[value]
