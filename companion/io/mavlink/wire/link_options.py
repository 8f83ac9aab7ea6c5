"""The options of a link's URL: what follows the `?`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

from companion.io.mavlink.wire.personas import DEFAULT_PERSONA, PERSONAS, Persona
from companion.io.mavlink.wire.signing import Policy
from companion.io.transport.urls import TransportError

ALL, LEADER, HIGH_LATENCY = "all", "leader", "high_latency"
# Streamed without a request: everything; what a lead boat needs on a narrow line; or one message every 5 s.
TELEMETRY = (ALL, LEADER, HIGH_LATENCY)
_YES_NO = {"yes": True, "no": False}


class Route(Enum):
    """Forwarding between a link and the others, by its name in the URL (`?route=…`)."""

    YES = "yes"  # both ways
    FROM = "from"  # from this link to the others only
    NO = "no"


_USUAL_ROUTE = {ALL: Route.YES, LEADER: Route.FROM, HIGH_LATENCY: Route.NO}


@dataclass(frozen=True, slots=True)
class LinkOptions:
    """`telemetry`: what is streamed there, a name of TELEMETRY. `signing`: which signatures packets need. `trusted`:
    whether keys may be set there. `proof`: whether a sender of datagrams has to prove that it receives the answers.
    `rate_bytes_per_s`: capacity of the line; None: as usual for its kind."""

    telemetry: str = ALL
    signing: Policy = Policy.OFF
    trusted: bool = False
    route: Route = Route.YES
    proof: bool = True
    rate_bytes_per_s: int | None = None


class OptionError(TransportError):
    """An option that cannot be used; the message is one line without the URL."""


_TABLE: Mapping[str, Mapping[str, Any]] = {  # field of LinkOptions: value by its name in the URL
    "telemetry": {name: name for name in TELEMETRY},
    "signing": {policy.value: policy for policy in Policy},
    "trusted": _YES_NO,
    "route": {route.value: route for route in Route},
    "proof": _YES_NO,
}
KNOWN = ("dialect", *_TABLE, "rate")
_LEAST_RATE = 100


def parse_options(options: Mapping[str, str]) -> tuple[Persona, LinkOptions]:
    """The persona of a link and its other options. Raises OptionError with what is allowed."""
    for key in options:
        if key not in KNOWN:
            raise OptionError(f"unknown option '{key}'; known here: {', '.join(KNOWN)}")
    chosen = {key: _one_of(key, options[key], values) for key, values in _TABLE.items() if key in options}
    chosen.setdefault("route", _USUAL_ROUTE[chosen.get("telemetry", ALL)])
    if (rate := options.get("rate")) is not None:
        if not (rate.isascii() and rate.isdigit() and int(rate) >= _LEAST_RATE):
            raise OptionError(f"rate should be bytes a second, {_LEAST_RATE} or more")
        chosen["rate_bytes_per_s"] = int(rate)
    return _one_of("dialect", options.get("dialect", DEFAULT_PERSONA.name), PERSONAS), LinkOptions(**chosen)


def _one_of(key: str, value: str, values: Mapping[str, Any]) -> Any:
    if value not in values:
        raise OptionError(f"{key} should be one of {', '.join(values)}")
    return values[value]
