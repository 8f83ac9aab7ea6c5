"""What the fuzzer found once is read again in every run of the tests, whole and spoilt."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from tests.fuzz.run import CORPUS, lines
from tests.fuzz.seeds import SEEDS
from tests.fuzz.targets import TARGETS

_SPOILT = 3  # of each input; one, of the slow ones
_LONG = 2000
_SLOW = {"vessel_file", "plan_file"}


def inputs(target: str) -> Iterator[bytes]:
    draws = random.Random(17)
    for data in (b"", *SEEDS[target](), *lines(target)):
        if target == "vessel_file" and len(data) > _LONG:
            continue  # the bundled vessels are loaded often enough
        yield data
        for _ in range(1 if target in _SLOW else _SPOILT):
            spoilt = bytearray(data or b"\0")
            spoilt[draws.randrange(len(spoilt))] ^= 1 << draws.randrange(8)
            yield bytes(spoilt)


@pytest.mark.parametrize("target", TARGETS)
def test_what_was_found_once_is_borne(target: str) -> None:
    count = 0
    for data in inputs(target):
        TARGETS[target](data)
        count += 1
    assert count >= 30


def test_the_corpus_is_small_and_of_known_targets() -> None:
    paths = sorted(CORPUS.iterdir())
    assert {path.stem for path in paths} == set(TARGETS) == set(SEEDS)
    assert sum(path.stat().st_size for path in paths) < 300_000
