"""The estimated current, against a boat whose equations are integrated here by scipy."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from companion.config import vessel as vessel_config
from companion.config.hull import DampingConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.nav.current import CurrentObserver, GroundMotion

REVOLT = vessel_config.load(vessel_config.find("revolt"))
DT_S = 0.1
Thrust = Callable[[float, np.ndarray], tuple[float, float]]


def passages(
    thrust: Thrust, current: tuple[float, float], duration_s: float, yaw_of: Callable[[float], float]
) -> list[tuple[float, Wrench, GroundMotion]]:
    """Surge and sway of ReVolt in moving water on a prescribed heading, from rest over ground."""
    hull, d = REVOLT.hull, REVOLT.hull.damping

    def turn(t: float) -> float:
        return (yaw_of(t + 1e-4) - yaw_of(t - 1e-4)) / 2e-4

    def over_ground(t: float, nu: np.ndarray) -> tuple[float, float]:
        c, s = math.cos(yaw_of(t)), math.sin(yaw_of(t))
        return c * nu[0] - s * nu[1] + current[0], s * nu[0] + c * nu[1] + current[1]

    def slope(t: float, nu: np.ndarray) -> list[float]:
        (u, v), r = nu, turn(t)
        x, y = thrust(t, np.array(over_ground(t, nu)))
        du = (x + (hull.m22_kg * v + hull.m23_kgm * r) * r - d.x_u * u) / hull.m11_kg
        dv = (y - hull.m11_kg * u * r - d.y_v * v - d.y_vv * abs(v) * v) / hull.m22_kg
        return [du, dv]

    c, s = math.cos(yaw_of(0.0)), math.sin(yaw_of(0.0))
    start = [-c * current[0] - s * current[1], s * current[0] - c * current[1]]
    times = np.arange(0.0, duration_s, DT_S)
    solved = solve_ivp(slope, (0.0, duration_s), start, t_eval=times, rtol=1e-8, atol=1e-9)
    found = []
    for t, nu in zip(times.tolist(), solved.y.T, strict=True):
        velocity = over_ground(t, nu)
        found.append(
            (t, Wrench(*thrust(t, np.array(velocity)), 0.0), GroundMotion(*velocity, yaw_of(t), turn(t), None, None))
        )
    return found


def holding(yaw_rad: float) -> Thrust:
    """A force that brings the velocity over ground to zero."""

    def thrust(_: float, velocity: np.ndarray) -> tuple[float, float]:
        north, east = -120.0 * velocity[0], -120.0 * velocity[1]
        return math.cos(yaw_rad) * north + math.sin(yaw_rad) * east, math.cos(yaw_rad) * east - math.sin(
            yaw_rad
        ) * north

    return thrust


def observed(config: VesselConfig, rows: list[tuple[float, Wrench, GroundMotion]]) -> CurrentObserver:
    observer = CurrentObserver(config)
    for t_s, thrust, passage in rows:
        observer.update(t_s, thrust, passage)
    return observer


@pytest.mark.parametrize("current", [(0.1, 0.0), (0.0, 0.2), (-0.2, 0.2), (0.0, 0.0)])
def test_the_current_is_estimated_within_a_minute_of_holding(current: tuple[float, float]) -> None:
    rows = passages(holding(0.5), current, 60.0, lambda _: 0.5)
    found = observed(REVOLT, rows).estimate(60.0)
    assert found is not None
    assert found[:2] == pytest.approx(current, abs=0.02)
    assert 0.02 < found[2] < 0.15


def test_the_current_is_estimated_while_sailing_a_circle() -> None:
    rows = passages(lambda t, _: (25.0, 4.0 * math.sin(0.3 * t)), (0.15, -0.2), 60.0, lambda t: 0.1 * t)
    found = observed(REVOLT, rows).estimate(60.0)
    assert found is not None
    assert found[:2] == pytest.approx((0.15, -0.2), abs=0.03)


def test_a_wrong_model_errs_within_its_sigma() -> None:
    hull = REVOLT.hull
    wrong = replace(
        REVOLT,
        hull=replace(hull, damping=replace(hull.damping, x_u=1.2 * hull.damping.x_u, y_vv=1.2 * hull.damping.y_vv)),
    )
    found = observed(wrong, passages(holding(0.5), (0.2, 0.1), 60.0, lambda _: 0.5)).estimate(60.0)
    assert found is not None
    assert math.hypot(found[0] - 0.2, found[1] - 0.1) < 2.0 * found[2]


def test_measured_wind_does_not_count_as_current() -> None:
    """5 m/s of wind on the beam is countered by thrust: with a wind sensor there is no current in that, without one
    there seems to be."""
    push = 0.5 * 1.225 * REVOLT.windage.cy * REVOLT.windage.lateral_m2 * 25.0
    still = GroundMotion(0.0, 0.0, 0.0, 0.0, 0.0, 5.0)
    rows = [(DT_S * k, Wrench(0.0, -push, 0.0), still) for k in range(600)]
    with_sensor = observed(REVOLT, rows).estimate(60.0)
    assert with_sensor is not None and abs(with_sensor[1]) < 0.01
    unseen = [(t_s, thrust, replace(passage, air_north_mps=None, air_east_mps=None)) for t_s, thrust, passage in rows]
    without = observed(REVOLT, unseen).estimate(60.0)
    assert without is not None and abs(without[1]) == pytest.approx(math.sqrt(push / 350.0), abs=0.03)  # y_vv v² = push


def test_an_estimate_is_given_only_while_it_is_accurate() -> None:
    rows = passages(holding(0.5), (0.2, 0.0), 60.0, lambda _: 0.5)
    observer = CurrentObserver(REVOLT)
    assert observer.estimate(0.0) is None
    observer = observed(REVOLT, rows)
    _, _, passage = rows[-1]
    for k in range(1300):  # disarmed from here on
        t_s = 60.0 + DT_S * k
        observer.update(t_s, None, passage)
        if k == 600:
            kept = observer.estimate(t_s)
            assert kept is not None and kept[0] == pytest.approx(0.2, abs=0.02)
    assert observer.estimate(190.0) is None


def test_a_hull_without_damping_gives_none() -> None:
    bare = replace(REVOLT, hull=replace(REVOLT.hull, damping=DampingConfig()))
    assert observed(bare, passages(holding(0.5), (0.2, 0.0), 30.0, lambda _: 0.5)).estimate(30.0) is None


def test_about_its_limit_an_estimate_does_not_come_and_go() -> None:
    """The thrust is the less sure the more it is, and more without an estimate: a ship of 2.2 m pushed with 45 and 52 N
    in turns, every other tick."""
    rows = passages(holding(0.5), (0.2, 0.0), 60.0, lambda _: 0.5)
    observer, (_, _, passage), known = observed(REVOLT, rows), rows[-1], []
    for k in range(100):
        t_s = 60.0 + DT_S * k
        observer.update(t_s, Wrench(190.0 + k / 20.0 + (10.0 if k % 2 else 0.0), 0.0, 0.0), passage)
        known.append(observer.estimate(t_s) is not None)
    assert known[0] and sum(a != b for a, b in itertools.pairwise(known)) <= 1
