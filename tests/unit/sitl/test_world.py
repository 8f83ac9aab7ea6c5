"""The world as a whole, through the ports of its devices alone."""

from __future__ import annotations

import hashlib
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from companion.config.vessel import ConfigError, VesselConfig, find, load
from companion.core.microcontroller_frame import BoardCommand, BoardStatus, FrameDecoder, ThrusterDemand, encode
from companion.core.ports import ByteStream
from sitl.json_physics import without_boards
from sitl.otter_equations import OtterHull
from sitl.sensors import true_imu
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions

VESSEL = load(find("revolt"))


def sail(world: World, seconds: float, throttles: tuple[float, float, float] | None = None, armed: bool = True) -> None:
    """Ten ticks a second, commands as the bridge writes them."""
    port = world.open("microcontroller", "serial:/dev/null")
    start_s = world.t_s
    for k in range(round(seconds * 10)):
        now_s = start_s + 0.1 * k
        world.advance(now_s)
        if throttles is not None:
            port.write(
                encode(BoardCommand(k % 256, armed, tuple(ThrusterDemand(throttle, 0.0) for throttle in throttles))),
                now_s,
            )
    world.advance(start_s + seconds)


def everything_printed(world: World, seconds: float, tick_s: float) -> str:
    ports = [world.open(name, "") for name in ("gnss", "imu", "microcontroller")]
    digest = hashlib.sha256()
    chunks: list[tuple[str, float, bytes]] = []
    for k in range(1, round(seconds / tick_s) + 1):
        world.advance(k * tick_s)
        chunks += [(port.name, t_s, data) for port in ports for t_s, data in port.read(k * tick_s)]
    for name, t_s, data in sorted(chunks):
        digest.update(f"{name}{t_s:.6f}".encode() + data)
    return digest.hexdigest()


def test_it_starts_at_home_and_stays_there_in_still_water() -> None:
    world = World(VESSEL)
    sail(world, 20.0)
    truth = world.truth
    assert truth.t_s == 20.0
    assert (truth.north_m, truth.east_m, truth.yaw_rad) == (0.0, 0.0, VESSEL.home.yaw_rad)


def test_a_disarmed_boat_drifts_with_the_current() -> None:
    world = World(VESSEL, WorldConditions(current="0.3@90"))
    sail(world, 300.0, (1.0, 1.0, 0.0), armed=False)
    truth = world.truth
    assert (truth.current_north_mps, truth.current_east_mps) == pytest.approx((0.0, 0.3))
    assert math.cos(truth.yaw_rad) * truth.sway_mps + math.sin(truth.yaw_rad) * truth.surge_mps == pytest.approx(
        0.3, abs=0.02
    )
    assert truth.east_m > 60.0 and abs(truth.north_m) < 1.0
    assert all(force == 0.0 for force, _ in truth.thrusters)


def test_armed_forward_thrust_moves_it_forward_at_the_speed_of_the_hull() -> None:
    world = World(replace(VESSEL, home=replace(VESSEL.home, yaw_rad=math.radians(90.0))))
    sail(world, 60.0, (0.5, 0.5, 0.0))
    truth = world.truth
    assert truth.surge_mps == pytest.approx(13.5 / 50.66, rel=1e-3)
    assert truth.east_m > 12.0 and abs(truth.north_m) < 1e-6


def test_bow_thruster_turns_it_to_starboard() -> None:
    world = World(VESSEL)
    sail(world, 5.0, (0.0, 0.0, 0.8))
    assert world.truth.yaw_rate_radps > 0.05 and world.truth.sway_mps > 0.0


def test_thrust_ends_when_commands_end() -> None:
    world = World(VESSEL)
    sail(world, 5.0, (0.8, 0.8, 0.0))
    assert world.truth.thrusters[0][0] == pytest.approx(17.28, rel=1e-3)
    sail(world, 3.0)
    assert abs(world.truth.thrusters[0][0]) < 0.1


def test_wind_pushes_it_downwind() -> None:
    world = World(VESSEL, WorldConditions(wind="6@0", seed=2))
    sail(world, 120.0)
    assert world.truth.north_m < -5.0
    assert world.truth.wind_speed_mps == pytest.approx(6.0, abs=4.0)


def test_same_seed_same_bytes_however_time_is_cut() -> None:
    def printed(seed: int, tick_s: float) -> str:
        return everything_printed(
            World(VESSEL, WorldConditions(seed=seed, wind="4", current="0.2", waves="0.1")), 5.0, tick_s
        )

    assert printed(1, 0.1) == printed(1, 0.1) == printed(1, 0.5)
    assert printed(1, 0.1) != printed(2, 0.1)


def test_a_sensor_more_does_not_change_the_others() -> None:
    more = replace(VESSEL, sensors=(*VESSEL.sensors, replace(VESSEL.sensors[0], name="gnss_spare")))

    def first_words(world: World) -> bytes:
        port = world.open("gnss", "")
        world.advance(1.0)
        return b"".join(data for _, data in port.read(1.0))

    assert first_words(World(VESSEL)) == first_words(World(more))


def test_rates_are_those_of_the_vessel() -> None:
    world = World(VESSEL)
    ports = {name: world.open(name, "") for name in ("gnss", "imu", "microcontroller")}
    world.advance(5.0)
    counts = {name: len(port.read(5.0)) for name, port in ports.items()}
    assert counts == {"gnss": 100, "imu": 500, "microcontroller": 101}  # the board introduces itself once


def test_odd_rates_come_out_in_the_mean() -> None:
    world = World(
        replace(VESSEL, sensors=(replace(VESSEL.sensors[0], rate_hz=30.0), replace(VESSEL.sensors[1], rate_hz=400.0)))
    )
    gnss, imu = world.open("gnss", ""), world.open("imu", "")
    packets = [0, 0]
    for now_s in (1.0, 2.0, 3.0, 4.0, 5.0):
        world.advance(now_s)
        packets[0] += len(gnss.read(now_s))
        packets[1] += len(imu.read(now_s))
    assert packets[0] == pytest.approx(150, abs=1)
    assert packets[1] == 1000  # no device is faster than the plant, which steps at 200 Hz for a sensor faster than 100


def test_set_state_places_the_boat() -> None:
    world = World(VESSEL, WorldConditions(current="0.2@0"))
    world.set_state(10.0, -5.0, 1.0, surge_mps=0.5)
    truth = world.truth
    assert (truth.north_m, truth.east_m, truth.yaw_rad, truth.surge_mps, truth.sway_mps) == pytest.approx(
        (10.0, -5.0, 1.0, 0.5, 0.0)
    )


def test_the_battery_drains_with_thrust() -> None:
    idle, busy = World(VESSEL), World(VESSEL)
    sail(idle, 60.0)
    sail(busy, 60.0, (1.0, 1.0, 1.0))
    assert busy.truth.battery_remaining == pytest.approx(1.0 - 360.0 / 60.0 / 900.0, abs=1e-4)  # ReVolt's 360 W
    assert idle.truth.battery_remaining > 0.999
    assert busy.truth.battery_v < idle.truth.battery_v


def test_a_dead_thruster_and_an_unplugged_port() -> None:
    world = World(VESSEL, WorldConditions(faults=["thruster_stern_port_dead@2", "gnss_unplugged@2+1"]))
    port = world.open("gnss", "")
    assert isinstance(port, ByteStream)
    sail(world, 1.9, (0.5, 0.5, 0.0))
    assert port.fault() is None
    sail(world, 1.0, (0.5, 0.5, 0.0))
    assert "plugged in" in (port.fault() or "")
    sail(world, 2.1, (0.5, 0.5, 0.0))
    assert port.fault() is None
    assert abs(world.truth.thrusters[0][0]) < 0.01 < world.truth.thrusters[1][0]


def test_faults_and_transmitter_by_hand() -> None:
    world = World(VESSEL)
    port = world.open("microcontroller", "")
    world.advance(1.0)
    world.add_fault("leak", 1.0)
    world.set_transmitter((1500, 1600, 1700, 1800, 2000, 1000, 1000, 1000))
    world.advance(1.5)
    assert last_status(port, 1.5).leak_wet
    assert last_status(port, 1.5, world).rc_us[:5] == (1500, 1600, 1700, 1800, 2000)
    world.set_transmitter(None)
    world.advance(3.0)
    status = last_status(port, 3.0)
    assert not status.leak_wet and not status.rc_present
    with pytest.raises(ConfigError, match="no fault named"):
        world.add_fault("kraken")


def last_status(port: ByteStream, now_s: float, world: World | None = None) -> BoardStatus:
    if world is not None:
        world.advance(now_s + 0.1)
        now_s += 0.1
    decoder = FrameDecoder()
    statuses = [
        message for _, data in port.read(now_s) for message in decoder.feed(data) if isinstance(message, BoardStatus)
    ]
    return statuses[-1]


def test_thesis_plant_can_be_chosen() -> None:
    world = World(VESSEL, WorldConditions(plant="thesis"))
    sail(world, 60.0, (0.0, 0.0, 1.0))
    assert abs(world.truth.sway_mps) < 0.1


def test_the_published_otter_pitches_by_itself_and_its_sensors_feel_it() -> None:
    otter = load(find("otter"))
    world = World(otter, WorldConditions(plant="published"))
    usual = World(otter)
    for one in (world, usual):
        one.set_state(yaw_rad=0.5)
        one.advance(20.0)
    hull = world.hull
    assert isinstance(hull, OtterHull)
    assert world.waves.pitch_rad - usual.waves.pitch_rad == pytest.approx(hull.pitch_rad, abs=1e-4)
    assert world.truth.surge_mps == pytest.approx(hull.trim_n / 77.55, rel=0.05)
    felt_mps2 = true_imu(9.82, hull, world.waves)[0]
    assert felt_mps2 == pytest.approx(9.82 * math.sin(hull.pitch_rad), abs=0.02)


def true_motion(world: World) -> tuple[Rotation, Any]:
    """Attitude, and velocity to north and east."""
    hull, sea = world.hull, world.waves
    turn = Rotation.from_euler("ZYX", (hull.yaw_rad, sea.pitch_rad, sea.roll_rad))
    return turn, np.array([hull.north_mps, hull.east_mps])


@pytest.mark.parametrize("waves", ["", "0.1@90"])
def test_a_perfect_inertial_sensor_carries_the_published_otter_on_through_a_turn(waves: str) -> None:
    """Its rates turn the attitude, its forces change the velocity: nobody's measurement contradicts the truth."""
    otter = load(find("otter"))
    world = World(without_boards(otter), WorldConditions(plant="published", waves=waves, seed=100))
    for thruster, throttle in zip(world.thrusters, (0.8, 0.3), strict=True):
        thruster.drive(throttle)
    world.advance(1.0)
    hull, sea, dt_s = world.hull, world.waves, world.step_s
    turn, velocity = true_motion(world)
    for k in range(101, 1600):
        world.advance(k * dt_s)
        felt = true_imu(9.82, hull, sea)
        turn *= Rotation.from_rotvec(np.array(felt[3:]) * dt_s)
        velocity += dt_s * turn.apply(felt[:3])[:2]
    yaw, pitch, roll = turn.as_euler("ZYX")
    assert abs(math.remainder(yaw - hull.yaw_rad, 2.0 * math.pi)) < 2e-3
    assert (pitch, roll) == pytest.approx((sea.pitch_rad, sea.roll_rad), abs=2e-3)
    assert velocity == pytest.approx([hull.north_mps, hull.east_mps], abs=0.03)


def test_a_perfect_inertial_sensor_carries_a_boat_on_in_waves() -> None:
    """Forces and rates are means of one and the same step: half a step between them comes to 0.02 m/s."""
    world = World(without_boards(load(find("blueboat"))), WorldConditions(waves="0.3@90", seed=100))
    world.advance(1.0)
    hull, sea, dt_s = world.hull, world.waves, world.step_s
    turn, velocity = true_motion(world)
    for k in range(101, 3000):
        world.advance(k * dt_s)
        felt = true_imu(9.82, hull, sea)
        half = Rotation.from_rotvec(0.5 * dt_s * np.array(felt[3:]))
        velocity += dt_s * (turn * half).apply(felt[:3])[:2]
        turn *= half * half
    assert velocity == pytest.approx([hull.north_mps, hull.east_mps], abs=2e-3)


@pytest.mark.parametrize("sea", ["", "0.1@90"])
def test_hulls_with_strips_and_lift_sail_in_waves(sea: str) -> None:
    for vessel, plant in (("otter", "strips"), ("otter", "published"), ("revolt", "slender"), ("aboat", "slender")):
        world = World(load(find(vessel)), WorldConditions(plant=plant, waves=sea, wind="3@0", seed=100))
        world.advance(20.0)
        truth = world.truth
        assert math.hypot(truth.north_m, truth.east_m) < 20.0
        assert all(math.isfinite(value) for value in (truth.surge_mps, truth.sway_mps, truth.yaw_rate_radps))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"plant": "ideal"}, "no plant named 'ideal'; there is as_sailed, sea_trial, thesis, slender"),
        ({"gnss": "cold"}, "gnss 'cold': one of"),
        ({"wind": "fresh"}, "wind 'fresh'"),
        ({"current": "1@@"}, "current '1@@'"),
        ({"faults": ["kraken@1"]}, "no fault named 'kraken'"),
    ],
)
def test_what_cannot_be_simulated_is_said(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        World(VESSEL, WorldConditions(**arguments))  # type: ignore[arg-type]


def test_unknown_devices_are_said() -> None:
    with pytest.raises(ConfigError, match="no simulated device named 'sonar'; there is gnss, imu, microcontroller"):
        World(VESSEL).open("sonar", "")
    strange = replace(VESSEL, sensors=(replace(VESSEL.sensors[0], driver="sextant"),))
    with pytest.raises(ConfigError, match=r"no simulated device for driver 'sextant'.*companion run --devices"):
        World(strange)
    bridge = replace(VESSEL, actuators=(replace(VESSEL.actuators[0], driver="oars"),))
    with pytest.raises(ConfigError, match="no simulated device for driver 'oars'"):
        World(bridge)
    with pytest.raises(ConfigError, match=r"no \[sitl\] table"):
        World(replace(VESSEL, sitl=None))


def test_waves_move_it_to_and_fro_and_push_it_along() -> None:
    places = {}
    for drift in (True, False):
        world = World(VESSEL, WorldConditions(waves="0.2@90", wave_drift=drift))
        norths = []
        for k in range(1, 601):
            world.advance(0.1 * k)
            norths.append(world.truth.surge_mps)
        places[drift] = world.truth.east_m
        assert 0.05 < max(norths) - min(norths) < 1.5
        assert world.waves.heave_m != 0.0
    assert places[True] < -3.0  # away from where they come from
    assert -3.0 < places[False] < 0.1  # no more than what floats in them does (Stokes 1847)


def test_the_sea_of_the_vessel_s_file_is_there_unless_the_conditions_say_otherwise() -> None:
    assert VESSEL.sitl is not None
    rough = replace(VESSEL, sitl=replace(VESSEL.sitl, waves="0.2@90"))

    def heave_m(vessel: VesselConfig, waves: str | None) -> float:
        world = World(vessel, WorldConditions(waves=waves))
        world.advance(1.0)
        return world.waves.heave_m

    assert heave_m(rough, None) == heave_m(VESSEL, "0.2@90") != 0.0
    assert heave_m(rough, "0") == heave_m(VESSEL, None) == 0.0


def test_simulated_time_begins_at_noon() -> None:
    assert EPOCH_UNIX_NS == 1780315200 * 10**9


def test_a_push_is_a_force_in_north_and_east_whatever_the_heading() -> None:
    world = World(VESSEL, WorldConditions(push_ned_n=(-1.5, 0.5)))
    world.set_state(yaw_rad=math.radians(-45.0))
    world.advance(1.0)
    mass = 0.5 * (VESSEL.hull.m11_kg + VESSEL.hull.m22_kg)
    truth = world.truth
    assert truth.north_m == pytest.approx(-0.5 * 1.5 / mass, rel=0.15) and truth.east_m == pytest.approx(
        0.5 * 0.5 / mass, rel=0.3
    )


def test_a_boat_aground_stops_and_creeps_at_most() -> None:
    world = World(VESSEL)
    sail(world, 15.0, (0.7, 0.7, 0.0))
    assert world.truth.surge_mps > 0.4
    world.add_fault("aground")
    sail(world, 1.0, (0.7, 0.7, 0.0))
    before = world.truth.north_m
    sail(world, 10.0, (0.7, 0.7, 0.0))
    assert world.truth.north_m - before < 0.2


def test_a_boat_rolls_over_and_stays_so() -> None:
    world = World(VESSEL, WorldConditions(waves="0.1", wind="3"))
    world.add_fault("capsized")
    sail(world, 1.0)
    assert math.degrees(world.waves.roll_rad) == pytest.approx(60.0, abs=10.0)
    sail(world, 5.0)
    first = world.waves.roll_rad
    sail(world, 5.0)
    assert math.degrees(first) == pytest.approx(170.0, abs=10.0)
    assert math.degrees(world.waves.roll_rad) == pytest.approx(170.0, abs=10.0)
