"""The lead boat on its script, its wake, what its sensors say, and several worlds around it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from companion.config.vessel import ConfigError, find, load
from companion.core.geodesy import LocalFrame
from sitl.lead_boat import STEP_HZ, LeadBoat
from sitl.leader_script import SCRIPTS, script
from sitl.noise import stream
from sitl.sensors import GRADES, CommonWander
from sitl.shared_sea import LeadBoatConfig, SharedSea, build_shared_sea
from sitl.wake import Wake
from sitl.world import World, WorldConditions

VESSEL = load(find("rescuerunner"))


def sailed(text: str, duration_s: float, **arguments: object) -> tuple[LeadBoat, list[tuple[float, ...]]]:
    """(boat, rows of time, surge, yaw rate, heading with its turns counted)."""
    boat = LeadBoat("leader", VESSEL.home, script(text), **arguments)  # type: ignore[arg-type]
    boat.depart(0.0)
    rows, turned = [], 0.0
    for _ in range(round(duration_s * STEP_HZ)):
        boat.step()
        turned += boat.hull.turn_radps / STEP_HZ
        rows.append((boat.t_s, boat.hull.surge_mps, boat.hull.yaw_rate_radps, turned))
    return boat, rows


@pytest.mark.parametrize(("speed", "astern"), [(8.2, -2.0), (14.0, -2.0), (1.2, -0.3)])
@pytest.mark.parametrize("name", ["reverse", "lively"])
def test_a_slow_leader_goes_astern_no_faster_than_its_follower_can_get_away(
    name: str, speed: float, astern: float
) -> None:
    """Behind a leader of 1.4 m/s that came astern at 2 m/s, no boat of 2 m/s kept its distance."""
    assert min(order.speed_mps for order in SCRIPTS[name](speed)) == pytest.approx(astern)


@pytest.mark.parametrize("speed", [4.0, 8.2, 14.0])
def test_the_thesis_run_at_its_speeds(speed: float) -> None:
    _, rows = sailed(f"thesis@{speed}", 160.0)
    at = {round(row[0], 2): row for row in rows}
    assert at[60.0][1] == pytest.approx(speed, abs=0.05)
    assert at[74.0][3] == pytest.approx(0.0, abs=0.01)
    assert math.degrees(at[110.0][3]) == pytest.approx(90.0, abs=1.0), "the sharp turn"
    assert math.degrees(at[160.0][3]) == pytest.approx(150.0, abs=1.0), "and the gentle one"
    assert math.degrees(max(row[2] for row in rows if row[0] < 110.0)) == pytest.approx(15.0, abs=1.0)
    assert math.degrees(max(row[2] for row in rows if row[0] > 120.0)) == pytest.approx(5.0, abs=1.0)


def test_stop_and_astern() -> None:
    _, rows = sailed("reverse", 115.0)
    at = {round(row[0], 2): row for row in rows}
    assert at[88.0][1] == pytest.approx(0.0, abs=0.05) and at[105.0][1] == pytest.approx(-2.0, abs=0.05)


@pytest.mark.parametrize("name", sorted(SCRIPTS))
def test_it_moves_like_a_boat(name: str) -> None:
    """No step of speed or turn; accelerations that four tonnes and 13 kN allow."""
    _, rows = sailed(f"{name}@14", 260.0)
    for before, after in itertools.pairwise(rows):
        assert abs(after[1] - before[1]) * STEP_HZ < 3.5 and abs(after[2] - before[2]) * STEP_HZ < 0.14


def test_before_it_departs_it_lies_still() -> None:
    boat = LeadBoat("leader", VESSEL.home, script("straight"), start=(5.0, -3.0, 1.0))
    for _ in range(100):
        boat.step()
    assert (boat.hull.north_m, boat.hull.east_m, boat.hull.yaw_rad) == (5.0, -3.0, 1.0) and boat.departed_s is None


def test_its_sensors_have_errors_of_their_own() -> None:
    boat, _ = sailed("straight", 30.0, seed=3)
    fix = boat.fix
    assert fix is not None and fix.lat_deg is not None and fix.lon_deg is not None and fix.t_s == pytest.approx(30.0)
    north_m, east_m = LocalFrame(VESSEL.home.lat_deg, VESSEL.home.lon_deg).to_ned(fix.lat_deg, fix.lon_deg)
    off_m = math.hypot(north_m - boat.hull.north_m, east_m - boat.hull.east_m)
    assert 0.05 < off_m < 5.0 and fix.north_mps == pytest.approx(8.2, abs=0.4)
    assert 1e-4 < abs(fix.yaw_rad - boat.hull.yaw_rad) < math.radians(10.0)
    again, _ = sailed("straight", 30.0, seed=3)
    assert again.fix == fix
    other, _ = sailed("straight", 30.0, seed=4)
    assert other.fix != fix
    boat.faults.add("gnss_lost")
    for _ in range(5):
        boat.step()
    assert boat.fix is not None and boat.fix.lat_deg is None
    boat.faults.discard("gnss_lost")
    for _ in range(5):
        boat.step()
    frozen = boat.fix
    boat.faults.add("gnss_frozen")
    for _ in range(50):
        boat.step()
    assert frozen.lat_deg is not None and boat.fix == replace(frozen, t_s=frozen.t_s + 1.0), "with a fresh time"


def test_scripts_that_do_not_exist_are_said() -> None:
    for text in ("waltz", "thesis@fast", "thesis@40"):
        with pytest.raises(ConfigError, match="leader"):
            script(text)


# --- wake ---


def wake(speed: float = 8.2) -> Wake:
    """Of a boat that has come from the south along north 0 … 200."""
    left = Wake()
    for i in range(int(200.0 / (speed * 0.02))):
        left.leave(i * speed * 0.02, 0.0, speed, 0.0, 0.02)
    return left


def test_the_wake_is_calm_astern_and_rough_outside() -> None:
    behind = wake()
    calm = [behind.elevation_m(180.0, 0.1 * k) for k in range(-40, 41)]
    assert max(map(abs, calm)) == 0.0
    outside = [behind.elevation_m(180.0, 4.0 + 0.1 * k) for k in range(30)]
    assert 0.05 < max(outside) < 0.3
    assert behind.elevation_m(180.0, -5.5) == pytest.approx(behind.elevation_m(180.0, 5.5))
    assert behind.slope(180.0, 5.0)[1] == pytest.approx(-behind.slope(180.0, -5.0)[1])


def test_the_wake_dies_away_and_is_nowhere_else() -> None:
    behind = wake()
    assert behind.elevation_m(190.0, 5.5) > 1.5 * behind.elevation_m(140.0, 5.5) > 0.0
    assert behind.elevation_m(215.0, 5.5) == 0.0, "ahead of the boat"
    assert behind.elevation_m(20.0, 5.5) == 0.0, "long past"
    assert wake(4.0).elevation_m(180.0, 5.5) < 0.4 * behind.elevation_m(180.0, 5.5)
    assert Wake().slope(0.0, 0.0) == (0.0, 0.0)


def test_a_boat_feels_the_wake_outside_and_not_inside() -> None:
    rolls = []
    for east_m in (0.0, 5.0):
        shared_sea = build_shared_sea((LeadBoatConfig("leader", "straight@8.2", depart_s=0.0),), VESSEL.home, 1)
        shared_sea.advance(20.0)
        world = World(VESSEL, shared_sea=shared_sea)
        world.set_state(shared_sea.boats[0].hull.north_m - 45.0, east_m, 0.0, 8.2)
        roll = 0.0
        for k in range(1, 501):
            world.advance(0.01 * k)
            roll = max(roll, abs(world.waves.roll_rad))
        rolls.append(roll)
    assert rolls[0] == 0.0 and rolls[1] > math.radians(1.0)


# --- shared sea ---


def test_two_worlds_see_the_same_boat_move_once() -> None:
    shared_sea = build_shared_sea((LeadBoatConfig("leader", "straight", (30.0, 0.0, 0.0), 1.0),), VESSEL.home, 1)
    alone = build_shared_sea((LeadBoatConfig("leader", "straight", (30.0, 0.0, 0.0), 1.0),), VESSEL.home, 1)
    first, second = World(VESSEL, shared_sea=shared_sea), World(VESSEL, WorldConditions(seed=2), shared_sea=shared_sea)
    for k in range(1, 101):
        first.advance(0.05 * k)
        second.advance(0.05 * k)
    alone.advance(5.0)
    assert shared_sea.boats[0].hull.north_m == alone.boats[0].hull.north_m > 30.0
    assert shared_sea.boats[0].t_s == pytest.approx(5.0)


def relative_r95_m(share: float) -> float:
    """Of two receivers' slow and white errors over 3000 times at which they are independent of the last."""
    grade = GRADES["standalone"]
    rng = stream(1, "check")
    distances = []
    for seed in range(3000):
        common = CommonWander(share, seed)
        offsets = []
        for _ in range(2):
            shared = common.at(0.0, grade)
            own = [
                math.sqrt(1.0 - share) * rng.gauss(0.0, grade.slow_m) + rng.gauss(0.0, grade.white_m) for _ in range(2)
            ]
            offsets.append((own[0] + shared[0], own[1] + shared[1]))
        distances.append(math.dist(*offsets))
    return sorted(distances)[int(0.95 * len(distances))]


def test_two_receivers_differ_as_in_the_thesis() -> None:
    """95 % below 4.5 m with independent receivers, less with errors in common."""
    assert 3.8 < relative_r95_m(0.0) < 4.5
    assert relative_r95_m(0.6) == pytest.approx(math.sqrt(0.4) * relative_r95_m(0.0), rel=0.06)


def test_what_receivers_share_is_the_same_for_all_of_them() -> None:
    common = CommonWander(1.0, 7)
    shared_sea = SharedSea(
        [LeadBoat(name, VESSEL.home, script("straight"), common=common, seed=3) for name in ("a", "b")], common
    )
    shared_sea.advance(40.0)
    one, two = (boat.fix for boat in shared_sea.boats)
    assert one is not None and two is not None and one.lat_deg is not None and two.lat_deg is not None
    assert abs(one.lat_deg - two.lat_deg) * 111_000.0 < 6.0 * GRADES["standalone"].white_m
    assert common.at(10.0, GRADES["standalone"]) == common.at(40.0, GRADES["standalone"]), (
        "asked for the past it gives the newest"
    )
    with pytest.raises(ConfigError, match="common share"):
        CommonWander(1.5, 0)


def test_a_world_steps_as_fast_as_its_fastest_sensor() -> None:
    slow = replace(VESSEL, sensors=tuple(replace(sensor, rate_hz=10.0) for sensor in VESSEL.sensors))
    for vessel, packets in ((VESSEL, 200), (slow, 10)):
        world = World(vessel)
        port = world.open("imu", "")
        world.advance(1.0)
        assert len(port.read(1.0)) == packets
