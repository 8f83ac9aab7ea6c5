"""The drift on the beam, from the motion of a hull that wind and current push, and a Hold in weather from both ends."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from companion.cli.new_file import Answers, file_text
from companion.config.vessel import find, load, parse
from companion.core.angles import wrap_pi
from companion.core.estimate import NO_ESTIMATE, NavState
from companion.params.store import Parameters
from companion.params.table import table_of
from companion.positioning.beam_drift import BeamDrift
from companion.positioning.bow_keeper import BowKeeper
from sitl.environment import wind_force
from sitl.hull import Hull
from tests.unit.positioning.kept import kept, moving

OTTER = load(find("otter"))


ANSWERS = Answers(
    "rib", "RIB", "planing", 5.0, 2.0, 450.0, None, None, None, "azimuth", "1500", None, 0.0, "microcontroller", "two",
    63.442, 10.4,
)  # fmt: skip
BOAT = parse(file_text(ANSWERS), "rib.toml")
LEVER_M = -BOAT.thrusters[0].x_m


class Water:
    """The hull with wind from the north and a current from the south, or what is set."""

    def __init__(self, wind_mps: float, current_north_mps: float, yaw_rad: float) -> None:
        self.hull = Hull(BOAT.hull)
        self.hull.set_current(current_north_mps, 0.0)
        self.hull.place(0.0, 0.0, yaw_rad)
        self._wind_mps = wind_mps

    def step(self, surge_n: float, sway_n: float, yaw_nm: float, dt_s: float) -> None:
        hull = self.hull
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        north, east = -self._wind_mps - hull.north_mps, -hull.east_mps
        x_n, y_n, n_nm = wind_force(BOAT.windage, BOAT.length_m, c * north + s * east, c * east - s * north)
        hull.step(surge_n + x_n, sway_n + y_n, yaw_nm + n_nm, dt_s)

    def nav(self, t_s: float, current: tuple[float, float] | None = None) -> NavState:
        known = None if current is None else 0.02
        north_mps, east_mps = (None, None) if current is None else current
        still = replace(
            NO_ESTIMATE,
            t_s=t_s,
            current_north_mps=north_mps,
            current_east_mps=east_mps,
            current_accuracy_mps=known,
        )
        return moving(still, self.hull)


def turned_to_and_fro(push_aside: bool) -> BeamDrift:
    """What is found in still air and water while a thruster turns the boat by some 40° to either side."""
    water, beam = Water(0.0, 0.0, 0.0), BeamDrift(BOAT)
    for i in range(1200):
        moment_nm = 150.0 * math.cos(0.1 * i)
        for _ in range(5):
            water.step(0.0, -moment_nm / LEVER_M if push_aside else 0.0, moment_nm, 0.02)
        nav = water.nav(0.1 * i)
        beam.see(nav, nav.surge_mps, 0.1)
    return beam


def test_what_steering_pushes_aside_is_no_drift() -> None:
    beam = turned_to_and_fro(push_aside=True)
    assert math.hypot(beam.north_mps, beam.east_mps) < 0.03


def test_the_pivot_stays_where_the_thruster_pushes() -> None:
    """The middle goes aside at p times the rate of turn that the push makes."""
    water, beam = Water(0.0, 0.0, 0.0), BeamDrift(BOAT)
    water.step(0.0, -200.0, 200.0 * LEVER_M, 0.02)
    hull = water.hull
    assert beam.pivot_m > 0.1
    assert hull.sway_mps + beam.pivot_m * hull.yaw_rate_radps == pytest.approx(0.0, abs=0.01 * abs(hull.sway_mps))
    assert BeamDrift(OTTER).pivot_m == 0.0, "two fixed thrusters turn without a push aside"


def test_a_thruster_at_the_bow_pushes_to_the_side_to_which_it_turns() -> None:
    water = Water(0.0, 0.0, 0.0)
    (thruster,) = BOAT.thrusters
    beam = BeamDrift(replace(BOAT, thrusters=(replace(thruster, x_m=LEVER_M),)))
    water.step(0.0, 200.0, 200.0 * LEVER_M, 0.02)
    hull = water.hull
    assert hull.sway_mps + beam.pivot_m * hull.yaw_rate_radps == pytest.approx(0.0, abs=0.01 * hull.sway_mps)


def test_it_finds_where_the_wind_carries_a_boat_that_lies_across_against_the_current() -> None:
    water, beam = Water(6.0, 0.3, math.radians(80.0)), BeamDrift(BOAT)
    beam.begin((0.3, 0.0))  # the estimated current
    for i in range(600):
        for _ in range(5):
            water.step(0.0, 0.0, 0.0, 0.02)
            water.hull.place(0.0, 0.0, math.radians(80.0) + 0.3 * math.sin(0.01 * i), 0.0, water.hull.sway_mps, 0.0)
        nav = water.nav(0.1 * i)
        beam.see(nav, nav.surge_mps, 0.1)
    assert beam.north_mps < -0.1, "south, with the wind"
    assert beam.sigma_mps < 0.3


@pytest.mark.parametrize("slide_mps", [0.5, -0.4])
def test_a_slide_from_before_is_not_felt_as_a_drift(slide_mps: float) -> None:
    """A boat that came to rest out of a turn took its slide for a drift of 0.3 m/s within two seconds, and
    lay bow to it."""
    water, beam = Water(0.0, 0.0, 0.0), BeamDrift(BOAT)
    water.hull.place(0.0, 0.0, 0.0, 0.0, slide_mps, 0.0)
    felt = []
    for i in range(200):
        for _ in range(5):
            water.step(0.0, 0.0, 0.0, 0.02)
        nav = water.nav(0.1 * i)
        beam.see(nav, nav.surge_mps, 0.1)
        felt.append(math.hypot(beam.north_mps, beam.east_mps))
    assert max(felt) < 0.15


def held(wind_mps: float, current_mps: float, yaw_rad: float, duration_s: float) -> list[tuple[float, float]]:
    """(distance from the point, heading) each tenth of a second, with the current known as it is."""
    water, keeper = Water(wind_mps, current_mps, yaw_rad), BowKeeper(BOAT, Parameters(BOAT.parameters, table_of(BOAT)))
    keeper.start(water.nav(0.0))
    keeper.hold(0.0, 0.0, yaw_rad, None)
    return kept(BOAT, keeper, lambda t_s: water.nav(t_s, (current_mps, 0.0)), water.hull, water.step, 0.2, duration_s)


def test_wind_against_current_does_not_drive_a_lone_outboard_off_to_and_fro() -> None:
    """It lay bow to the current, where each turn of the bow to one side had the wind carry it to the other."""
    track = held(6.0, 0.3, math.radians(120.0), 300.0)
    late = track[-1500:]
    assert max(distance for distance, _ in late) < 1.5
    assert all(math.cos(yaw) > 0.5 for _, yaw in late), "bow to the wind, which carries it across"
    turned = sum(wrap_pi(b[1] - a[1]) for a, b in pairwise(late))
    assert abs(turned) < math.pi
