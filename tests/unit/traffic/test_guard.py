"""Traffic under an ideal boat: warned of, waited for, gone around on the right side, inside the fence, and back to the
route."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.decision import ModeId
from companion.core.readings import AisTarget
from companion.core.setpoint import PoseSetpoint
from tests.unit.conftest import Boat
from tests.unit.fence.test_guard import armed_in, fence, go

JET = load(find("rescuerunner"))
PATH = {"WP_SPEED": 1.0, "MPC_XY_VEL_MAX": 1.0}


class Other:
    """A vessel on a straight line, heard every two seconds. `offset_m`, `bow_m`: the rest of a hull of 8 m by 3 m
    around its place."""

    def __init__(
        self,
        boat: Boat,
        north_m: float,
        east_m: float,
        north_mps: float,
        east_mps: float,
        mmsi: int = 230_000_001,
        **more: Any,
    ) -> None:
        self.boat, self.more, self.mmsi = boat, more, mmsi
        self.place, self.velocity, self.begin_s = (north_m, east_m), (north_mps, east_mps), boat.now_s
        self.silent = False

    def at(self) -> tuple[float, float]:
        dt = self.boat.now_s - self.begin_s
        return self.place[0] + dt * self.velocity[0], self.place[1] + dt * self.velocity[1]

    def speak(self) -> None:
        lat_deg, lon_deg = self.boat.point(*self.at())
        course, speed = math.atan2(self.velocity[1], self.velocity[0]) % (2 * math.pi), math.hypot(*self.velocity)
        size = {"bow_m": 4.0, "stern_m": 4.0, "port_m": 1.5, "starboard_m": 1.5, "name": "NORA"}
        report = AisTarget(self.boat.now_s, "ais", self.mmsi, lat_deg, lon_deg, course, speed, **{**size, **self.more})
        self.boat.supervisor.traffic_heard(report, self.boat.now_s)

    def gap_m(self) -> float:
        north, east = self.at()
        return math.hypot(north - self.boat.nav.north_m, east - self.boat.nav.east_m)


def sail(boat: Boat, others: list[Other], seconds: float) -> dict[str, float]:
    """Extremes of the way."""
    seen = {
        "gap_m": math.inf,
        "east_m": -math.inf,
        "west_m": math.inf,
        "turn_rad": 0.0,
        "slowest_mps": math.inf,
        "speed_step_mps": 0.0,
    }
    last = boat.setpoint
    for n in range(round(seconds * 10)):
        if n % 20 == 0:
            for other in others:
                if not other.silent:
                    other.speak()
        boat.tick()
        seen["gap_m"] = min(seen["gap_m"], *(other.gap_m() for other in others))
        seen["east_m"], seen["west_m"] = max(seen["east_m"], boat.nav.east_m), min(seen["west_m"], boat.nav.east_m)
        seen["slowest_mps"] = min(seen["slowest_mps"], boat.nav.surge_mps)
        if type(last) is type(boat.setpoint) and hasattr(last, "yaw_rad"):
            seen["turn_rad"] = max(
                seen["turn_rad"], abs(math.remainder(boat.setpoint.yaw_rad - last.yaw_rad, 2 * math.pi))
            )
            seen["speed_step_mps"] = max(seen["speed_step_mps"], abs(boat.setpoint.surge_mps - last.surge_mps))
        last = boat.setpoint
    return seen


def under_way(make_boat: Callable[..., Boat], end_m: float = 300.0, **parameters: float) -> Any:
    """In Mission, 20 s on the way north."""
    boat = make_boat(**{**PATH, **parameters})
    boat.upload((end_m, 0.0))
    armed_in(boat, ModeId.MISSION)
    boat.step(20.0)
    return boat


def head_on(boat: Boat) -> Other:
    return Other(boat, boat.nav.north_m + 150.0, 0.0, -1.0, 0.0)


CLEAR_M = 10.0 + 0.5 * math.hypot(3.0, 0.72) + 0.5 * math.hypot(8.0, 3.0)


def test_off_by_default(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat)
    seen = sail(boat, [head_on(boat)], 90.0)
    assert seen["gap_m"] < 2.0 and not [name for name in boat.names() if name.startswith("traffic")]
    assert len(boat.status.traffic) == 1, "seen and shown all the same"


def test_a_conflict_is_announced_and_nothing_else(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=1)
    seen = sail(boat, [head_on(boat)], 90.0)
    assert seen["gap_m"] < 2.0 and seen["slowest_mps"] > 0.9
    assert boat.names().count("traffic_head_on") == 1 and "traffic_action" not in boat.names()
    assert any(text.startswith("Traffic: NORA head-on, 0 m in") for text in boat.texts())


def test_head_on_to_starboard_and_back(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=3)
    seen = sail(boat, [head_on(boat)], 280.0)
    assert seen["gap_m"] >= CLEAR_M and seen["east_m"] > CLEAR_M and seen["west_m"] > -1.5
    assert (
        seen["turn_rad"] <= math.radians(boat.parameters["PATH_YAW_RATE"]) * 0.1 + 1e-6
        and seen["speed_step_mps"] < 0.06
    )
    assert abs(boat.nav.east_m) < 0.5
    assert [text for text in boat.texts() if text.startswith("Traffic")] == [
        next(text for text in boat.texts() if "head-on" in text),
        "Traffic: course to starboard for NORA",
        "Traffic: back on the route",
        "Traffic: clear of NORA",
    ]


def test_the_changed_route_is_the_position_target(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=3)
    sail(boat, [head_on(boat)], 15.0)
    assert boat.setpoint.progress.place.east_m > 3.0 and boat.setpoint.progress.target.east_m > 10.0


def test_a_vessel_that_must_give_way_is_stood_on_for_until_the_last_moment(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=3, CA_STAND_T=40.0)
    other = Other(boat, boat.nav.north_m + 90.0, -90.0, 0.0, 1.0)
    assert sail(boat, [other], 35.0)["slowest_mps"] > 0.95 and abs(boat.nav.east_m) < 0.5
    assert sail(boat, [other], 120.0)["gap_m"] >= CLEAR_M
    assert any("it gives way" in text for text in boat.texts()) and "traffic_action" in boat.names()


def test_it_does_give_way_and_nothing_happens(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=3)
    other = Other(boat, boat.nav.north_m + 90.0, -90.0, 0.0, 1.0)
    sail(boat, [other], 20.0)
    other.place, other.velocity, other.begin_s = other.at(), (-1.0, 0.0), boat.now_s
    seen = sail(boat, [other], 60.0)
    assert seen["slowest_mps"] > 0.95 and "traffic_action" not in boat.names() and "traffic_clear" in boat.names()


@pytest.mark.parametrize("told", [{"status": 7}, {"kind": 30}, {"kind": 36}], ids=["status", "fishing", "sailing"])
def test_a_fishing_vessel_is_given_way_to(make_boat: Callable[..., Boat], told: dict[str, int]) -> None:
    """Class B tells no status: the type of the ship counts."""
    boat = under_way(make_boat, CA_ACTION=3)
    other = Other(boat, boat.nav.north_m + 90.0, -90.0, 0.0, 1.0, **told)
    sail(boat, [other], 10.0)
    assert "traffic_action" in boat.names()


@pytest.mark.parametrize("action", [2, 3])
def test_the_boat_does_not_cross_ahead_of_a_vessel_from_starboard(make_boat: Callable[..., Boat], action: int) -> None:
    boat = under_way(make_boat, CA_ACTION=action)
    other = Other(boat, boat.nav.north_m + 90.0, 90.0, 0.0, -1.0)
    seen = sail(boat, [other], 150.0)
    assert seen["gap_m"] >= CLEAR_M
    assert seen["slowest_mps"] < 0.6 if action == 2 else seen["east_m"] > 5.0
    if action == 2:
        assert seen["east_m"] < 0.5 and boat.nav.surge_mps > 0.95, "under way again"
        assert "no_headway" not in boat.names()


def test_a_boat_that_is_nearly_across_does_not_stop_in_the_way_of_a_vessel_heard_late(
    make_boat: Callable[..., Boat],
) -> None:
    """An Otter stopped for a vessel that it would have passed 11 m ahead of, and came within 7 m of it."""
    boat = under_way(make_boat, CA_ACTION=3)
    seen = sail(boat, [Other(boat, boat.nav.north_m + 3.0, 26.0, 0.0, -1.0)], 40.0)
    assert seen["gap_m"] > 15.0
    assert seen["slowest_mps"] > 0.9


def test_no_course_across_the_fence(make_boat: Callable[..., Boat]) -> None:
    """A corridor with no room beside the route: the boat waits for who crosses, and never leaves it."""
    boat = make_boat(**PATH, CA_ACTION=3)
    fence(boat, inside=[((-20.0, -6.0), (330.0, -6.0), (330.0, 6.0), (-20.0, 6.0))])
    boat.upload((300.0, 0.0))
    armed_in(boat, ModeId.MISSION)
    boat.step(20.0)
    other = Other(boat, boat.nav.north_m + 90.0, 90.0, 0.0, -1.0)
    seen = sail(boat, [other], 150.0)
    assert seen["gap_m"] >= CLEAR_M and seen["east_m"] < 3.0 and seen["slowest_mps"] < 0.6
    assert not any("course to" in text for text in boat.texts())


def test_a_go_to_keeps_clear_too(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(**PATH, CA_ACTION=3)
    armed_in(boat, ModeId.HOLD)
    assert go(boat, 200.0, 0.0).accepted
    boat.step(20.0)
    seen = sail(boat, [head_on(boat)], 220.0)
    assert seen["gap_m"] >= CLEAR_M and boat.away_m(200.0, 0.0) < 2.0


def test_a_go_to_at_a_speed_of_its_own_stays_at_it(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(**PATH, CA_ACTION=3)
    armed_in(boat, ModeId.HOLD)
    assert boat.supervisor.go_to(*boat.point(250.0, 0.0), None, 0.5, boat.now_s).accepted
    boat.step(30.0)
    other, fastest_mps = head_on(boat), 0.0
    for _ in range(12):
        assert sail(boat, [other], 10.0)["gap_m"] >= CLEAR_M
        fastest_mps = max(fastest_mps, boat.nav.surge_mps)
    assert fastest_mps < 0.55 and "traffic_action" in boat.names()


def test_rtl_keeps_clear_too(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(**PATH, CA_ACTION=3)
    armed_in(boat, ModeId.HOLD)
    assert go(boat, 200.0, 0.0).accepted
    boat.until(lambda: boat.away_m(200.0, 0.0) < 1.0)
    boat.step(30.0)
    assert boat.supervisor.request_mode(ModeId.RTL, boat.now_s).accepted
    boat.step(20.0)
    other = Other(boat, 20.0, 0.0, 1.0, 0.0)
    seen = sail(boat, [other], 260.0)
    assert seen["gap_m"] >= CLEAR_M and seen["west_m"] < -CLEAR_M and boat.away_m(0.0, 0.0) < 2.0, (
        "starboard is west, on the way south"
    )


def test_a_vessel_at_rest_in_the_way_is_gone_around(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=3)
    seen = sail(boat, [Other(boat, 120.0, 2.0, 0.0, 0.0)], 290.0)
    assert seen["gap_m"] >= CLEAR_M and abs(boat.nav.east_m) < 0.5 and boat.nav.north_m > 250.0
    assert "traffic_standing" in boat.names()


def test_the_boat_comes_near_before_it_stops_for_a_vessel_at_rest(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=2, CA_STAND_T=30.0)
    other = Other(boat, 150.0, 0.0, 0.0, 0.0)
    seen = sail(boat, [other], 180.0)
    assert CLEAR_M <= seen["gap_m"] < CLEAR_M + 35.0 and boat.nav.surge_mps < 0.05


def fast(make_boat: Callable[..., Boat]) -> Any:
    boat = make_boat(JET, **{**JET.parameters, "CA_ACTION": 3, "CA_DIST": 10.0, "WP_SPEED": 8.0})
    boat.upload((1600.0, 0.0))
    armed_in(boat, ModeId.MISSION)
    boat.step(20.0)
    return boat


def test_a_fast_boat_goes_round_a_vessel_that_it_meets_late(make_boat: Callable[..., Boat]) -> None:
    """Its detours ended 41 s ahead: RescueRunner stopped at 8 m/s for what it met a minute later, and the other passed
    on the wrong side."""
    boat = fast(make_boat)
    other = Other(boat, boat.nav.north_m + 1050.0, 0.0, -6.0, 0.0)
    seen = sail(boat, [other], 120.0)
    assert seen["gap_m"] >= CLEAR_M and seen["slowest_mps"] > 5.0
    assert seen["east_m"] > 10.0 and seen["west_m"] > -3.0


def test_a_fast_boat_does_not_stop_for_good_before_a_vessel_at_rest(make_boat: Callable[..., Boat]) -> None:
    boat = fast(make_boat)
    seen = sail(boat, [Other(boat, boat.nav.north_m + 550.0, 2.0, 0.0, 0.0)], 120.0)
    assert seen["gap_m"] >= CLEAR_M and boat.nav.north_m > 900.0 and abs(boat.nav.east_m) < 3.0


def test_a_mission_replaced_on_the_way_around_is_sailed(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=3)
    other = head_on(boat)
    sail(boat, [other], 25.0)
    boat.upload((150.0, 200.0))
    seen = sail(boat, [other], 300.0)
    assert seen["gap_m"] >= CLEAR_M - 1.0 and boat.away_m(150.0, 200.0) < 3.0


def test_the_mode_chosen_wins(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=3)
    other = head_on(boat)
    sail(boat, [other], 20.0)
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    boat.step(20.0)
    place = (boat.nav.north_m, boat.nav.east_m)
    boat.step(20.0)
    assert boat.away_m(*place) < 0.5, "Hold holds, whoever comes"


def test_a_harbour_full_of_vessels(make_boat: Callable[..., Boat]) -> None:
    """Two hundred of them at the quays beside the way, one head-on."""
    boat = under_way(make_boat, CA_ACTION=3)
    quays = [Other(boat, 3.0 * n - 200.0, 60.0 if n % 2 else -60.0, 0.0, 0.0, 231_000_000 + n) for n in range(200)]
    seen = sail(boat, [head_on(boat), *quays], 150.0)
    assert seen["gap_m"] >= CLEAR_M and len(boat.status.traffic) == 201


def test_reports_that_stop_do_not_stop_the_boat(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=2)
    other = Other(boat, boat.nav.north_m + 60.0, 0.0, 0.0, 0.0)
    sail(boat, [other], 60.0)
    place = boat.nav.north_m, boat.nav.east_m
    assert isinstance(boat.setpoint, PoseSetpoint) and boat.setpoint.progress.target.north_m == pytest.approx(
        300.0, abs=0.01
    )
    sail(boat, [other], 60.0)
    assert boat.away_m(*place) < 0.3, "it holds its place meanwhile"
    other.silent = True
    boat.step(460.0)
    assert boat.status.traffic == () and boat.nav.surge_mps > 0.9


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.sweep) for seed in range(1, 40))])
def test_whatever_swarms_around_it_the_boat_is_steered(make_boat: Callable[..., Boat], seed: int) -> None:
    """Vessels of all kinds on all courses, a bent mission, a new route, a fence in half the cases: always a setpoint
    that is numbers."""
    random = Random(seed)
    boat = make_boat(
        **PATH,
        CA_ACTION=float(random.choice((2, 3))),
        PATH_KIND=float(random.randrange(4)),
        WP_LAW=float(seed % 5 == 4),
    )
    if seed % 2:
        fence(boat, inside=[((-90.0, -110.0), (210.0, -110.0), (210.0, 110.0), (-90.0, 110.0))])
    boat.upload((60.0, 0.0), (60.0, 50.0), (120.0, 50.0), (0.0, 0.0))
    armed_in(boat, ModeId.MISSION)
    others = [
        Other(
            boat,
            random.uniform(-100, 200),
            random.uniform(-100, 150),
            random.gauss(0, 1),
            random.gauss(0, 1),
            231_000_000 + n,
            status=random.choice((0, 5, 7, None)),
            bow_m=random.choice((0.0, 4.0, 60.0, None)),
        )
        for n in range(12)
    ]
    for part in range(8):
        seen = sail(boat, others, 15.0)
        assert all(
            math.isfinite(value) for value in (boat.nav.north_m, boat.nav.east_m, boat.nav.yaw_rad, seen["slowest_mps"])
        )
        assert boat.nav.surge_mps <= 1.05
        if part == 4:
            boat.upload((100.0, -40.0), (0.0, 0.0))
    assert "mode_failed" not in boat.names()


def test_stopped_for_a_long_ship_it_waits_until_she_has_passed(make_boat: Callable[..., Boat]) -> None:
    """Her circle reaches the boat long before her hull does; at her nearest she comes no nearer, but her side is long
    yet: 300 m, the antenna 225 m from the bow."""
    boat = under_way(make_boat, 500.0, CA_ACTION=3)
    ship = Other(
        boat, boat.nav.north_m + 200.0, -750.0, 0.0, 3.0, bow_m=225.0, stern_m=75.0, port_m=20.0, starboard_m=20.0
    )
    least_m = math.inf
    for n in range(3200):
        if n % 20 == 0:
            ship.speak()
        boat.tick()
        north, east = boat.nav.north_m - ship.at()[0], boat.nav.east_m - ship.at()[1]
        least_m = min(least_m, math.hypot(max(0.0, abs(north) - 20.0), max(0.0, east - 225.0, -75.0 - east)))
    assert least_m > 40.0 and boat.nav.north_m > 150.0


def test_it_does_not_sail_on_beside_a_vessel_that_is_too_near(make_boat: Callable[..., Boat]) -> None:
    boat = under_way(make_boat, CA_ACTION=3)
    other = Other(boat, boat.nav.north_m, 8.0, 1.0, 0.0)
    sail(boat, [other], 60.0)
    assert other.gap_m() > CLEAR_M
