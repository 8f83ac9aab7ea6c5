"""Safety margins of made-up voyages: each property is violated where it should be, and nowhere else."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from companion.config.vessel import find, load
from sitl.obstacles import Obstacles, RoundObstacle, Wall
from sitl.scenarios.measure import EventRow
from sitl.scenarios.safety import PROPERTIES, Margin, margins_of, violated
from sitl.scenarios.voyage import Leader, Voyage
from sitl.traffic import ScriptedVessel

REVOLT = load(find("revolt"))  # 3 m long, 0.72 m wide
HALF_M = 0.5 * REVOLT.length_m
T_S = np.arange(0.0, 200.0, 0.1)
SQUARE = ((50.0, -50.0), (50.0, 50.0), (-50.0, 50.0), (-50.0, -50.0))


def voyage(mode: str = "Mission", speed_mps: float = 0.2) -> Voyage:
    """North from home, armed from 1 s on."""
    still = np.zeros_like(T_S)
    return Voyage(
        config=REVOLT,
        parameters={"CA_DIST": 10.0, "FOLL_MIN_DIST": 12.0, "WP_SPEED": 0.6},
        runaways=[False] * len(REVOLT.thrusters),
        t_s=T_S,
        north_m=speed_mps * T_S,
        east_m=still,
        yaw_rad=still,
        forces_n=np.zeros((len(T_S), len(REVOLT.thrusters))),
        contact_mps=np.full(len(T_S), math.nan),
        mode=np.full(len(T_S), mode),
        armed=T_S >= 1.0,
        desired_m=np.column_stack([speed_mps * T_S, still]),
        events=[],
        fences=[],
        ordered_s=0.0,
        obstacles=Obstacles(),
        traffic=(),
        leaders=[],
    )


def margin(of: Voyage, name: str) -> float:
    found = {one.name: one for one in margins_of(of)}
    assert found[name].unit
    return found[name].value


def test_a_voyage_in_empty_water_has_few_properties_and_violates_none() -> None:
    found = margins_of(voyage())
    assert {one.name for one in found} == {"headway", "circling", "disarmed"} and not violated(found)
    assert [one.name for one in found] == [name for name in PROPERTIES if name in {"headway", "circling", "disarmed"}]


def test_a_margin_that_is_no_number_is_violated() -> None:
    assert [one.name for one in violated([Margin("fence", math.nan, "m", 1.0, 0.0)])] == ["fence"]


def test_the_bow_at_the_fence() -> None:
    to_m = 0.2 * float(T_S[-1])
    fenced = replace(voyage(), fences=[(0.0, SQUARE)])
    assert margin(fenced, "fence") == pytest.approx(50.0 - to_m - HALF_M, abs=0.05)
    over = replace(fenced, north_m=fenced.north_m + 12.0)
    assert margin(over, "fence") == pytest.approx(38.0 - to_m - HALF_M, abs=0.05) and violated(margins_of(over))
    assert margin(replace(over, fences=[(0.0, SQUARE), (199.0, SQUARE)]), "fence") < 0.0, "only the newest fence counts"


def test_water_to_obstacles_and_walls() -> None:
    water = Obstacles()
    water.round.append(RoundObstacle(20.0, 3.0, 1.0))
    assert margin(replace(voyage(), obstacles=water), "obstacles") == pytest.approx(2.0 - 0.5 * REVOLT.beam_m, abs=0.02)
    water.walls.append(Wall((39.0, -5.0), (39.0, 5.0)))
    assert margin(replace(voyage(), obstacles=water), "obstacles") <= 0.0


def test_another_vessel_nearer_than_half_the_distance_that_the_boat_keeps() -> None:
    def passing(east_m: float) -> Voyage:
        other = ScriptedVessel(1, "NORA", ((0.0, 100.0, east_m), (100.0, 0.0, east_m)))
        return replace(voyage(), traffic=(other,))

    gap_m = 12.0 - 1.5 - 0.5 * REVOLT.beam_m
    assert margin(passing(12.0), "traffic") == pytest.approx(gap_m - 5.0, abs=0.05)
    assert margin(passing(6.0), "traffic") < 0.0


def test_the_leaders_distance() -> None:
    leader = Leader(T_S, 0.2 * T_S + 14.0, np.zeros_like(T_S))
    assert margin(replace(voyage("Follow"), leaders=[leader]), "leader") == pytest.approx(2.0, abs=1e-6)


def test_a_berth_touched_hard() -> None:
    speeds = np.full(len(T_S), math.nan)
    speeds[1000:] = 0.25
    assert margin(replace(voyage("Dock"), contact_mps=speeds), "contact") == pytest.approx(-0.05)


def test_a_boat_that_stands_makes_no_headway_unless_it_waits_or_has_arrived() -> None:
    standing = voyage(speed_mps=0.01)
    assert margin(standing, "headway") < 0.0
    for name in ("obstacle_stops", "bridge_silent", "thrust_lost", "mission_ended"):
        waits = replace(standing, events=[EventRow(float(t), name, "") for t in range(1, 200, 30)])
        assert "headway" not in {one.name for one in margins_of(waits)}
    assert "headway" not in {one.name for one in margins_of(voyage("Hold", 0.01))}


@pytest.mark.parametrize(("mode", "counts"), [("Hold", True), ("Follow", True), ("Circle", False), ("Manual", False)])
def test_circles_count_in_modes_that_sail_none(mode: str, counts: bool) -> None:
    turning = replace(voyage(mode), yaw_rad=math.tau * T_S / 30.0)
    names = {one.name: one.value for one in margins_of(turning)}
    assert (names.get("circling", 1.0) == pytest.approx(-0.5)) is counts


def test_thrust_of_a_disarmed_boat_but_not_that_of_a_propeller_that_runs_away() -> None:
    forces = np.zeros((len(T_S), len(REVOLT.thrusters)))
    forces[1500:, 0] = 0.5 * REVOLT.thrusters[0].max_n
    over = replace(voyage(), armed=T_S < 100.0, forces_n=forces)
    assert margin(over, "disarmed") == pytest.approx(0.02 - 0.5)
    assert margin(replace(over, runaways=[True, False, False]), "disarmed") == pytest.approx(0.02)
    assert margin(replace(over, forces_n=np.roll(forces, -1500, axis=0) * (T_S[:, None] < 101.0)), "disarmed") > 0.0


def drifting(from_s: float) -> Voyage:
    off = np.where(from_s < T_S, 0.2 * (T_S - from_s), 0.0)
    return replace(voyage("Hold", 0.0), east_m=off)


def test_a_hold_that_drives_off_once_it_had_settled() -> None:
    assert margin(drifting(300.0), "drive_off") == pytest.approx(9.0)
    assert margin(drifting(100.0), "drive_off") == pytest.approx(9.0 - 0.2 * (T_S[-1] - 100.0), abs=1e-6)
    short = drifting(0.0)
    only_begun = replace(short, mode=np.where(T_S < 25.0, "Hold", "Manual"))
    assert "drive_off" not in {one.name for one in margins_of(only_begun)}


def test_a_point_that_hold_moves_to_takes_time_to_come_to() -> None:
    """Obstacles moved the point of a boat with an outboard by 19 m, and its Hold counted as driven off."""
    point = np.zeros((len(T_S), 2))
    point[T_S >= 60.0] = 0.0, 40.0
    sails = np.clip(1.5 * (T_S - 60.0), 0.0, 40.0)
    assert margin(replace(voyage("Hold", 0.0), desired_m=point, east_m=sails), "drive_off") == pytest.approx(9.0)
    stays = replace(voyage("Hold", 0.0), desired_m=point)
    assert margin(stays, "drive_off") == pytest.approx(9.0 - 40.0)


@pytest.mark.parametrize("name", ["rescuerunner", "sailbot"])
def test_a_boat_that_holds_by_coming_back_has_its_alarm_circle(name: str) -> None:
    boat = load(find(name))
    alarm_m = boat.parameters["DP_ALARM_R"]
    idle = np.zeros((len(T_S), 1))
    off = replace(drifting(0.0), config=boat, parameters=boat.parameters, forces_n=idle, runaways=[False])
    assert margin(off, "drive_off") == pytest.approx(alarm_m - 0.2 * T_S[-1], abs=1e-6)


@pytest.mark.parametrize(("end_m", "home"), [(1.0, True), (40.0, False)])
def test_a_boat_that_does_not_come_home(end_m: float, home: bool) -> None:
    north_m = np.interp(T_S, [0.0, 20.0, 100.0, 200.0], [0.0, 20.0, end_m, end_m])
    returning = replace(voyage("RTL"), north_m=north_m, mode=np.where(T_S < 20.0, "Mission", "RTL"))
    assert (margin(returning, "return") > 0.0) is home
    idle = np.zeros((len(T_S), 1))
    boat = load(find("sailbot"))
    sailing = replace(returning, config=boat, parameters=boat.parameters, forces_n=idle, runaways=[False])
    armed_m = 1.0  # where it was armed is home
    assert margin(sailing, "return") == pytest.approx(boat.parameters["DP_WATCH_R"] - (end_m - armed_m))
    late = replace(returning, mode=np.where(T_S < 150.0, "Mission", "RTL"))
    assert "return" not in {one.name for one in margins_of(late)}, "it had no time"
    elsewhere = replace(returning, ordered_s=60.0)
    assert "return" not in {one.name for one in margins_of(elsewhere)}, "it was ordered something else"
