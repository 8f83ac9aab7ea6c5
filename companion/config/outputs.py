"""What hangs on the bridges beside the thrusters, as a vessel's file describes it: servos, relays, the battery."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.fields import STRICT, Name, NonNegative, Positive, means


@dataclass(frozen=True, slots=True)
class ServoConfig:
    """A servo output, numbered from 1 in the order of the file."""

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the servo. Bridges and messages use it.")]
    min_us: Annotated[float, Field(ge=500.0, le=2500.0), means("Shortest pulse.")] = 1000.0
    max_us: Annotated[float, Field(ge=500.0, le=2500.0), means("Longest pulse.")] = 2000.0
    rest_us: Annotated[
        float | None,
        Field(ge=500.0, le=2500.0),
        means("Pulse at rest: at the start, and while disarmed. Left out: no pulses."),
    ] = None
    while_disarmed: Annotated[bool, means("The servo may move while the boat is disarmed: it can hurt nobody.")] = False


@dataclass(frozen=True, slots=True)
class RelayConfig:
    """A relay, numbered from 0 in the order of the file. It is off at the start, and while disarmed."""

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the relay. Bridges and messages use it.")]
    while_disarmed: Annotated[
        bool,
        means("The relay may switch while the boat is disarmed: it can hurt nobody."),
    ] = False


@dataclass(frozen=True, slots=True)
class BatteryConfig:
    """For boards that measure voltage and current without counting. The first reading between the voltages at rest says
    how full the battery is."""

    __pydantic_config__ = STRICT
    capacity_ah: Annotated[Positive, means("Charge of the full battery.")]
    full_v: Annotated[Positive, means("Voltage at rest of the full battery.")]
    empty_v: Annotated[Positive, means("Voltage at rest of the empty battery.")]
    resistance_ohm: Annotated[NonNegative, means("Internal resistance, which lowers the voltage under load.")] = 0.0


def battery_problems(battery: BatteryConfig | None) -> list[tuple[tuple[str | int, ...], str]]:
    """What is wrong with `[battery]`, with its place."""
    if battery is None or battery.empty_v < battery.full_v:
        return []
    return [(("battery", "empty_v"), f"should be below full_v, {battery.full_v:g}")]


def rest_problems(servos: Sequence[ServoConfig]) -> list[tuple[tuple[str | int, ...], str]]:
    """Servos whose ends or pulse at rest contradict each other, with their places."""
    problems: list[tuple[tuple[str | int, ...], str]] = []
    for i, servo in enumerate(servos):
        if not servo.min_us < servo.max_us:
            problems.append((("servo", i, "max_us"), f"should be above min_us, {servo.min_us:g}"))
        elif servo.rest_us is not None and not servo.min_us <= servo.rest_us <= servo.max_us:
            problems.append(
                (("servo", i, "rest_us"), f"should be within min_us and max_us, {servo.min_us:g} to {servo.max_us:g}")
            )
    return problems
