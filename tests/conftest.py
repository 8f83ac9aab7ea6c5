"""Settings that all tests share."""

import gc
import itertools
import os
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import settings

os.environ.setdefault("USV_NATIVE", "0")  # tests replace methods and count lines, which compiled modules do not have

# Each worker has one core: a second thread of the linear algebra would only wait for the other worker's.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# Without bytecode each process that a test starts compiles all modules anew, for longer than most of them run.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# A worker holds thousands of tests and all modules: to look through them for garbage time and again takes longer than
# many a test, and there is next to none while they are collected.
gc.set_threshold(50_000, 20, 20)
gc.disable()

settings.register_profile(
    "fixed", derandomize=True, deadline=None
)  # the same examples in every run, on machines of any speed
settings.load_profile("fixed")

_TESTS = Path(__file__).parent
_LONG = (  # rooms of long tests: the first worker's, which wait for other processes, then those that compute
    ("protocol",),
    ("scenarios",),
    ("docs", "properties", "replay", "packaging", "architecture"),
)


@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makeitem(collector: pytest.Collector, obj: object) -> list[pytest.Item] | None:
    """The long sweeps are as many as all other tests. `make test` leaves them out: they need not be made for that."""
    marks = getattr(obj, "pytestmark", ())
    if collector.config.getoption("markexpr") == "not sweep" and any(mark.name == "sweep" for mark in marks):
        return []
    return None


@pytest.hookimpl(trylast=True)  # after what is deselected has gone
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Each worker begins with long tests of its own, and the short ones, which any may take from another, come last."""
    workerinput = getattr(config, "workerinput", None)
    if workerinput is not None:
        items[:] = _long_ones_first(items, int(workerinput["workercount"]))


def pytest_collection_finish() -> None:
    """What has been collected stays to the end, and with it the little garbage that there is."""
    gc.freeze()
    gc.enable()


def _long_ones_first(items: Sequence[pytest.Item], workers: int) -> list[pytest.Item]:
    """In as many parts as xdist gives to the workers, one after the other. Long tests for which there is no worker of
    their own come after those of the last."""
    rooms = [item.path.relative_to(_TESTS).parts[0] for item in items]
    parts: list[list[pytest.Item]] = [[] for _ in range(workers)]
    for number, names in enumerate(_LONG):
        parts[min(number, workers - 1)] += [item for item, room in zip(items, rooms, strict=True) if room in names]
    long = {name for names in _LONG for name in names}
    short = iter([item for item, room in zip(items, rooms, strict=True) if room not in long])
    left = len(items)
    for number, part in enumerate(parts):
        part += itertools.islice(short, max(0, left // (workers - number) - len(part)))
        left -= len(part)
    return [item for part in parts for item in part]
