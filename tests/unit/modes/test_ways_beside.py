"""RTL and Mission look for their way beside the control thread, and hold until it is found."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from companion.core.decision import ModeId
from companion.core.setpoint import PathSetpoint
from companion.guidance.path_laying import TrackShape
from companion.mission.plan import PlanItem, PlanKind
from tests.unit.conftest import Boat
from tests.unit.io.mavlink.slow_storage import SlowWorker


def circles(boat: Boat, *places: tuple[float, float], radius_m: float = 8.0) -> Sequence[PlanItem]:
    """Circles to keep out of: each has so many sides that ways round them are looked for beside."""
    rows = [boat.point(*place) for place in places]
    return [
        PlanItem(n, 5004, 0, radius_m, 0.0, 0.0, 0.0, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
        for n, (lat_deg, lon_deg) in enumerate(rows)
    ]


def ring(boat: Boat) -> Sequence[PlanItem]:
    """Circles that close home in."""
    return circles(boat, (12.0, 0.0), (-12.0, 0.0), (0.0, 12.0), (0.0, -12.0), radius_m=9.0)


def away(boat: Boat) -> SlowWorker:
    """In Hold 50 m north of home, with a circle between; ways are looked for when the test says so."""
    boat.supervisor.arm(boat.now_s)
    assert boat.supervisor.go_to(*boat.point(50.0, 0.0), None, None, boat.now_s).accepted
    boat.until(lambda: boat.away_m(50.0, 0.0) < 0.3)
    boat.plans.replace(PlanKind.FENCE, circles(boat, (25.0, 0.0)))
    worker = SlowWorker()
    boat.supervisor.parts.charted.work_with(worker)
    return worker


def choose(boat: Boat, mode: ModeId) -> None:
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted


def test_rtl_holds_until_its_way_is_found(boat: Boat) -> None:
    worker = away(boat)
    choose(boat, ModeId.RTL)
    boat.step(0.5)
    assert "Planning a way" not in boat.texts()
    boat.step(4.0)
    assert boat.texts().count("Planning a way") == 1
    assert boat.status.mode is ModeId.RTL and boat.away_m(50.0, 0.0) < 0.5
    assert not isinstance(boat.setpoint, PathSetpoint) and "rtl_arrived" not in boat.names()
    worker.work()
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint)
    boat.until(lambda: "rtl_arrived" in boat.names())
    assert boat.away_m(0.0, 0.0) < 0.5


def test_rtl_straight_ahead_waits_for_nothing(boat: Boat) -> None:
    away(boat)
    boat.plans.replace(PlanKind.FENCE, circles(boat, (25.0, 40.0)))
    boat.step()
    choose(boat, ModeId.RTL)
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint)


def test_rtl_without_a_way_holds_and_says_so(boat: Boat) -> None:
    worker = away(boat)
    boat.plans.replace(PlanKind.FENCE, ring(boat))
    choose(boat, ModeId.RTL)
    boat.step(0.3)
    worker.work()
    boat.step(0.3)
    assert boat.status.mode is ModeId.HOLD
    assert "RTL stopped: no way home inside the fence" in boat.texts()


def test_a_search_without_end_ends_in_hold(boat: Boat) -> None:
    away(boat)
    choose(boat, ModeId.RTL)
    boat.step(29.0)
    assert boat.status.mode is ModeId.RTL
    boat.step(2.0)
    assert boat.status.mode is ModeId.HOLD and "RTL stopped: no way found in 30 s" in boat.texts()
    assert boat.away_m(50.0, 0.0) < 0.5


def test_a_way_found_for_another_fence_is_thrown_away(boat: Boat) -> None:
    worker = away(boat)
    choose(boat, ModeId.RTL)
    boat.step(0.3)
    boat.plans.replace(PlanKind.FENCE, ring(boat))
    boat.step(0.3)
    assert worker.work() >= 1
    boat.step(0.3)
    assert not isinstance(boat.setpoint, PathSetpoint)
    worker.work()
    boat.step(0.3)
    assert "RTL stopped: no way home inside the fence" in boat.texts()


@pytest.mark.parametrize("leave", ["hold", "disarm"])
def test_a_way_found_after_the_mode_was_left_changes_nothing(boat: Boat, leave: str) -> None:
    worker = away(boat)
    choose(boat, ModeId.RTL)
    boat.step(0.3)
    if leave == "hold":
        choose(boat, ModeId.HOLD)
    else:
        boat.supervisor.disarm(boat.now_s)
    worker.work()
    boat.step(1.0)
    assert not isinstance(boat.setpoint, PathSetpoint)
    assert boat.status.mode is (ModeId.HOLD if leave == "hold" else ModeId.RTL)


def mission_round(boat: Boat) -> SlowWorker:
    worker = away(boat)
    boat.upload((0.0, 0.0), (0.0, 20.0))
    choose(boat, ModeId.MISSION)
    return worker


def test_mission_holds_until_its_way_is_found(boat: Boat) -> None:
    worker = mission_round(boat)
    boat.step(4.0)
    assert boat.texts().count("Planning a way") == 1 and boat.status.mode is ModeId.MISSION
    assert boat.away_m(50.0, 0.0) < 0.5 and not isinstance(boat.setpoint, PathSetpoint)
    worker.work()
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint)
    nearest_m = 99.0

    def reached() -> bool:
        nonlocal nearest_m
        nearest_m = min(nearest_m, boat.away_m(25.0, 0.0))
        return boat.status.mission.reached == 1

    boat.until(reached)
    assert nearest_m > 8.0


def test_mission_whose_way_is_never_found_ends_in_hold(boat: Boat) -> None:
    mission_round(boat)
    boat.step(31.0)
    assert boat.status.mode is ModeId.HOLD and "Mission stopped: no way found in 30 s" in boat.texts()


def test_mission_without_a_way_ends_in_hold(boat: Boat) -> None:
    worker = away(boat)
    boat.plans.replace(PlanKind.FENCE, ring(boat))
    boat.upload((0.0, 0.0))
    choose(boat, ModeId.MISSION)
    boat.step(0.3)
    worker.work()
    boat.step(0.5)
    assert boat.status.mode is ModeId.HOLD
    assert "Mission stopped: item 1: way crosses the fence" in boat.texts()


def test_an_uploaded_mission_is_judged_when_its_way_is_known(boat: Boat) -> None:
    worker = away(boat)
    boat.plans.replace(PlanKind.FENCE, ring(boat))
    boat.upload((0.0, 0.0))
    boat.step(6.0)
    assert not any(text.startswith("Check the mission") for text in boat.texts())
    assert "Planning a way" not in boat.texts(), "nobody waits for it"
    worker.work()
    boat.step(1.0)
    assert "Check the mission: item 1: way crosses the fence" in boat.texts()


@pytest.mark.parametrize("mode", [ModeId.RTL, ModeId.MISSION])
def test_a_search_that_fails_ends_in_hold(boat: Boat, mode: ModeId, monkeypatch: pytest.MonkeyPatch) -> None:
    worker = away(boat)
    boat.upload((0.0, 0.0))

    def broken(work: Callable[[], object], urgent: bool = False) -> object:
        def fails() -> object:
            raise ArithmeticError("no such way")

        return SlowWorker.submit(worker, fails, urgent)

    monkeypatch.setattr(worker, "submit", broken)
    choose(boat, mode)
    boat.step(0.3)
    worker.work()
    boat.step(0.5)
    assert boat.status.mode is ModeId.HOLD and any("failed (ArithmeticError" in text for text in boat.texts())


# --- a mission under way -------------------------------------------------------------------------------------------


def sections(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> SlowWorker:
    """Under way in a mission of three parts, whose tracks are laid when the test says so."""
    monkeypatch.setattr("companion.mission.itinerary.LONGEST_ROUTE", 3)
    boat.supervisor.arm(boat.now_s)
    boat.upload(*((12.0 * n, 6.0 * (n % 2)) for n in range(1, 8)))
    worker = SlowWorker()
    boat.supervisor.parts.work_with(worker)
    choose(boat, ModeId.MISSION)
    boat.step()
    assert not isinstance(boat.setpoint, PathSetpoint)
    worker.work()
    boat.step(0.2)
    assert isinstance(boat.setpoint, PathSetpoint)
    return worker


def test_the_next_part_of_a_mission_is_laid_ahead(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    worker = sections(boat, monkeypatch)
    laid_in_ticks: list[object] = []
    lay = TrackShape.lay
    monkeypatch.setattr(TrackShape, "lay", lambda *given: laid_in_ticks.append(given) or lay(*given))
    assert worker.work() >= 1, "the second part, while the first is sailed"
    laid_in_ticks.clear()
    speeds = []

    def in_second_part() -> bool:
        speeds.append(boat.setpoint.surge_mps if isinstance(boat.setpoint, PathSetpoint) else 0.0)
        return boat.status.mission.seq == 4

    boat.until(in_second_part)
    assert not laid_in_ticks
    assert min(speeds[100:]) > 0.7 * max(speeds), "no slower than in a corner"


def test_a_part_that_is_not_laid_in_time_is_waited_for(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    worker = sections(boat, monkeypatch)
    boat.until(lambda: boat.status.mission.seq == 3)
    boat.step(0.8)
    assert isinstance(boat.setpoint, PathSetpoint), "it sails on for a moment"
    boat.step(3.0)
    assert not isinstance(boat.setpoint, PathSetpoint) and boat.status.mode is ModeId.MISSION
    assert boat.texts().count("Planning a way") == 1
    for _ in range(2):  # first what was begun under way
        worker.work()
        boat.step(0.2)
    assert isinstance(boat.setpoint, PathSetpoint)

    def complete() -> bool:
        worker.work()
        return boat.status.mission.reached == 7

    boat.until(complete)
    assert boat.texts().count("Planning a way") == 1


def test_another_mission_is_sailed_once_its_track_is_laid(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    worker = sections(boat, monkeypatch)
    boat.until(lambda: boat.nav.north_m > 5.0)
    boat.upload((5.0, -30.0), (5.0, -60.0))
    boat.step(0.3)
    assert isinstance(boat.setpoint, PathSetpoint) and boat.setpoint.progress.target.east_m > 0.0
    worker.work()
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint) and boat.setpoint.progress.target.east_m < -29.0


def fenced_on_the_way(boat: Boat, *places: tuple[float, float]) -> SlowWorker:
    """Ten metres along a leg of sixty, new circles to keep out of come, and the worker has them before it."""
    boat.supervisor.arm(boat.now_s)
    boat.upload((60.0, 0.0))
    choose(boat, ModeId.MISSION)
    boat.until(lambda: boat.nav.north_m > 10.0)
    worker = SlowWorker()
    boat.supervisor.parts.work_with(worker)
    boat.plans.replace(PlanKind.FENCE, circles(boat, *places))
    boat.step(0.5)
    return worker


def test_a_new_fence_leads_the_present_route_round_once_that_is_laid(boat: Boat) -> None:
    worker = fenced_on_the_way(boat, (40.0, 0.0))
    assert isinstance(boat.setpoint, PathSetpoint), "the fence stops it in time, if need be"
    assert abs(boat.nav.east_m) < 0.1
    worker.work()
    nearest_m = 99.0

    def there() -> bool:
        nonlocal nearest_m
        worker.work()
        nearest_m = min(nearest_m, boat.away_m(40.0, 0.0))
        return boat.status.mission.reached == 1

    boat.until(there)
    assert nearest_m > 8.0


def test_a_new_fence_without_a_way_stops_the_mission_once_that_is_known(boat: Boat) -> None:
    worker = fenced_on_the_way(boat, (60.0, 0.0))
    assert boat.status.mode is ModeId.MISSION
    worker.work()
    boat.step(0.3)
    assert boat.status.mode is ModeId.HOLD
    assert "Mission stopped: item 1: outside the fence" in boat.texts()


def test_the_way_home_of_a_mission_is_found_beside(boat: Boat) -> None:
    worker = away(boat)
    boat.upload(commands={0: PlanItem(0, 20, 2, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)})
    choose(boat, ModeId.MISSION)
    boat.step(0.5)
    assert not isinstance(boat.setpoint, PathSetpoint) and boat.away_m(50.0, 0.0) < 0.5
    worker.work()
    boat.step()
    assert isinstance(boat.setpoint, PathSetpoint)
    boat.until(lambda: boat.status.mission.reached == 1)
    assert boat.away_m(0.0, 0.0) < 0.5


def test_what_the_boat_waits_for_is_urgent(boat: Boat) -> None:
    away(boat)
    urgencies: list[bool] = []

    class Noting(SlowWorker):
        def submit(self, work: Callable[[], object], urgent: bool = False) -> object:
            urgencies.append(urgent)
            return super().submit(work, urgent)

    boat.supervisor.parts.work_with(Noting())
    boat.upload((0.0, 0.0))
    boat.step()
    assert urgencies and not any(urgencies), "checks of what may be asked for"
    urgencies.clear()
    choose(boat, ModeId.RTL)
    boat.step()
    assert urgencies == [True]
    urgencies.clear()
    choose(boat, ModeId.MISSION)
    boat.step()
    assert urgencies == [True]
