"""Normal numbers are those of Python's own generator, however they are asked for."""

from __future__ import annotations

import random

import pytest

from sitl.noise import Normals

WAYS = ("pair", "next pair next", "next pair pair next", "gauss pair gauss", "pair next gauss next pair")


@pytest.mark.parametrize("ways", WAYS)
def test_the_numbers_come_in_the_order_of_the_stream(ways: str) -> None:
    normals, plain = Normals(random.Random("a/b")), random.Random("a/b")
    for way in ways.split() * 3:
        if way == "pair":
            assert normals.pair() == (plain.gauss(0.0, 1.0), plain.gauss(0.0, 1.0))
        elif way == "next":
            assert normals.next() == plain.gauss(0.0, 1.0)
        else:
            assert normals.gauss(2.0, 0.5) == plain.gauss(2.0, 0.5)
