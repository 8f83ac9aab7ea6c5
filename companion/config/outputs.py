"""Outputs beside the thrusters, as a vessel's file describes them: servos and relays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.fields import STRICT, Name


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


def rest_problems(servos: Sequence[ServoConfig]) -> list[tuple[tuple[str | int, ...], str]]:
    """Places and texts of what no single field can know."""
    problems: list[tuple[tuple[str | int, ...], str]] = []
    for i, servo in enumerate(servos):
        if not servo.min_us < servo.max_us:
            problems.append((("servo", i, "max_us"), f"should be above min_us, {servo.min_us:g}"))
        elif servo.rest_us is not None and not servo.min_us <= servo.rest_us <= servo.max_us:
            problems.append((("servo", i, "rest_us"), f"should be within min_us and max_us, {servo.min_us:g} to {servo.max_us:g}"))
    return problems
