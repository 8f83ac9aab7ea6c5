"""Settings that all tests share."""

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

settings.register_profile(
    "fixed", derandomize=True, deadline=None
)  # the same examples in every run, on machines of any speed
settings.load_profile("fixed")

_TESTS = Path(__file__).parent
_LONG = ("docs", "protocol"), ("scenarios", "properties", "replay")  # rooms of long tests: one worker's, the other's


@pytest.hookimpl(trylast=True)  # after what is deselected has gone
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Of two workers each begins with long tests, and the short ones, which either may take from the other, come last.
    One has those that wait for processes, the other those that compute."""
    if hasattr(config, "workerinput"):
        items[:] = _long_ones_first(items)


def _long_ones_first(items: Sequence[pytest.Item]) -> list[pytest.Item]:
    """In two halves, as xdist gives them to two workers."""
    rooms = [item.path.relative_to(_TESTS).parts[0] for item in items]
    first, second = ([item for item, room in zip(items, rooms, strict=True) if room in long] for long in _LONG)
    short = [item for item, room in zip(items, rooms, strict=True) if room not in (*_LONG[0], *_LONG[1])]
    begun = max(0, len(items) // 2 - len(first))
    return [*first, *short[:begun], *second, *short[begun:]]
