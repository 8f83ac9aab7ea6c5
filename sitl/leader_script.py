"""Scripts of a lead boat: orders of speed and turn, timed from its departure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from companion.config.vessel import ConfigError

_SHARP_RADPS = math.radians(15.0)  # the fastest turn of the Viknes
_GENTLE_RADPS = math.radians(5.0)
_SLALOM_RADPS = math.radians(10.0)
_ASTERN_MPS, _ASTERN_SHARE = 2.0, 0.25  # of the speed ahead; a follower can get out of the way of that


@dataclass(frozen=True, slots=True)
class Order:
    """At `at_s`: this speed from now on, and one turn by `turn_rad` (positive to starboard) at `rate_radps`."""

    at_s: float
    speed_mps: float
    turn_rad: float = 0.0
    rate_radps: float = 0.0


def _turn(at_s: float, speed_mps: float, degrees: float, rate_radps: float) -> Order:
    return Order(at_s, speed_mps, math.radians(degrees), rate_radps)


def _astern_mps(v: float) -> float:
    return -min(_ASTERN_MPS, _ASTERN_SHARE * v)


def _straight(v: float) -> tuple[Order, ...]:
    return (Order(0.0, v),)


def _thesis(v: float) -> tuple[Order, ...]:
    """The RescueRunner thesis's sea test: straight, a sharp turn to starboard at 75 s, a gentle one at 125 s."""
    return Order(0.0, v), _turn(75.0, v, 90.0, _SHARP_RADPS), _turn(125.0, v, 60.0, _GENTLE_RADPS)


def _slalom(v: float) -> tuple[Order, ...]:
    bends = ((30.0, 40.0), (42.0, -80.0), (58.0, 80.0), (74.0, -80.0), (90.0, 40.0))
    return Order(0.0, v), *(_turn(at_s, v, degrees, _SLALOM_RADPS) for at_s, degrees in bends)


def _uturn(v: float) -> tuple[Order, ...]:
    return Order(0.0, v), _turn(60.0, v, 180.0, _SHARP_RADPS)


def _stop(v: float) -> tuple[Order, ...]:
    return Order(0.0, v), Order(60.0, 0.0)


def _reverse(v: float) -> tuple[Order, ...]:
    return Order(0.0, v), Order(60.0, 0.0), Order(90.0, _astern_mps(v)), Order(110.0, 0.0)


def _lively(v: float) -> tuple[Order, ...]:
    """All other scripts, one after the other."""
    bends = ((175.0, 40.0), (187.0, -80.0), (203.0, 80.0), (219.0, -40.0))
    return (
        *_thesis(v),
        *(_turn(at_s, v, degrees, _SLALOM_RADPS) for at_s, degrees in bends),
        _turn(245.0, v, 180.0, _SHARP_RADPS),
        Order(290.0, 0.0),
        Order(320.0, _astern_mps(v)),
        Order(340.0, 0.0),
        Order(350.0, v),
    )


SCRIPTS: Mapping[str, Callable[[float], tuple[Order, ...]]] = {
    "straight": _straight,
    "thesis": _thesis,
    "slalom": _slalom,
    "uturn": _uturn,
    "stop": _stop,
    "reverse": _reverse,
    "lively": _lively,
}
SPEED_MPS = 8.2


def script(text: str) -> tuple[Order, ...]:
    """`thesis` or `thesis@4`: a script, and its speed in m/s. Raises ConfigError with the names there are."""
    name, at, speed = text.partition("@")
    try:
        speed_mps = float(speed) if at else SPEED_MPS
    except ValueError as error:
        raise ConfigError([f"leader '{text}': write NAME@MPS, as thesis@8.2"]) from error
    if name not in SCRIPTS or not 0.5 <= speed_mps <= 18.0:
        raise ConfigError([f"leader '{text}': one of {', '.join(SCRIPTS)}, at 0.5 to 18 m/s"])
    return SCRIPTS[name](speed_mps)
