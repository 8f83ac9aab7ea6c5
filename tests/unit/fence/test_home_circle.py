"""GF_MAX_HOR_DIST: a circle around home, part of the fence in every respect."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from companion.core.decision import Home, ModeId
from companion.fence.home_circle import as_item, beyond
from companion.fence.zones import fence_zones
from companion.mission.plan import PlanKind
from companion.params.table import TABLE
from tests.unit.conftest import Boat
from tests.unit.fence.test_guard import armed_in, at, fence, go


def test_by_default_there_is_none(boat: Boat) -> None:
    assert next(spec for spec in TABLE if spec.name == "GF_MAX_HOR_DIST").default == 0.0
    armed_in(boat, ModeId.HOLD)
    assert boat.status.fence is None and go(boat, 500.0, 0.0).accepted
    assert "home_circle" not in boat.names()


def test_it_is_a_fence_without_any_zone(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(GF_MAX_HOR_DIST=50.0)
    armed_in(boat, ModeId.HOLD)
    assert boat.status.fence is not None and "Fence: within 50 m of home" in boat.texts()
    assert go(boat, 60.0, 0.0).reason == "Go-to refused: outside the fence"
    assert go(boat, 0.0, 49.0).reason == "Go-to refused: nearer than 2.0 m to the fence"
    assert go(boat, 30.0, 30.0).accepted


@pytest.mark.parametrize(("action", "mode"), [(1, ModeId.FORCES), (2, ModeId.HOLD), (3, ModeId.RTL)])
def test_the_action_comes_while_the_boat_can_still_stop(
    make_boat: Callable[..., Boat], action: int, mode: ModeId
) -> None:
    boat = make_boat(GF_MAX_HOR_DIST=50.0, GF_ACTION=action)
    armed_in(boat, ModeId.FORCES)
    for north_m in range(50):
        at(boat, float(north_m), 0.0, north_mps=1.0)
        boat.step()
        if "fence" in boat.status.failsafes:
            break
    assert 38 <= north_m <= 42 and boat.status.mode is mode


def test_a_mission_that_leads_out_is_announced_and_refused(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(GF_MAX_HOR_DIST=50.0)
    boat.upload((10.0, 0.0), (60.0, 0.0))
    boat.step(4.0)
    assert "Check the mission: item 2: outside the fence" in boat.texts()
    assert "item 2: outside the fence" in boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).reason


def test_zones_of_a_plan_hold_beside_it(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(GF_MAX_HOR_DIST=60.0, FENCE_GROUP0=1)
    wall = [(30.0, -5.0), (35.0, -5.0), (35.0, 5.0), (30.0, 5.0)]
    fence(boat, inside=[[(-20.0, -80.0), (40.0, -80.0), (40.0, 80.0), (-20.0, 80.0)]], outside=[wall])
    armed_in(boat, ModeId.HOLD)
    assert not go(boat, 45.0, 0.0).accepted, "out of the zone, though inside the circle"
    assert not go(boat, 0.0, 70.0).accepted, (
        "out of the circle, though inside the zone: any zone of the group is not enough"
    )
    assert not go(boat, 32.0, 0.0).accepted, "in the exclusion"
    assert go(boat, 20.0, 30.0).accepted
    boat.plans.replace(PlanKind.FENCE, [])
    assert go(boat, 45.0, 0.0).accepted and not go(boat, 0.0, 70.0).accepted


def test_it_moves_with_home(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(GF_MAX_HOR_DIST=50.0)
    armed_in(boat, ModeId.HOLD)
    assert boat.supervisor.set_home(Home(*boat.point(40.0, 0.0), 0.0), boat.now_s).accepted
    assert go(boat, 80.0, 0.0).accepted and not go(boat, -20.0, 0.0).accepted
    boat.until(lambda: boat.away_m(80.0, 0.0) < 1.0)
    assert boat.supervisor.set_home(Home(*boat.point(0.0, 0.0), 0.0), boat.now_s).accepted
    boat.step(0.2)
    assert boat.status.fence is not None and boat.status.fence.breached, "it has left the circle that it was in"
    assert "Outside the fence: Hold" in boat.texts()


def test_without_a_home_there_is_none_and_that_is_said(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(GF_MAX_HOR_DIST=50.0)
    boat.forget_home()
    boat.step(1.0)
    assert boat.status.fence is None and "No home yet: its fence circle is not enforced" in boat.texts()
    armed_in(boat, ModeId.HOLD)
    assert go(boat, 500.0, 0.0).accepted
    assert boat.supervisor.set_home(None, boat.now_s).accepted
    boat.step()
    assert boat.status.fence is not None
    assert boat.texts().index("Fence: within 50 m of home") > boat.texts().index("Home set here")
    assert "Go-to stopped: outside the fence" in boat.texts()


def test_a_change_takes_effect_at_once(boat: Boat) -> None:
    armed_in(boat, ModeId.HOLD)
    boat.parameters.set("GF_MAX_HOR_DIST", 30.0)
    assert not go(boat, 40.0, 0.0).accepted
    boat.parameters.set("GF_MAX_HOR_DIST", 50.0)
    assert go(boat, 40.0, 0.0).accepted
    boat.step()
    boat.parameters.set("GF_ACTION", 0)
    boat.step()
    assert boat.status.fence is None and "Fence circle around home is off" in boat.texts()


def test_destinations_beyond_it_are_found_in_a_file(boat: Boat) -> None:
    boat.upload((10.0, 0.0), (48.5, 0.0), (60.0, 0.0))
    items = boat.plans.items(PlanKind.MISSION)
    home = boat.point(0.0, 0.0)
    assert [text.split(":")[0] for text in beyond(items, home, 50.0, 2.0)] == ["item 2", "item 3"]
    zone = fence_zones([as_item(home, 50.0, 0)])[0]
    assert zone.inclusion and zone.radius_m == 50.0 and zone.points[0] == pytest.approx(home, abs=1e-7)
