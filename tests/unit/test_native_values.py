"""The methods of compiled dataclasses are those that `dataclass` makes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pytest

from companion.native_values import give


@dataclass(frozen=True)
class Written:
    name: str
    size: float = 1.0
    hidden: int = field(default=0, repr=False, compare=False)
    unhashed: list[int] = field(default_factory=list, hash=False)
    inner: Any = None


@dataclass(repr=False, eq=False)
class Given:
    name: str
    size: float = 1.0
    hidden: int = field(default=0, repr=False, compare=False)
    unhashed: list[int] = field(default_factory=list, hash=False)
    inner: Any = None


@dataclass(frozen=True)
class Single:
    value: Any


@dataclass(repr=False, eq=False)
class GivenSingle:
    value: Any


@dataclass(repr=False, eq=False)
class GivenChild(GivenSingle):
    other: int = 0


@dataclass(repr=False, eq=False)
class Bag:
    value: int = 0


give(Given, "repr", "eq", "hash")
give(GivenSingle, "repr", "eq", "hash")
give(GivenChild, "repr", "eq", "hash")
give(Bag, "repr", "eq", "no hash")

CASES = (("a",), ("a", 2.0), ("a", 1.0, 3), ("a", 1.0, 0, [1]), ("b", 1.0, 0, [], (1, "x")))


@pytest.mark.parametrize(("written", "given"), [(Written, Given), (Single, GivenSingle)])
def test_methods_say_what_those_of_dataclass_say(written: Any, given: Any) -> None:
    cases: Any = CASES if written is Written else ((1,), (1.0,), ((1, 2),), (float("nan"),))
    for case in cases:
        assert repr(given(*case)) == repr(written(*case)).replace(written.__name__, given.__name__)
        assert hash(given(*case)) == hash(written(*case))
        for other in cases:
            assert (given(*case) == given(*other)) is (written(*case) == written(*other))
            assert (given(*case) != given(*other)) is (written(*case) != written(*other))


def test_another_class_is_never_equal() -> None:
    assert GivenSingle(1) != GivenChild(1) and GivenChild(1) != GivenSingle(1)
    assert GivenChild(1, 2) == GivenChild(1, 2) != GivenChild(1, 3)
    assert GivenSingle(1) != 1


def test_what_changes_has_no_hash() -> None:
    assert Bag(1) == Bag(1) and repr(Bag(1)) == "Bag(value=1)"
    with pytest.raises(TypeError, match="unhashable"):
        hash(Bag())


def test_what_holds_itself_is_shown_once() -> None:
    loop = GivenSingle(None)
    loop.value = [loop]
    assert repr(loop) == "GivenSingle(value=[...])"
