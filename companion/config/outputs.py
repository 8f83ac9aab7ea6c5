"""What hangs on the bridges beside the thrusters, as a vessel's file describes it: servos, relays, the battery."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.fields import STRICT, Name, NonNegative, Positive


@dataclass(frozen=True, slots=True)
class ServoConfig:
    """A servo output, numbered from 1 in the order of the file. It rests at `rest_us` (None: without pulses): at the start, and disarmed
    unless `while_disarmed`."""

    __pydantic_config__ = STRICT
    name: Name
    min_us: Annotated[float, Field(ge=500.0, le=2500.0)] = 1000.0
    max_us: Annotated[float, Field(ge=500.0, le=2500.0)] = 2000.0
    rest_us: Annotated[float | None, Field(ge=500.0, le=2500.0)] = None
    while_disarmed: bool = False  # nobody can be hurt by it: it may move with the boat disarmed


@dataclass(frozen=True, slots=True)
class RelayConfig:
    """A relay, numbered from 0 in the order of the file. It rests switched off: at the start, and disarmed unless `while_disarmed`."""

    __pydantic_config__ = STRICT
    name: Name
    while_disarmed: bool = False


@dataclass(frozen=True, slots=True)
class BatteryConfig:
    """`[battery]`: for boards that measure voltage and current without counting. Voltages at rest, full and empty, between which the first reading says how
    full it is; `resistance_ohm` is what makes them sag under load."""

    __pydantic_config__ = STRICT
    capacity_ah: Positive
    full_v: Positive
    empty_v: Positive
    resistance_ohm: NonNegative = 0.0


def battery_problems(battery: BatteryConfig | None) -> list[tuple[tuple[str | int, ...], str]]:
    if battery is None or battery.empty_v < battery.full_v:
        return []
    return [(("battery", "empty_v"), f"should be below full_v, {battery.full_v:g}")]


def rest_problems(servos: Sequence[ServoConfig]) -> list[tuple[tuple[str | int, ...], str]]:
    """Places and texts of what no single field can know."""
    problems: list[tuple[tuple[str | int, ...], str]] = []
    for i, servo in enumerate(servos):
        if not servo.min_us < servo.max_us:
            problems.append((("servo", i, "max_us"), f"should be above min_us, {servo.min_us:g}"))
        elif servo.rest_us is not None and not servo.min_us <= servo.rest_us <= servo.max_us:
            problems.append((("servo", i, "rest_us"), f"should be within min_us and max_us, {servo.min_us:g} to {servo.max_us:g}"))
    return problems
