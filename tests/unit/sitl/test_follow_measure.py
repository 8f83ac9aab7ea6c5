"""Figures of following against tracks in closed form, and against shapely's projections."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from shapely import LineString, Point

from sitl.scenarios.follow_measure import Chase, LeaderTrack, variation_1ps

DT_S, SPEED_MPS = 0.05, 8.0
Place = tuple[float, float, float]  # north, east, heading


def hairpin(arc_m: float, radius_m: float = 5.0) -> Place:
    """North for 400 m, half a circle to starboard, and south."""
    bend_m = math.pi * radius_m
    if arc_m < 400.0:
        return arc_m, 0.0, 0.0
    if arc_m < 400.0 + bend_m:
        turned = (arc_m - 400.0) / radius_m
        return 400.0 + radius_m * math.sin(turned), radius_m * (1.0 - math.cos(turned)), turned
    return 400.0 - (arc_m - 400.0 - bend_m), 2.0 * radius_m, math.pi


def chase(
    folder: Path,
    way: Callable[[float], Place],
    gap_m: Callable[[float], float],
    off_m: Callable[[float], float],
    duration_s: float,
) -> Chase:
    """A leader along a way at 8 m/s, whose receiver is 1 m off to the north, and a follower on it with a gap and an
    offset, whose own is 2 m off to the east."""
    truth, leader, ticks = (
        ["t_s,north_m,east_m,yaw_rad,surge_mps,sway_mps"],
        [],
        ["t_s,north_m,east_m,mode,jet_azimuth_rad"],
    )
    leader.append("t_s,north_m,east_m,yaw_rad,speed_mps,surge_mps,yaw_rate_radps,fix_north_m,fix_east_m")
    for k in range(round(duration_s / DT_S)):
        t, arc = k * DT_S, 50.0 + k * DT_S * SPEED_MPS
        n, e, yaw = way(arc)
        rate = (way(arc + 0.2)[2] - yaw) / (0.2 / SPEED_MPS)
        leader.append(f"{t:.3f},{n},{e},{math.remainder(yaw, math.tau)},8.0,8.0,{rate},{n + 1.0},{e}")
        n, e, yaw = way(arc - gap_m(t))
        n, e = n - off_m(t) * math.sin(yaw), e + off_m(t) * math.cos(yaw)
        truth.append(f"{t:.3f},{n},{e},{math.remainder(yaw, math.tau)},8.0,0.0")
        ticks.append(f"{t:.3f},{n},{e + 2.0},Follow,{0.1 * (-1) ** k}")
    for name, lines in (("truth", truth), ("leader", leader), ("ticks", ticks)):
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Chase(folder)


def test_through_a_hairpin(tmp_path: Path) -> None:
    """The way back lies 10 m beside the way there, nearer than the gap: it does not count."""
    run = chase(tmp_path, hairpin, lambda t: 20.0, lambda t: 1.5, 80.0)
    assert run.gap_m == pytest.approx(20.0, abs=0.1) and run.off_m == pytest.approx(1.5, abs=0.05)
    (bend,) = run.bends
    assert bend.begin_s == pytest.approx(350.0 / SPEED_MPS, abs=0.1) and bend.end_m - bend.begin_m == pytest.approx(
        math.pi * 5.0, abs=0.6
    )
    assert run.through_s[0] == pytest.approx((350.0 + math.pi * 5.0 + 20.0) / SPEED_MPS, abs=0.15)
    assert run.circles() == 0.0 and run.recovery_s(20.0) == (0.0,)


def test_no_follower_is_in_its_place_while_the_leader_comes_back_past_it(tmp_path: Path) -> None:
    """From where the follower's place on the hairpin, 20 m astern, is within 15 m of the leader, until it no longer is."""
    run = chase(tmp_path, hairpin, lambda t: 20.0, lambda t: 0.0, 80.0)
    ((begin_s, end_s),) = run.crowdings(20.0, 15.0)
    apart_m = [math.dist(hairpin(arc)[:2], hairpin(arc - 20.0)[:2]) for arc in np.arange(380.0, 450.0, 0.1)]
    crowded = 380.0 + 0.1 * np.flatnonzero(np.array(apart_m) < 15.0)
    assert (begin_s, end_s) == pytest.approx(
        ((crowded[0] - 50.0) / SPEED_MPS, (crowded[-1] - 50.0) / SPEED_MPS), abs=0.1
    )
    (rejoin,) = run.rejoins(20.0, 15.0)
    assert rejoin[:2] == (begin_s, end_s) and rejoin[2] < 1.5, (
        "the receivers' errors are as large as the bend is narrow"
    )
    assert run.recovery_s(20.0, 15.0) == (), "the bend is judged by that alone"
    wide = chase(tmp_path, lambda arc: hairpin(arc, 40.0), lambda t: 20.0, lambda t: 0.0, 80.0)
    assert wide.crowdings(20.0, 15.0) == wide.rejoins(20.0, 15.0) == ()


def test_a_follower_that_makes_room_is_back_where_it_is_behind_its_leader_again(tmp_path: Path) -> None:
    """It leaves the track before the hairpin, and comes to that beyond it 6 s after the leader is far enough past."""
    left_s, back_s = 45.0, 60.0
    run = chase(tmp_path, hairpin, lambda t: 20.0, lambda t: 10.0 if left_s < t < back_s else 0.0, 80.0)
    ((_, end_s, after_s),) = run.rejoins(20.0, 15.0)
    assert end_s + after_s == pytest.approx(back_s, abs=0.1)


def test_what_the_receivers_make_of_it(tmp_path: Path) -> None:
    """Northwards a leader's error to the north opens the gap, a follower's error to the east puts it to starboard."""
    run = chase(tmp_path, hairpin, lambda t: 20.0, lambda t: 0.0, 80.0)
    before, after = run.t < 40.0, run.t > 55.0
    assert run.known_gap_m[before] == pytest.approx(21.0, abs=0.05) and run.known_off_m[before] == pytest.approx(
        2.0, abs=0.05
    )
    assert run.known_gap_m[after] == pytest.approx(19.0, abs=0.05) and run.known_off_m[after] == pytest.approx(
        -2.0, abs=0.05
    )


def test_recovery_is_counted_from_the_end_of_the_bend(tmp_path: Path) -> None:
    out_s = (350.0 + math.pi * 5.0 + 20.0) / SPEED_MPS
    run = chase(
        tmp_path,
        hairpin,
        lambda t: 20.0 if t < out_s - 2.0 else 20.0 + 12.0 * math.exp(-(t - out_s) / 3.0),
        lambda t: 0.0,
        80.0,
    )
    known_bias = -1.0  # of the receivers, southwards
    late_s = brentq(
        lambda t: SPEED_MPS * t - 12.0 * math.exp(-t / 3.0), 0.0, 10.0
    )  # it comes out so much later than with a gap of 20 m
    assert run.recovery_s(20.0)[0] == pytest.approx(3.0 * math.log(12.0 / (2.0 - known_bias)) - late_s, abs=0.15)
    stuck = chase(tmp_path, hairpin, lambda t: 20.0 if t < out_s else 26.0, lambda t: 0.0, 80.0)
    assert stuck.recovery_s(20.0) == (math.inf,)


def dogleg(arc_m: float, radius_m: float = 5.0, between_m: float = 30.0) -> Place:
    """North for 400 m, a quarter of a circle to starboard, east for 30 m, a quarter to port, and north."""
    quarter_m = 0.5 * math.pi * radius_m
    if arc_m < 400.0 + quarter_m:
        return hairpin(arc_m, radius_m)
    arc_m -= 400.0 + quarter_m
    if arc_m < between_m:
        return 400.0 + radius_m, radius_m + arc_m, 0.5 * math.pi
    turned = min(0.5 * math.pi, (arc_m - between_m) / radius_m)
    north_m = 400.0 + 2.0 * radius_m - radius_m * math.cos(turned) + max(0.0, arc_m - between_m - quarter_m)
    return north_m, radius_m + between_m + radius_m * math.sin(turned), 0.5 * math.pi - turned


def test_no_recovery_is_asked_where_the_leader_turns_again_before(tmp_path: Path) -> None:
    close = chase(tmp_path, dogleg, lambda t: 40.0, lambda t: 0.0, 80.0)
    assert len(close.bends) == 2 and close.recovery_s(40.0) == (0.0,)
    apart = chase(tmp_path, lambda arc_m: dogleg(arc_m, between_m=80.0), lambda t: 40.0, lambda t: 0.0, 80.0)
    assert apart.recovery_s(40.0) == (0.0, 0.0)


def test_projection_against_shapely() -> None:
    rng = np.random.default_rng(3)
    arc = np.arange(0.0, 300.0, 0.3)
    north, east = arc, 25.0 * np.sin(arc / 40.0)
    track = LeaderTrack(north, east, math.atan2(25.0 / 40.0, 1.0))
    line = LineString(np.column_stack([track.north, track.east]))
    for _ in range(200):
        at = rng.uniform(20.0, 280.0)
        place = Point(at + rng.normal(0.0, 3.0), 25.0 * math.sin(at / 40.0) + rng.normal(0.0, 3.0))
        s, off, course = track.nearest(place.x, place.y, 0.0, math.inf)
        assert s == pytest.approx(line.project(place), abs=0.02) and abs(off) == pytest.approx(
            line.distance(place), abs=1e-3
        )
        foot = line.interpolate(s)
        assert off * math.cos(course) == pytest.approx(place.y - foot.y, abs=0.05)


def test_a_place_far_off_finds_the_track_again(tmp_path: Path) -> None:
    run = chase(tmp_path, hairpin, lambda t: 20.0, lambda t: 0.0 if not 20.0 < t < 21.0 else 60.0, 40.0)
    assert run.gap_m[run.t > 21.5] == pytest.approx(20.0, abs=0.1)


def test_variation_of_the_nozzle(tmp_path: Path) -> None:
    chase(tmp_path, hairpin, lambda t: 20.0, lambda t: 0.0, 10.0)
    assert variation_1ps(tmp_path, "jet_azimuth_rad", 0.4, 2.0) == pytest.approx(0.2 / 0.4 / DT_S)


def test_circles_are_turns_that_the_leader_did_not_make(tmp_path: Path) -> None:
    run = chase(tmp_path, hairpin, lambda t: 20.0, lambda t: 0.0, 80.0)
    run.yaw = run.yaw + np.where(run.t > 30.0, math.tau * np.minimum(1.0, (run.t - 30.0) / 10.0), 0.0)
    assert run.circles() == 1.0


def test_swing_after_a_bend(tmp_path: Path) -> None:
    """From side to side by twice the amplitude; not counted before the bend, nor until 20 s after it."""
    run = chase(tmp_path, hairpin, lambda t: 20.0, lambda t: 0.0, 90.0)
    (bend,) = run.bends
    assert run.swing_after_bends() == pytest.approx(0.0, abs=1e-6)
    wide, settled = np.sin(run.t), run.t >= bend.end_s + 20.0
    run.yaw = run.yaw + np.where(settled, 0.3, 1.0) * wide
    assert run.swing_after_bends() == pytest.approx(0.6, abs=0.01)
    run.yaw = np.where(settled, run.leader_yaw, run.yaw)
    assert run.swing_after_bends() == 0.0


def test_a_leader_that_never_turns_leaves_no_swing(tmp_path: Path) -> None:
    run = chase(tmp_path, lambda arc_m: (arc_m, 0.0, 0.0), lambda t: 20.0, lambda t: 0.0, 60.0)
    assert not run.bends
    assert math.isnan(run.swing_after_bends())
