"""Every value that passes between two steps of a tick is frozen."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, fields, is_dataclass

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
