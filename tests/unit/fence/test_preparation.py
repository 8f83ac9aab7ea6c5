"""A large fence is prepared by a worker: the old one stays in force until it is done, and the boat does not arm."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable, Sequence

import pytest

from companion.core.decision import Home, ModeId
from companion.fence import preparation
from companion.fence.preparation import FEW_ITEMS, FencePlan
from companion.mission.plan import PlanItem, PlanKind
from tests.unit.conftest import Boat
from tests.unit.fence.test_guard import armed_in, go
from tests.unit.io.mavlink.slow_storage import SlowWorker


def circles(boat: Boat, count: int = FEW_ITEMS + 1, north_m: float = 30.0) -> Sequence[PlanItem]:
    """Small circles to keep out of, in a row across the way north."""
    places = [boat.point(north_m, 2.0 * (n - count // 2)) for n in range(count)]
    rows = [(round(lat_deg * 1e7), round(lon_deg * 1e7)) for lat_deg, lon_deg in places]
    return [PlanItem(n, 5004, 0, 1.0, 0.0, 0.0, 0.0, x, y, 0.0) for n, (x, y) in enumerate(rows)]


@pytest.fixture
def worker(boat: Boat) -> SlowWorker:
    worker = SlowWorker()
    boat.supervisor.parts.fence.work_with(worker)
    return worker


def test_the_old_fence_stays_until_the_new_one_is_prepared(boat: Boat, worker: SlowWorker) -> None:
    boat.plans.replace(PlanKind.FENCE, circles(boat, 3, 15.0))
    armed_in(boat, ModeId.HOLD)
    assert not go(boat, 15.0, 0.0).accepted
    boat.plans.replace(PlanKind.FENCE, circles(boat))
    boat.step(1.0)
    assert boat.supervisor.parts.fence.preparing and not go(boat, 15.0, 0.0).accepted
    assert worker.work() == 1
    boat.step()
    assert not boat.supervisor.parts.fence.preparing
    assert go(boat, 15.0, 0.0).accepted and not go(boat, 30.0, 0.0).accepted


def test_the_boat_arms_when_it_is_prepared(boat: Boat, worker: SlowWorker) -> None:
    boat.plans.replace(PlanKind.FENCE, circles(boat))
    boat.step(1.0)
    assert "fence is being prepared: wait" in boat.status.arming_refusals
    worker.work()
    boat.step(1.0)
    assert "fence is being prepared: wait" not in boat.status.arming_refusals


def test_a_circle_around_home_is_cut_out_of_it_beside_too_and_its_zones_serve_again(
    make_boat: Callable[..., Boat], monkeypatch: pytest.MonkeyPatch
) -> None:
    boat, worker = make_boat(GF_MAX_HOR_DIST=60.0), SlowWorker()
    boat.supervisor.parts.fence.work_with(worker)
    boat.plans.replace(PlanKind.FENCE, circles(boat))
    boat.step()
    worker.work()
    armed_in(boat, ModeId.HOLD)
    worker.work()  # home is where it was armed
    boat.step()
    assert not go(boat, 30.0, 0.0).accepted and not go(boat, 0.0, -70.0).accepted and go(boat, 0.0, -50.0).accepted
    built: list[object] = []
    monkeypatch.setattr(FencePlan, "_zones", lambda plan: built.append(plan))
    assert boat.supervisor.set_home(Home(*boat.point(0.0, -20.0), 0.0), boat.now_s).accepted
    boat.step()
    assert not go(boat, 0.0, -70.0).accepted, "the old circle still"
    worker.work()
    boat.step()
    assert go(boat, 0.0, -70.0).accepted and not go(boat, 30.0, 0.0).accepted and built == []


def test_what_is_left_of_it_is_freed_by_the_worker(boat: Boat, worker: SlowWorker) -> None:
    boat.plans.replace(PlanKind.FENCE, circles(boat))
    boat.step()
    worker.work()
    boat.step()
    areas = boat.supervisor.parts.fence.areas()
    assert areas is not None
    left = weakref.ref(areas.fence)
    del areas
    boat.plans.prepared(PlanKind.FENCE, ())()()
    boat.plans.replace(PlanKind.FENCE, ())
    boat.step(0.2)
    gc.collect()
    assert left() is not None, "not here"
    worker.work()
    assert left() is None


def test_a_circle_without_a_radius_is_named(boat: Boat) -> None:
    items = [*circles(boat, 3), PlanItem(3, 5003, 0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)]
    boat.plans.replace(PlanKind.FENCE, items)
    assert boat.supervisor.parts.fence.no_circle == 3
    assert preparation.NOTHING.no_circle is None
