"""The estimator on the emulated devices' bytes, without a controller: are its doubts the size of its errors, slow
errors included?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from companion.cli.rig import LockstepRig
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import ActuatorCommand, ThrusterCommand
from companion.core.estimate import NavState
from companion.core.readings import Reading
from companion.io.actuators import open_actuator
from companion.io.sensors import open_sensor
from companion.nav.estimator import Estimator
from companion.params.store import Parameters
from sitl.evaluate.consistency import CASES, begin
from sitl.evaluate.told_sensors import told
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Conditions
from sitl.world import World, WorldConditions

REVOLT = load(find("revolt"))
SEEDS = 16
INSTANTS_S = (50.0, 89.9, 92.0, 94.9, 95.3, 110.0)
DROPOUT = "gnss_lost@90+5"


def drive(
    vessel: VesselConfig, seed: int, until_s: float, gnss: str, faults: Sequence[str]
) -> list[tuple[NavState, tuple[float, ...]]]:
    """The boat snakes about under open-loop thrust in wind; each tick's estimate and (north, east, v_north, v_east,
    yaw) as they are."""
    world = World(vessel, WorldConditions(seed=seed, wind="2", gnss=gnss, faults=faults))
    sensors = [open_sensor(row, world.open(row.name, row.port)) for row in vessel.sensors]
    bridges = [open_actuator(row, vessel, world.open(row.name, row.port)) for row in vessel.actuators]
    estimator = Estimator(vessel, Parameters())
    found = []
    for k in range(1, round(until_s * 10) + 1):
        t_s = k / 10
        world.advance(t_s)
        readings: list[Reading] = []
        for device in (*sensors, *bridges):
            readings += device.read(t_s)
        stern = ThrusterCommand(4.3, 0.4, 0.3 * math.sin(t_s / 15.0))
        for bridge in bridges:
            bridge.write(
                ActuatorCommand(t_s, True, (stern, stern, ThrusterCommand(0.6, 0.2 * math.sin(t_s / 7.0), None))), t_s
            )
        hull = world.hull
        state = estimator.update(readings, t_s)
        found.append((state, (hull.north_m, hull.east_m, hull.north_mps, hull.east_mps, hull.yaw_rad)))
    return found


def normalised(state: NavState, truth: tuple[float, ...]) -> tuple[float, float, float]:
    north, east, v_north, v_east, yaw = truth
    return (
        ((state.north_m - north) ** 2 + (state.east_m - east) ** 2) / state.position_accuracy_m**2,
        ((state.north_mps - v_north) ** 2 + (state.east_mps - v_east) ** 2) / state.velocity_accuracy_mps**2,
        (math.remainder(state.yaw_rad - yaw, 2.0 * math.pi) / state.heading_accuracy_rad) ** 2,
    )


@pytest.mark.sweep
@pytest.mark.parametrize("gnss", ["rtk", "sbas", "standalone"])
def test_normalised_errors_over_the_seeds(gnss: str) -> None:
    """Inside the 95 % band but for chance (two of eighteen means), and none outside of the 99.9 % band. The file tells
    the sensors' true figures: without them the boat claims larger errors than these receivers have."""
    vessel = told(REVOLT, gnss)
    squares = np.empty((SEEDS, len(INSTANTS_S), 3))
    for seed in range(SEEDS):
        found = drive(vessel, seed, INSTANTS_S[-1], gnss, (DROPOUT,))
        for i, t_s in enumerate(INSTANTS_S):
            squares[seed, i] = normalised(*found[round(t_s * 10) - 1])
    means = squares.mean(axis=0)
    axes = np.array([2, 2, 1])
    inside = (means > chi2.ppf(0.025, axes * SEEDS) / SEEDS) & (means < chi2.ppf(0.975, axes * SEEDS) / SEEDS)
    near = (means > chi2.ppf(0.0005, axes * SEEDS) / SEEDS) & (means < chi2.ppf(0.9995, axes * SEEDS) / SEEDS)
    assert (~inside).sum() <= 2 and near.all(), means


@pytest.mark.parametrize("gnss", ["rtk", "sbas", "standalone"])
def test_errors_are_no_larger_than_three_sigma(gnss: str) -> None:
    for seed in (1, 2):
        for state, truth in drive(REVOLT, seed, 55.0, gnss, ("gnss_lost@45+5",))[300:]:
            assert max(normalised(state, truth)) < 16.0, state.t_s


def test_a_receiver_that_is_late_is_found_out_in_turns() -> None:
    """0.3 s more than its row says; until it has been found, 0.05 m and 1.3°."""
    late = drive(REVOLT, 1, 90.0, "rtk", ("gnss_late=0.3@1",))[700:]
    assert np.mean([math.hypot(state.north_m - truth[0], state.east_m - truth[1]) for state, truth in late]) < 0.03
    assert np.mean([abs(math.remainder(state.yaw_rad - truth[4], 2.0 * math.pi)) for state, truth in late]) < 0.008


@pytest.mark.parametrize(("vessel", "seed", "until_s"), [("otter", 26100, 45.0), ("heron", 26001, 32.0)])
def test_a_late_receiver_of_a_boat_that_turns_fast_is_not_taken_for_a_liar(
    tmp_path: Path, vessel: str, seed: int, until_s: float
) -> None:
    """What lags in a turn seems to drift. Of the Otter the gyro was blamed, for good, and the heading was 20° off. The
    Heron has one antenna: 90 m off after 45 s of its mission, its inertial sensor blamed."""
    rig = LockstepRig(Conditions(vessel, seed=seed, wind="2", faults=("gnss_late=0.3@0",)), tmp_path)
    gcs, off_m = GroundStation(rig), []
    begin(gcs, CASES["mission"])
    while rig.now_s < until_s:
        gcs.step()
        nav, hull = rig.vessel.last_tick.nav, rig.world.hull  # type: ignore[union-attr]
        off_m.append(math.hypot(nav.north_m - hull.north_m, nav.east_m - hull.east_m))
    rig.close()
    assert any("late" in text for text in gcs.texts) and not any("not used" in text for text in gcs.texts)
    assert max(off_m) < 0.3 and max(off_m[-100:]) < 0.06  # before the latency was a state: 0.9 m, and a heading 10° off


@pytest.mark.parametrize("heading", ["magnetic", "true"])
def test_a_compass_alone_carries_the_boat(heading: str) -> None:
    """The receiver has one antenna: the inertial sensor's own yaw serves from the start, at rest and under way."""
    gnss, imu = REVOLT.sensors
    vessel = replace(REVOLT, sensors=(gnss, replace(imu, heading=heading)))  # type: ignore[arg-type]
    for state, truth in drive(vessel, 3, 60.0, "rtk", ("heading_lost@0",))[100:]:
        assert state.heading_valid and state.position_valid
        assert abs(math.remainder(state.yaw_rad - truth[4], 2.0 * math.pi)) < 3.0 * state.heading_accuracy_rad
        assert math.hypot(state.north_m - truth[0], state.east_m - truth[1]) < 0.1


def test_without_any_compass_there_is_no_heading_at_rest() -> None:
    gnss, imu = REVOLT.sensors
    vessel = replace(REVOLT, sensors=(gnss, imu))
    assert not drive(vessel, 3, 15.0, "rtk", ("heading_lost@0",))[-1][0].heading_valid
