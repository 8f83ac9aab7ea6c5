"""Follow as a mode: every vessel, its reasons, the fence, a leader at rest, the thesis's law, the last limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.core.decision import ModeId
from companion.core.setpoint import PathSetpoint, PoseSetpoint, ThrusterSetpoint, WrenchSetpoint
from companion.following.clearance import closes_too_fast
from companion.mission.plan import PlanItem, PlanKind
from tests.unit.conftest import Boat
from tests.unit.estimates import AT_REST
from tests.unit.following.lead_boat import LeadBoat
from tests.unit.following.leaders import leader_at

VESSELS = ("revolt", "aboat", "rescuerunner", "cybership2")


def following(boat: Boat, lead: LeadBoat, duration_s: float = 5.0) -> None:
    lead.run(2.0)
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s, force=True).accepted
    lead.run(duration_s)
    assert boat.status.mode is ModeId.FOLLOW


def gap_m(boat: Boat, lead: LeadBoat) -> float:
    return float(lead.ahead_m + lead.speed_mps * boat.now_s - boat.nav.north_m)


@pytest.mark.parametrize("name", VESSELS)
@pytest.mark.parametrize("law", [0, 1])
def test_every_vessel_follows(make_boat: Callable[..., Boat], name: str, law: int) -> None:
    config = load(find(name))
    boat = make_boat(config, **{**config.parameters, "FOLL_LAW": law})
    lead = LeadBoat(boat)
    lead.ahead_m, lead.speed_mps = 40.0, 0.6 * min(8.0, boat.parameters["MPC_XY_VEL_MAX"])
    following(boat, lead, 3.0)
    jet = config.thrusters[0].kind == "jet"
    if law == 1:
        assert type(boat.setpoint) is (ThrusterSetpoint if jet else WrenchSetpoint)
        return
    lead.run(90.0)
    assert isinstance(boat.setpoint, PathSetpoint) and gap_m(boat, lead) == pytest.approx(20.0, abs=1.5)
    assert boat.setpoint.progress.cross_track_error_m == pytest.approx(0.0, abs=0.3)
    assert boat.setpoint.progress.distance_to_go_m == pytest.approx(gap_m(boat, lead) - 20.0, abs=1.0)
    assert boat.setpoint.progress.target.north_m == pytest.approx(boat.nav.north_m + gap_m(boat, lead) - 20.0, abs=1.0)
    assert boat.status.mode is ModeId.FOLLOW and "mode_failed" not in boat.names()


def test_text_tells_what_it_does_beside_a_leader_at_rest(make_boat: Callable[..., Boat]) -> None:
    said = {
        name: next(mode.text for mode in make_boat(load(find(name))).supervisor.modes if mode.id is ModeId.FOLLOW)
        for name in VESSELS
    }
    assert "dynamic positioning" in said["revolt"] and "drifts" in said["rescuerunner"]
    assert all(len(text) < 200 for text in said.values())


def test_refused_without_a_leader_and_far_from_one(boat: Boat) -> None:
    boat.parameters.set("FOLL_WAIT_T", 0.0)
    boat.supervisor.arm(boat.now_s)
    assert "leader" in boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).reason
    lead = LeadBoat(boat)
    lead.ahead_m = 5200.0
    lead.run(1.0)
    outcome = boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s)
    assert not outcome.accepted and "5.2 km away" in outcome.reason


def test_a_leader_at_rest_is_lain_by_in_dynamic_positioning(boat: Boat) -> None:
    lead = LeadBoat(boat)
    lead.ahead_m, lead.speed_mps = 22.0, 0.0
    following(boat, lead, 60.0)
    assert isinstance(boat.setpoint, PoseSetpoint) and gap_m(boat, lead) == pytest.approx(20.0, abs=0.3)
    assert boat.helm.mode.stuck_s(boat.now_s) is None


@pytest.mark.parametrize("speed_mps", [0.4, 1.8])
def test_a_boat_too_fast_beside_a_leader_at_rest_stops_before_it_goes_to_its_place(
    make_boat: Callable[..., Boat], speed_mps: float
) -> None:
    """It turned round to that place at the speed that it had, on the thrust that turns it: at 2.7 m/s."""
    config = load(find("otter"))
    boat = make_boat(config, **config.parameters)
    lead = LeadBoat(boat)
    lead.ahead_m, lead.speed_mps = 17.5, 0.0
    lead.run(2.0)
    assert boat.supervisor.arm(boat.now_s, force=True).accepted
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    boat.nav = replace(boat.nav, surge_mps=speed_mps, north_mps=speed_mps)
    lead.tick()
    assert isinstance(boat.setpoint, PathSetpoint) and boat.setpoint.progress.place is not None
    stops = boat.setpoint.progress.place.north_m > 5.0  # where a stop would bring it
    assert stops == (speed_mps > 1.2)


def test_a_jet_at_rest_has_no_thrust(make_boat: Callable[..., Boat]) -> None:
    config = load(find("rescuerunner"))
    boat = make_boat(config, **config.parameters)
    lead = LeadBoat(boat)
    lead.ahead_m, lead.speed_mps = 22.0, 0.0
    following(boat, lead, 10.0)
    assert isinstance(boat.setpoint, WrenchSetpoint) and boat.setpoint.wrench.surge_n == 0.0


def fenced(boat: Boat) -> None:
    """Inside a square of 120 m around its home."""
    items = []
    for seq, corner in enumerate([(-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0)]):
        lat_deg, lon_deg = boat.point(*corner)
        items.append(PlanItem(seq, 5001, 0, 4.0, 0.0, 0.0, 0.0, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0))
    boat.plans.replace(PlanKind.FENCE, items)


def test_the_fence_is_kept_whatever_the_leader_does(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(GF_ACTION=2)
    fenced(boat)
    lead = LeadBoat(boat)
    following(boat, lead, 5.0)
    furthest_m = 0.0
    for _ in range(3000):
        lead.tick()
        furthest_m = max(furthest_m, boat.nav.north_m)
    assert gap_m(boat, lead) > 60.0 and 50.0 < furthest_m < 60.0
    assert "follow_waits" in boat.names() and boat.status.mode is ModeId.FOLLOW
    lead.ahead_m -= gap_m(boat, lead) - 10.0  # it comes back
    lead.run(1.0)
    assert furthest_m < 60.0


def test_each_wait_inside_the_fence_is_said(make_boat: Callable[..., Boat]) -> None:
    """The second one within 10 s was not: the last words were that it went on, and it stood still."""
    boat = make_boat(GF_ACTION=2)
    fenced(boat)
    lead = LeadBoat(boat)
    following(boat, lead, 5.0)
    while "follow_waits" not in boat.names():
        lead.tick()
    lead.ahead_m -= 6.0
    lead.run(3.0)
    lead.ahead_m += 5.6
    lead.run(2.0)
    told = [name for name in boat.names() if name in ("follow_waits", "follow_goes_on")]
    assert told == ["follow_waits", "follow_goes_on", "follow_waits"]
    assert isinstance(boat.setpoint, PoseSetpoint) and boat.status.mode is ModeId.FOLLOW


@pytest.mark.parametrize(("name", "leader_mps"), [("revolt", 0.5), ("rescuerunner", 3.0)])
def test_a_zone_that_the_leader_passes_through_is_gone_round(
    make_boat: Callable[..., Boat], name: str, leader_mps: float
) -> None:
    """It waited before the zone for ever."""
    config = load(find(name))
    boat = make_boat(config, **{**config.parameters, "GF_ACTION": 2.0})
    boat.fence((60.0, -25.0), (60.0, 20.0), (80.0, 20.0), (80.0, -25.0), keep_out=True)
    lead = LeadBoat(boat)
    lead.speed_mps = leader_mps
    following(boat, lead, 5.0)
    for _ in range(4000):
        lead.tick()
        assert not (60.0 < boat.nav.north_m < 80.0 and -25.0 < boat.nav.east_m < 20.0)
    assert gap_m(boat, lead) == pytest.approx(20.0, abs=3.0) and abs(boat.nav.east_m) < 2.0
    told = [text for text in boat.texts() if text.startswith("Follow")]
    assert any(text.startswith("Follow goes round the fence: ") for text in told)
    assert told[-1] == "Follow: going on"


def test_before_a_zone_without_a_way_round_the_boat_waits(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(GF_ACTION=2)
    fenced(boat)
    items = list(boat.plans.items(PlanKind.FENCE))
    boat.fence((20.0, -70.0), (20.0, 70.0), (30.0, 70.0), (30.0, -70.0), keep_out=True)
    both = [*items, *boat.plans.items(PlanKind.FENCE)]
    boat.plans.replace(PlanKind.FENCE, [replace(item, seq=seq) for seq, item in enumerate(both)])
    lead = LeadBoat(boat)
    following(boat, lead, 100.0)
    assert boat.nav.north_m < 20.0 and gap_m(boat, lead) > 35.0
    assert "follow_waits" in boat.names() and "follow_goes_round" not in boat.names()


def test_gone_on_with_after_a_failsafe_had_it_in_neutral(boat: Boat) -> None:
    lead = LeadBoat(boat)
    following(boat, lead)
    boat.helm.resume(boat.now_s)
    lead.run(2.0)
    assert isinstance(boat.setpoint, PathSetpoint) and boat.status.mode is ModeId.FOLLOW


def test_a_boat_that_cannot_make_way_is_said_to_be_stuck(boat: Boat) -> None:
    lead = LeadBoat(boat)
    lead.ahead_m, lead.speed_mps = 60.0, 0.5
    following(boat, lead)
    boat.pinned = True
    lead.run(90.0)
    assert "no_headway" in boat.names()
    assert any(text.startswith("Follow: cannot keep up") for text in boat.texts())


@pytest.mark.parametrize("limit", ["MPC_XY_VEL_MAX", "FLW_TGT_MAX_VEL"])
def test_a_boat_at_the_limit_of_its_speed_says_that_the_leader_leaves_it_behind(boat: Boat, limit: str) -> None:
    boat.parameters.set(limit, 0.8)
    lead = LeadBoat(boat)
    lead.ahead_m, lead.speed_mps = 22.0, 1.0
    following(boat, lead, 60.0)
    assert any(text.startswith("Follow: cannot keep up") for text in boat.texts())
    lead.speed_mps, lead.ahead_m = 0.5, lead.ahead_m + 0.5 * boat.now_s
    lead.run(60.0)
    assert "Follow: catching up" in boat.texts() and boat.status.mode is ModeId.FOLLOW


def test_time_to_collision_counts_only_the_boats_own_way_towards_the_leader() -> None:
    nav = replace(AT_REST, surge_mps=4.0, north_mps=4.0)
    assert closes_too_fast(nav, leader_at(18.0), 12.0, 2.0)
    assert not closes_too_fast(nav, leader_at(24.0), 12.0, 2.0)
    assert not closes_too_fast(nav, leader_at(18.0, speed_mps=4.0), 12.0, 2.0), "it goes as fast"
    assert not closes_too_fast(nav, leader_at(0.0, 14.0), 12.0, 2.0), "abeam"
    assert not closes_too_fast(AT_REST, leader_at(14.0, speed_mps=-4.0), 12.0, 2.0), "a boat at rest brakes nothing"
    assert math.isfinite(closes_too_fast(nav, leader_at(), 12.0, 2.0)), "in one place"
