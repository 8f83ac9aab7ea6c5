"""A record that is made quickly is as frozen as any other."""

from __future__ import annotations

import copy
import inspect
import pickle
from dataclasses import FrozenInstanceError, dataclass, field, fields, is_dataclass, replace
from typing import Any

import pytest

from companion.core import types
from companion.core.records import quick


@dataclass(frozen=True, slots=True)
class Plain:
    t_s: float
    name: str
    channels: tuple[float, ...] = ()
    note: str | None = None


@quick
@dataclass(frozen=True, slots=True)
class Quick:
    t_s: float
    name: str
    channels: tuple[float, ...] = ()
    note: str | None = None


def test_as_the_plain_one() -> None:
    made = Quick(1.0, "a", note="n")
    assert type(made) is Quick and repr(made) == repr(Plain(1.0, "a", note="n")).replace("Plain", "Quick")
    assert made == Quick(t_s=1.0, name="a", channels=(), note="n") != Quick(2.0, "a")
    assert hash(made) == hash(Plain(1.0, "a", note="n"))
    assert replace(made, t_s=2.0) == Quick(2.0, "a", (), "n")
    assert copy.deepcopy(made) == copy.copy(made) == pickle.loads(pickle.dumps(made)) == made
    assert list(inspect.signature(Quick).parameters) == list(inspect.signature(Plain).parameters)
    match made:
        case Quick(t_s, name):
            assert (t_s, name) == (1.0, "a")


@pytest.mark.parametrize("change", [lambda made: setattr(made, "t_s", 2.0), lambda made: delattr(made, "t_s")])
def test_frozen(change: Any) -> None:
    made = Quick(1.0, "a")
    with pytest.raises(FrozenInstanceError):
        change(made)
    assert not hasattr(made, "__dict__") and made.t_s == 1.0


def test_arguments_are_checked() -> None:
    with pytest.raises(TypeError, match="name"):
        Quick(1.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="other"):
        Quick(1.0, "a", other=3)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="takes"):
        Quick(1.0, "a", (), "n", 5)  # type: ignore[call-arg]


def test_more_than_plain_fields_are_refused() -> None:
    @dataclass(frozen=True, slots=True)
    class Made:
        items: list[int] = field(default_factory=list)

    @dataclass(frozen=True)
    class Open:
        t_s: float

    @dataclass(frozen=True, slots=True)
    class Checked:
        t_s: float

        def __post_init__(self) -> None:
            raise ValueError

    for cls in (Made, Open, Checked):
        with pytest.raises(TypeError, match=cls.__name__):
            quick(cls)


def test_every_value_of_a_tick_is_frozen() -> None:
    made = [cls for cls in vars(types).values() if isinstance(cls, type) and is_dataclass(cls)]
    assert len(made) > 20
    for cls in made:
        values = {f.name: None for f in fields(cls)}
        instance = cls(**values)
        assert type(instance) is cls
        with pytest.raises(FrozenInstanceError):
            setattr(instance, next(iter(values)), 1.0)
