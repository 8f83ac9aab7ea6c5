"""Rows of a vessel's file for tests of drivers."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, TypeVar

from companion.config.devices import ActuatorConfig

R = TypeVar("R", bound=ActuatorConfig)


def bridge_row(row: ActuatorConfig, kind: type[R], driver: str, **changes: Any) -> R:
    """The same bridge with another driver, whose row is a `kind`."""
    common = {field.name: getattr(row, field.name) for field in fields(ActuatorConfig)}
    return kind(**{**common, "driver": driver, **changes})
