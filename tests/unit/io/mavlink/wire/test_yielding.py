"""Who makes room at a service whose places are all taken."""

from __future__ import annotations

from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.personas import PX4
from companion.io.mavlink.wire.yielding import IDLE_S, to_yield


def endpoint(name: str, trusted: bool = False) -> Endpoint:
    made = Endpoint(name, PX4, lambda data, now_s: len(data))
    made.trusted = trusted
    return made


def test_nobody_leaves_while_all_are_busy() -> None:
    a, b, c = (endpoint(name) for name in "abc")
    assert to_yield({1: (a, 9.0), 2: (b, 9.5)}, c, 10.0) is None


def test_the_idle_one_leaves() -> None:
    a, b, c = (endpoint(name) for name in "abc")
    assert to_yield({1: (a, 10.0), 2: (b, 10.0 - IDLE_S)}, c, 10.0) == 2


def test_one_endpoint_does_not_hold_all_places() -> None:
    crowd, alone, newcomer = (endpoint(name) for name in "abc")
    held = {1: (crowd, 10.0), 2: (crowd, 9.0), 3: (alone, 8.0)}
    assert to_yield(held, newcomer, 10.0) == 2
    assert to_yield(held, crowd, 10.0) is None, "it pushes nobody out"


def test_who_is_trusted_comes_before_who_is_not() -> None:
    a, known, newcomer = endpoint("a"), endpoint("b", trusted=True), endpoint("c", trusted=True)
    held = {1: (a, 10.0), 2: (known, 1.0)}
    assert to_yield(held, newcomer, 2.0) == 1
    assert to_yield({2: (known, 1.0)}, newcomer, 2.0) is None


def test_who_is_gone_leaves_first_and_an_empty_house_has_nobody_to_leave() -> None:
    a, b, c = (endpoint(name) for name in "abc")
    a.gone = True
    assert to_yield({1: (a, 10.0), 2: (b, 0.0)}, c, 10.0) == 1
    assert to_yield({}, c, 10.0) is None
