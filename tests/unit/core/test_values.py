"""Every value that passes between two steps of a tick is frozen."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, fields, is_dataclass, replace
from enum import Enum
from typing import Any

import pytest

from companion.core import actuation, decision, estimate, readings, setpoint, tick

VALUES = sorted(
    {
        cls
        for module in (readings, estimate, decision, setpoint, actuation, tick)
        for cls in vars(module).values()
        if isinstance(cls, type) and is_dataclass(cls)
    },
    key=lambda cls: cls.__name__,
)


def test_the_list_of_readings_is_complete() -> None:
    assert len(VALUES) > 40


@pytest.mark.parametrize("cls", VALUES, ids=lambda cls: cls.__name__)
def test_a_value_cannot_be_changed(cls: type) -> None:
    instance = cls(**{field.name: None for field in fields(cls)})
    assert not hasattr(instance, "__dict__")
    with pytest.raises(FrozenInstanceError):
        setattr(instance, fields(cls)[0].name, 1.0)


def _marked(cls: Any) -> Any:
    """A value with something else in each of its fields."""
    return cls(**{field.name: object() for field in fields(cls)})


def test_values_renewed_in_each_tick_keep_all_other_fields() -> None:
    inputs, command, pose = _marked(tick.Inputs), _marked(actuation.ActuatorCommand), _marked(setpoint.PoseSetpoint)
    assert inputs.renewed({}) == inputs
    for field in fields(inputs):
        new = {field.name: object()}
        assert inputs.renewed(new) == replace(inputs, **new)
        assert inputs.renewed({field.name: None}) == replace(inputs, **{field.name: None})
    lamps = actuation.Beacon()
    assert command.lit(lamps) == replace(command, beacon=lamps)
    assert pose.within(2.0, True) == replace(pose, circle_m=2.0, bow_on=True)


def test_enumerations_that_are_keys_are_hashed_without_python_code() -> None:
    for cls in (decision.ModeId, decision.Need, readings.HeadingBy, actuation.ThrusterCondition):
        assert cls.__hash__ is object.__hash__
        assert issubclass(cls, Enum)
        assert {member: member.name for member in cls} == {cls[member.name]: member.name for member in cls}
