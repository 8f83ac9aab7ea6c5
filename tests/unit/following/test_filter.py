"""The leader's filter: a boat whose way is known, through noise, loss, late messages and wild positions."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from companion.core.estimate import Leader
from companion.core.geodesy import LocalFrame
from companion.core.readings import LeaderState
from companion.following.tracker import LeaderTracker

FRAME = LocalFrame(57.63, 11.55)
SPEED_MPS, TURN_RADPS = 8.2, 0.26


def way(t_s: float, turning_s: float = 30.0) -> tuple[float, float, float]:
    """(north, east, course): straight, then round at 15°/s."""
    if t_s <= turning_s:
        return SPEED_MPS * t_s, 0.0, 0.0
    radius, course = SPEED_MPS / TURN_RADPS, TURN_RADPS * (t_s - turning_s)
    return SPEED_MPS * turning_s + radius * math.sin(course), radius * (1.0 - math.cos(course)), course


def said(
    t_s: float,
    rng: random.Random,
    *,
    noise_m: float = 0.15,
    heading: bool = True,
    velocity: bool = True,
    late_s: float = 0.1,
) -> LeaderState:
    north_m, east_m, course = way(t_s)
    lat, lon = FRAME.to_geodetic(north_m + rng.gauss(0.0, noise_m), east_m + rng.gauss(0.0, noise_m))
    state = LeaderState(t_s, t_s + late_s, "test", 7, lat, lon, accuracy_m=1.2)
    if velocity:
        state = replace(
            state,
            north_mps=SPEED_MPS * math.cos(course) + rng.gauss(0.0, 0.06),
            east_mps=SPEED_MPS * math.sin(course) + rng.gauss(0.0, 0.06),
        )
    rate = TURN_RADPS if t_s > 30.0 else 0.0
    return replace(state, yaw_rad=math.remainder(course, math.tau), yaw_rate_radps=rate) if heading else state


def off_m(leader: Leader, t_s: float) -> float:
    north_m, east_m, _ = way(t_s)
    return math.hypot(leader.north_m - north_m, leader.east_m - east_m)


def known(tracker: LeaderTracker, t_s: float) -> Leader:
    leader = tracker.leader(FRAME, t_s)
    assert leader is not None
    return leader


@pytest.mark.parametrize(
    ("rate_hz", "heading", "loss", "limit_m"),
    [(20.0, True, 0.0, 0.25), (20.0, True, 0.5, 0.3), (4.0, False, 0.0, 0.7), (1.0, False, 0.0, 2.2)],
)
def test_place_now_through_a_sharp_turn(rate_hz: float, heading: bool, loss: float, limit_m: float) -> None:
    """From messages 0.1 to 0.3 s old, some overtaken by others, at every moment between them."""
    rng = random.Random(3)
    tracker = LeaderTracker()
    messages = [
        said(i / rate_hz, rng, heading=heading, late_s=rng.uniform(0.1, 0.3)) for i in range(int(45.0 * rate_hz))
    ]
    messages = sorted((m for m in messages if rng.random() >= loss), key=lambda m: m.heard_s)
    worst, squares = 0.0, []
    for i in range(900):
        now_s = 0.05 * i
        while messages and messages[0].heard_s <= now_s:
            tracker.take(messages.pop(0))
        if now_s > 5.0:
            squares.append(off_m(known(tracker, now_s), now_s) ** 2)
            worst = max(worst, squares[-1])
    assert math.sqrt(sum(squares) / len(squares)) < limit_m and math.sqrt(worst) < 4.0 * limit_m
    assert known(tracker, 45.0).yaw_rate_radps == pytest.approx(TURN_RADPS, abs=0.05)


def test_noise_is_smoothed_and_velocity_is_had_from_positions_alone() -> None:
    rng = random.Random(5)
    tracker = LeaderTracker()
    errors = []
    for i in range(30):
        tracker.take(replace(said(float(i), rng, noise_m=2.0, heading=False, velocity=False), accuracy_m=2.0))
        if i > 12:
            leader = known(tracker, i + 0.1)
            errors.append(off_m(leader, i + 0.1))
            assert leader.speed_mps == pytest.approx(SPEED_MPS, abs=2.5)
            assert leader.yaw_rad == pytest.approx(0.0, abs=0.35)
    assert sum(errors) / len(errors) < 2.0


@pytest.mark.parametrize("rate_hz", [1.0, 4.0, 10.0])
@pytest.mark.parametrize("noise_m", [0.0, 1.5])
def test_positions_alone_do_not_make_the_velocity_swing(rate_hz: float, noise_m: float) -> None:
    """A phone that sends neither velocity nor accuracy, straight on."""
    rng = random.Random(5)
    tracker = LeaderTracker()
    for i in range(int(30.0 * rate_hz)):
        t_s = i / rate_hz
        state = said(t_s, rng, noise_m=noise_m, heading=False, velocity=False)
        tracker.take(replace(state, accuracy_m=None))
        if t_s > 15.0:
            leader = known(tracker, t_s)
            assert leader.speed_mps == pytest.approx(SPEED_MPS, abs=1.5), t_s
            assert math.atan2(leader.east_mps, leader.north_mps) == pytest.approx(0.0, abs=math.radians(12.0)), t_s


def test_a_leader_that_goes_far_keeps_its_velocity() -> None:
    """By positions alone: the plane of the filter is laid anew every 20 km."""
    tracker = LeaderTracker()
    for i in range(3000):
        lat, lon = FRAME.to_geodetic(15.0 * i, 0.0)
        tracker.take(LeaderState(float(i), float(i), "test", 7, lat, lon))
        if i > 30:
            here = tracker.leader(LocalFrame(lat, lon), float(i))
            assert here is not None and math.hypot(here.north_m, here.east_m) < 1.0, i
            assert here.speed_mps == pytest.approx(15.0, abs=0.3), i


def test_an_outlier_is_rejected_and_a_lasting_jump_accepted() -> None:
    rng = random.Random(1)
    tracker = LeaderTracker()
    for i in range(100):
        tracker.take(said(0.1 * i, rng))
    lat, lon = FRAME.to_geodetic(500.0, 300.0)
    tracker.take(replace(said(10.0, rng), lat_deg=lat, lon_deg=lon))
    assert off_m(known(tracker, 10.0), 10.0) < 0.6
    for i in range(1, 31):
        lat, lon = FRAME.to_geodetic(500.0 + 0.1 * SPEED_MPS * i, 300.0)
        tracker.take(replace(said(10.0 + 0.1 * i, rng), lat_deg=lat, lon_deg=lon))
    found = known(tracker, 13.0)
    assert math.hypot(found.north_m - 500.0 - 3.0 * SPEED_MPS, found.east_m - 300.0) < 1.0


def test_an_older_fix_changes_nothing() -> None:
    rng = random.Random(1)
    tracker = LeaderTracker()
    for i in range(50):
        tracker.take(said(0.1 * i, rng))
    before = known(tracker, 5.0)
    tracker.take(replace(said(4.0, rng), lat_deg=57.7))
    after = known(tracker, 5.0)
    assert (after.north_m, after.east_m, after.age_s) == (before.north_m, before.east_m, before.age_s)


def standing(t_s: float, north_mps: float, yaw_rad: float | None) -> LeaderState:
    lat, lon = FRAME.to_geodetic(north_mps * t_s, 0.0)
    return LeaderState(t_s, t_s, "test", 7, lat, lon, north_mps, 0.0, yaw_rad, accuracy_m=1.0)


def test_astern_is_known_from_a_heading_alone() -> None:
    for yaw, astern in ((0.0, True), (None, False)):
        tracker = LeaderTracker()
        for i in range(60):
            tracker.take(standing(0.1 * i, -2.0, yaw))
        leader = known(tracker, 6.0)
        assert leader.astern is astern and leader.speed_mps == pytest.approx(-2.0 if astern else 2.0, abs=0.1)
        assert leader.yaw_rad == pytest.approx(0.0 if astern else math.pi, abs=0.02)


@pytest.mark.parametrize(("speed", "after_s"), [(5.0, 3.0), (1.5, 45.0)])
def test_a_heading_that_points_backwards_for_long_is_not_believed(speed: float, after_s: float) -> None:
    """A leader of 5 m/s whose heading was wrong by 180 degrees seemed to go astern: it was not followed, and nothing
    was said."""
    tracker = LeaderTracker()
    for i in range(round(10.0 * after_s)):
        tracker.take(standing(0.1 * i, speed, math.pi))
    leader = known(tracker, after_s)
    assert leader.heading_lies and not leader.astern and leader.speed_mps == pytest.approx(speed, abs=0.1)
    assert leader.yaw_rad == pytest.approx(0.0, abs=0.02)
    for i in range(round(10.0 * after_s), round(10.0 * after_s) + 20):
        tracker.take(standing(0.1 * i, speed, 0.1))
    assert not known(tracker, after_s + 2.0).heading_lies
    assert known(tracker, after_s + 2.0).yaw_rad == pytest.approx(0.1, abs=0.02)


def test_a_leader_that_backs_for_20_s_is_believed() -> None:
    tracker = LeaderTracker()
    for i in range(200):
        tracker.take(standing(0.1 * i, -2.0, 0.0))
    assert known(tracker, 20.0).astern and not known(tracker, 20.0).heading_lies


def test_a_slow_leader_without_heading_keeps_its_last_course() -> None:
    tracker = LeaderTracker()
    for i in range(60):
        tracker.take(standing(0.1 * i, 3.0, None))
    for i in range(60, 200):
        lat, lon = FRAME.to_geodetic(18.0, 0.0)
        tracker.take(LeaderState(0.1 * i, 0.1 * i, "test", 7, lat, lon, 0.1, -0.2))
    assert known(tracker, 20.0).yaw_rad == pytest.approx(0.0, abs=0.2)


def test_a_leader_that_brakes_is_seen_to() -> None:
    tracker = LeaderTracker()
    north_m, speed = 0.0, 8.0
    for i in range(100):
        speed -= 0.1 if i > 60 else 0.0
        north_m += 0.1 * speed
        lat, lon = FRAME.to_geodetic(north_m, 0.0)
        tracker.take(LeaderState(0.1 * i, 0.1 * i, "test", 7, lat, lon, speed, 0.0, 0.0, 0.0, accuracy_m=1.0))
    assert known(tracker, 9.9).acceleration_mps2 == pytest.approx(-1.0, abs=0.15)
