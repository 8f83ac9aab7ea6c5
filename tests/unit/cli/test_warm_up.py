"""What a run may come to need is loaded beside it, once it is in sight and not before its first tick is told."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from companion.cli.warm_up import WarmUp
from companion.supervisor.calibration import CalibrationKind

TICK: Any = SimpleNamespace()


class Boat:
    """A vessel of which nothing needs scipy yet, and the worker that notes what it imports."""

    def __init__(self) -> None:
        self.loaded: list[str] = []
        self.fence: tuple[int, ...] = ()
        self.parts = SimpleNamespace(
            surroundings=SimpleNamespace(heard=False),
            chart=SimpleNamespace(water=None),
            calibration=SimpleNamespace(state=None),
        )
        plans = SimpleNamespace(items=lambda kind: self.fence)
        vessel: Any = SimpleNamespace(worker=self, plans=plans, supervisor=SimpleNamespace(parts=self.parts))
        self.warm_up = WarmUp(vessel)

    def submit(self, work: Callable[[], ModuleType], urgent: bool = False) -> Future[Any]:
        assert not urgent
        self.loaded.append(work().__name__)
        return Future()

    def tick(self, count: int = 3) -> None:
        for _ in range(count):
            self.warm_up.record(TICK)

    def hear_ranges(self) -> None:
        self.parts.surroundings.heard = True

    def take_chart(self) -> None:
        self.parts.chart.water = object()

    def take_fence(self) -> None:
        self.fence = (0,) * 31

    def calibrate(self, kind: CalibrationKind = CalibrationKind.COMPASS) -> None:
        self.parts.calibration.state = SimpleNamespace(kind=kind)


GRID, FIT = "scipy.sparse.csgraph", "scipy.optimize"


@pytest.mark.parametrize(
    ("happens", "needed"),
    [(Boat.hear_ranges, GRID), (Boat.take_chart, GRID), (Boat.take_fence, GRID), (Boat.calibrate, FIT)],
)
def test_what_comes_in_sight_is_loaded_once(happens: Callable[[Boat], None], needed: str) -> None:
    boat = Boat()
    boat.tick()
    assert boat.loaded == []
    happens(boat)
    boat.tick()
    assert boat.loaded == [needed]


def test_a_fence_of_few_corners_and_a_calibration_of_the_gyro_need_nothing() -> None:
    boat = Boat()
    boat.fence = (0,) * 30
    boat.calibrate(CalibrationKind.GYRO)
    boat.tick()
    assert boat.loaded == []


def test_the_first_tick_loads_nothing() -> None:
    boat = Boat()
    boat.take_chart()
    boat.tick(1)
    assert boat.loaded == []
    boat.tick(1)
    assert boat.loaded == [GRID]
    boat.warm_up.close()
