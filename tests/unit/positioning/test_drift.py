"""Holding near a point by drifting and sailing back, on a point mass: it goes where it is sent, and drifts where
nothing drives it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, cast

import pytest

from companion.config.hull import DampingConfig, HullConfig
from companion.config.reversing import can_reverse
from companion.config.vessel import find, load
from companion.core.estimate import NO_ESTIMATE
from companion.core.setpoint import PathSetpoint, WrenchSetpoint
from companion.fence.guard import FenceGuard
from companion.guidance.coasting import Coasting
from companion.guidance.stopping import SMOOTHING_S, stopping_point
from companion.params.store import Parameters
from companion.positioning.drift import DriftKeeper
from tests.unit.conftest import Boat

VESSEL = load(find("rescuerunner"))
PARAMETERS = Parameters(VESSEL.parameters)
CIRCLE_M = PARAMETERS["DP_WATCH_R"]
DT_S = 0.05


class Particle:
    """Turns at 30° a second, takes on a speed asked for within 2 s, coasts to a stop within 8 s, and is carried by the
    water."""

    def __init__(self, nav: Any, drift: tuple[float, float]) -> None:
        self.nav = replace(
            nav, north_m=0.0, east_m=0.0, yaw_rad=0.0, surge_mps=0.0, sway_mps=0.0, north_mps=0.0, east_mps=0.0
        )
        self.drift = drift
        self.keeper = DriftKeeper(VESSEL, PARAMETERS)
        self.speed = 0.0
        self.furthest_m = self.driven_s = 0.0
        self.returns: list[float] = []  # courses on which it set off back

    def sail(self, duration_s: float) -> None:
        driven = False
        for _ in range(round(duration_s / DT_S)):
            setpoint = self.keeper.update(self.nav, None, 8.0, DT_S)
            was, driven = driven, isinstance(setpoint, PathSetpoint)
            yaw = self.nav.yaw_rad
            if driven:
                assert setpoint.yaw_rad is not None and setpoint.surge_mps >= 0.0
                if not was:
                    self.returns.append(setpoint.yaw_rad)
                turn = math.remainder(setpoint.yaw_rad - yaw, math.tau)
                yaw += min(math.radians(30.0) * DT_S, max(-math.radians(30.0) * DT_S, turn))
                self.speed += (setpoint.surge_mps - self.speed) * DT_S / 2.0
                self.driven_s += DT_S
            else:
                assert (
                    isinstance(setpoint, WrenchSetpoint)
                    and setpoint.wrench is not None
                    and setpoint.wrench.surge_n == 0.0
                )
                self.speed -= self.speed * DT_S / 8.0
            north_mps, east_mps = self.speed * math.cos(yaw) + self.drift[0], self.speed * math.sin(yaw) + self.drift[1]
            self.nav = replace(
                self.nav, yaw_rad=yaw, north_mps=north_mps, east_mps=east_mps,
                north_m=self.nav.north_m + north_mps * DT_S, east_m=self.nav.east_m + east_mps * DT_S,
            )  # fmt: skip
            self.furthest_m = max(self.furthest_m, math.hypot(self.nav.north_m, self.nav.east_m))


@pytest.mark.parametrize("drift", [(0.2, 0.0), (0.0, -0.6), (0.7, 0.7)])
def test_it_stays_inside_and_sails_back_against_the_drift(boat: Boat, drift: tuple[float, float]) -> None:
    particle = Particle(boat.nav, drift)
    particle.keeper.start(particle.nav)
    particle.sail(600.0)
    assert particle.furthest_m < CIRCLE_M and particle.returns
    assert particle.driven_s < 0.35 * 600.0
    against = math.atan2(-drift[1], -drift[0])
    for course in particle.returns:
        assert abs(math.remainder(course - against, math.tau)) < math.radians(35.0)


def test_a_jet_that_has_come_round_before_a_fence_sails_to_its_point_and_not_beyond() -> None:
    """A small jet went on for 30 m to where it would have coasted, mirrored: out of its alarm circle."""

    class Line:
        def held_place(self, place: tuple[float, float]) -> tuple[float, float]:
            return min(place[0], 4.0), place[1]

        def room_about_m(self, place: tuple[float, float]) -> float:
            return 4.0 + CIRCLE_M - place[0]

    keeper = DriftKeeper(VESSEL, PARAMETERS, cast(FenceGuard, Line()))
    keeper.start(replace(NO_ESTIMATE, surge_mps=5.0, north_mps=5.0))
    going = replace(NO_ESTIMATE, north_m=20.0, north_mps=4.0, surge_mps=4.0)
    keeper.update(going, None, 8.0, DT_S)
    assert keeper.aim[0] < -10.0, "the nearest way round is aimed at first"
    keeper.update(replace(going, yaw_rad=3.0, north_mps=-4.0), None, 8.0, DT_S)
    assert keeper.aim == keeper.target[:2] == (4.0, 0.0)


def test_a_jet_that_has_come_round_short_of_its_point_holds_where_it_coasts_to() -> None:
    """A jet that was paused at 9.7 m/s turned before its fence, and then sailed 160 m ahead to where it would have
    coasted to."""

    class Line:
        def held_place(self, place: tuple[float, float]) -> tuple[float, float]:
            return min(place[0], 4.0), place[1]

        def room_about_m(self, place: tuple[float, float]) -> float:
            return math.inf

    keeper = DriftKeeper(VESSEL, PARAMETERS, cast(FenceGuard, Line()))
    keeper.start(replace(NO_ESTIMATE, surge_mps=5.0, north_mps=5.0))
    keeper.update(replace(NO_ESTIMATE, north_m=-5.0, yaw_rad=3.0, north_mps=-2.0, surge_mps=2.0), None, 8.0, DT_S)
    north_m, east_m, _ = keeper.target
    assert -5.0 - Coasting(VESSEL.hull, 10.0).way_m(2.0) - 0.1 < north_m < -6.0 and east_m == 0.0
    assert keeper.aim == (north_m, east_m)


@pytest.mark.parametrize(("room_m", "coasts"), [(200.0, True), (20.0, False)])
def test_a_jet_with_room_to_coast_ahead_does_not_turn_for_a_fence(room_m: float, coasts: bool) -> None:
    """The way of a reference that brakes gently was 277 m, that of the jet 150 m."""

    class Ahead:
        def held_place(self, place: tuple[float, float]) -> tuple[float, float]:
            return place if place[0] < room_m else (room_m - 10.0, place[1])

        def room_m(self, place: tuple[float, float], course_rad: float) -> float:
            return room_m - place[0] * math.cos(course_rad)

    keeper = DriftKeeper(VESSEL, PARAMETERS, cast(FenceGuard, Ahead()))
    begun = replace(NO_ESTIMATE, surge_mps=8.0, north_mps=8.0)
    keeper.start(begun, replace(begun, surge_mps=1.0, north_mps=1.0))
    way_m = SMOOTHING_S * 8.0 + Coasting(VESSEL.hull, 10.0).way_m(8.0)
    planned_m = stopping_point(begun, PARAMETERS)[0]
    assert 20.0 < way_m < 200.0
    assert (keeper.target[0] == pytest.approx(min(way_m, planned_m))) is coasts
    assert coasts or keeper.target[0] < 20.0


def test_in_a_fence_without_room_for_its_watch_circle_it_turns_back_before_the_line(boat: Boat) -> None:
    """A jet of 7 m whose fence was too small for its margin drifted 25 m over it, within its watch circle."""
    room_m = 0.6 * CIRCLE_M

    class Box:
        def held_place(self, place: tuple[float, float]) -> tuple[float, float]:
            return place

        def room_about_m(self, place: tuple[float, float]) -> float:
            return room_m

    particle = Particle(boat.nav, (0.3, 0.0))
    particle.keeper = DriftKeeper(VESSEL, PARAMETERS, cast(FenceGuard, Box()))
    particle.keeper.start(particle.nav)
    particle.sail(600.0)
    assert particle.returns and particle.furthest_m < room_m


def test_in_still_water_it_does_nothing(boat: Boat) -> None:
    particle = Particle(boat.nav, (0.0, 0.0))
    particle.keeper.start(particle.nav)
    particle.sail(60.0)
    assert particle.driven_s == 0.0 and particle.furthest_m == 0.0 and particle.keeper.arrived


def test_another_point_is_sailed_to(boat: Boat) -> None:
    particle = Particle(boat.nav, (0.0, 0.0))
    particle.keeper.start(particle.nav)
    particle.keeper.hold(0.0, 40.0, 0.0, None)
    assert not particle.keeper.arrived
    particle.sail(90.0)
    assert particle.keeper.arrived and particle.keeper.target[:2] == (0.0, 40.0)
    assert math.hypot(particle.nav.north_m, particle.nav.east_m - 40.0) < 0.5 * CIRCLE_M


def test_coasting_with_linear_damping_is_the_closed_form() -> None:
    """s = m Δv / d."""
    hull = HullConfig(470.0, 600.0, 700.0, damping=DampingConfig(x_u=60.0))
    coasting = Coasting(hull, 6.0)
    for speed in (0.5, 2.0, 5.0):
        assert coasting.way_m(speed) == pytest.approx(470.0 / 60.0 * (speed - 0.2), rel=0.02)
    assert coasting.way_m(0.0) == 0.0 and coasting.way_m(99.0) == pytest.approx(coasting.way_m(6.0), rel=0.02)


def test_which_boats_can_go_astern() -> None:
    assert not can_reverse(VESSEL.thrusters)
    assert all(can_reverse(load(find(name)).thrusters) for name in ("revolt", "aboat", "cybership2"))
    assert not can_reverse([replace(load(find("revolt")).thrusters[2], min_n=0.0)])
