"""Stops and forbidden sectors of azimuths: the arithmetic, and the allocation that keeps to it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from companion.allocation.allocator import Allocator
from companion.allocation.sectors import Sectors
from companion.config.vessel import ConfigError, VesselConfig, find, load, with_rotating_thruster
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.params.store import Parameters
from companion.safety import Gate
from tests.unit.control.simple_boat import REVOLT

DT_S = 0.1
ABOAT = load(find("aboat"))


def deg(*angles: float) -> tuple[float, ...]:
    return tuple(math.radians(angle) for angle in angles)


def boat(forbidden: tuple[tuple[float, float], ...]) -> VesselConfig:
    """ReVolt with sectors on its port pod, so that it does not blow on the starboard one."""
    port = replace(REVOLT.thrusters[0], forbidden_rad=tuple((math.radians(a), math.radians(b)) for a, b in forbidden))
    return replace(REVOLT, thrusters=(port, *REVOLT.thrusters[1:]))


@pytest.mark.parametrize(
    ("at", "low", "high"),
    [(0.0, -290.0, 60.0), (60.0, -290.0, 60.0), (70.0, -290.0, 60.0), (-200.0, -290.0, 60.0), (300.0, 70.0, 420.0)],
)
def test_the_span_ends_at_the_sector(at: float, low: float, high: float) -> None:
    sectors = Sectors(None, None, [deg(60.0, 70.0)])  # type: ignore[list-item]
    if at == 70.0:
        low, high = 70.0, 420.0
    assert sectors.span(math.radians(at)) == pytest.approx(deg(low, high), abs=1e-6)


def test_a_sector_across_astern_and_stops() -> None:
    sectors = Sectors(*deg(-270.0, 270.0), [deg(150.0, -150.0)])  # type: ignore[list-item]
    assert (
        sectors.allowed(math.radians(149.0))
        and not sectors.allowed(math.radians(180.0))
        and not sectors.allowed(math.radians(271.0))
    )
    assert sectors.span(0.0) == pytest.approx(deg(-150.0, 150.0))
    assert sectors.span(math.radians(220.0)) == pytest.approx(deg(210.0, 270.0))
    assert sectors.nearest(math.radians(179.0), 0.0) == pytest.approx(math.radians(150.0))


def test_an_azimuth_is_unwound_round_its_stops() -> None:
    sectors = Sectors(*deg(-270.0, 270.0), ())
    assert sectors.nearest(math.radians(280.0), math.radians(250.0)) == pytest.approx(math.radians(-80.0))
    assert sectors.nearest(math.radians(-100.0), math.radians(250.0)) == pytest.approx(math.radians(260.0))
    assert Sectors(None, None, ()).nearest(math.radians(-179.0), math.radians(179.0)) == pytest.approx(
        math.radians(181.0)
    )


def sail(a: Allocator, wrench: Wrench, cycles: int, config: VesselConfig) -> list[Allocation]:
    """Every cycle: limits kept, no thrust in a sector, and the wrench said to be achieved is that of the commands."""
    results = []
    for _ in range(cycles):
        result = a.update(wrench, DT_S)
        x = y = n = 0.0
        for t, command in zip(config.thrusters, result.thrusters, strict=True):
            azimuth = t.azimuth_rad if command.azimuth_rad is None else command.azimuth_rad
            for start, end in t.forbidden_rad:
                assert (
                    command.force_n == 0.0 or not 1e-6 < (azimuth - start) % math.tau < (end - start) % math.tau - 1e-6
                )
            if t.azimuth_max_rad is not None and t.azimuth_min_rad is not None:
                assert t.azimuth_min_rad - 1e-9 <= azimuth <= t.azimuth_max_rad + 1e-9
            x, y = x + math.cos(azimuth) * command.force_n, y + math.sin(azimuth) * command.force_n
            n += (t.x_m * math.sin(azimuth) - t.y_m * math.cos(azimuth)) * command.force_n
        assert (result.achieved.surge_n, result.achieved.sway_n, result.achieved.yaw_nm) == pytest.approx(
            (x, y, n), abs=1e-9
        )
        results.append(result)
    return results


@pytest.mark.parametrize("kind", [0, 1])
def test_random_demands_never_thrust_into_a_sector(kind: int) -> None:
    config = boat(((60.0, 120.0), (-110.0, -70.0)))
    rng = np.random.default_rng(4)
    a = Allocator(config, Parameters({"ALLOC_KIND": kind}))
    gate = Gate(config)
    for _ in range(60):
        demand = Wrench(float(rng.uniform(-40, 40)), float(rng.uniform(-15, 15)), float(rng.uniform(-20, 20)))
        for result in sail(a, demand, int(rng.integers(3, 30)), config):
            command = gate.update(result, True, 0.0, DT_S)
            assert not [name for name in command.gated if "sector" in name or "azimuth" in name]


@pytest.mark.parametrize(
    "demand", [(20.0, 0.0, 0.0), (0.0, 8.0, 0.0), (-20.0, 3.0, 4.0), (0.0, -8.0, 5.0), (10.0, 5.0, -10.0)]
)
def test_outside_the_sectors_the_wrench_is_given(demand: tuple[float, float, float]) -> None:
    config = boat(((60.0, 120.0), (-110.0, -70.0)))
    result = sail(Allocator(config, Parameters()), Wrench(*demand), 100, config)[-1]
    assert (result.achieved.surge_n, result.achieved.sway_n, result.achieved.yaw_nm) == pytest.approx(demand, abs=0.6)


@pytest.mark.parametrize("bearing_deg", [0.0, 60.0, 150.0, 240.0, 300.0])
def test_a_rotating_bow_gives_the_demand_after_many_turns(bearing_deg: float) -> None:
    """The demand goes round three times, so the bow meets its stops; then it stands, and must be had."""
    config = with_rotating_thruster(REVOLT, "bow")
    a = Allocator(config, Parameters())
    for k in range(0, 1080 + int(bearing_deg), 5):
        sail(a, Wrench(12.0 * math.cos(math.radians(k)), 12.0 * math.sin(math.radians(k)), 0.0), 2, config)
    demand = (12.0 * math.cos(math.radians(bearing_deg)), 12.0 * math.sin(math.radians(bearing_deg)), 3.0)
    result = sail(a, Wrench(*demand), 250, config)[-1]
    assert (result.achieved.surge_n, result.achieved.sway_n, result.achieved.yaw_nm) == pytest.approx(demand, abs=0.6)


def test_a_second_solver_finds_nothing_better() -> None:
    """Settled, with a rotating bow: no local search from there lowers power at the same wrench by much."""
    config = with_rotating_thruster(REVOLT, "bow")
    rng = np.random.default_rng(8)
    for _ in range(5):
        demand = np.array([rng.uniform(-25, 25), rng.uniform(-12, 12), rng.uniform(-12, 12)])
        a = Allocator(config, Parameters())
        result = sail(a, Wrench(*map(float, demand)), 200, config)[-1]
        start = [t.force_n for t in result.thrusters] + [t.azimuth_rad or 0.0 for t in result.thrusters]
        full = [t.max_n for t in config.thrusters]

        def power(x: np.ndarray, full: list[float] = full) -> float:
            return float(sum((abs(x[i]) / full[i]) ** 1.5 for i in range(3)))

        def off(x: np.ndarray, demand: np.ndarray = demand) -> np.ndarray:
            rows = zip(config.thrusters, x[:3], x[3:], strict=True)
            parts = [
                (f * math.cos(z), f * math.sin(z), f * (t.x_m * math.sin(z) - t.y_m * math.cos(z))) for t, f, z in rows
            ]
            return np.sum(np.array(parts), axis=0) - demand

        assert np.abs(off(np.array(start))).max() < 0.6
        bounds = [(t.min_n, t.max_n) for t in config.thrusters] + [(-4.7, 4.7)] * 3
        oracle = minimize(
            power,
            start,
            bounds=bounds,
            constraints={"type": "eq", "fun": off},
            method="SLSQP",
            options={"maxiter": 300},
        )
        assert power(np.array(start)) <= oracle.fun * 1.25 + 0.02


def test_the_gate_stops_thrust_in_a_sector() -> None:
    config = boat(((60.0, 120.0),))
    allocation = Allocator(config, Parameters()).update(Wrench(5.0, 0.0, 0.0), DT_S)
    into = replace(allocation.thrusters[0], force_n=1.0, throttle=0.2, azimuth_rad=math.radians(90.0))
    command = Gate(config).update(replace(allocation, thrusters=(into, *allocation.thrusters[1:])), True, 0.0, DT_S)
    assert command.thrusters[0].throttle == 0.0 and "stern_port.sector" in command.gated


def test_only_a_thruster_with_a_rate_can_be_made_to_rotate() -> None:
    with pytest.raises(ConfigError, match="cannot rotate"):
        with_rotating_thruster(REVOLT, "stern")


def test_pods_at_their_stops_in_reverse_turn_round_when_the_boat_needs_them() -> None:
    """Both pods of ÅBOAT pushing ahead in reverse, each at a stop: together they can turn the boat one way only."""
    aboat = load(find("aboat"))
    bow, stern = (replace(t, forbidden_rad=()) for t in aboat.thrusters)
    allocator = Allocator(replace(aboat, thrusters=(bow, stern)), Parameters(aboat.parameters))
    for _ in range(60):
        allocator.direct(
            (ThrusterCommand(0.0, -0.8, math.radians(178.0)), ThrusterCommand(0.0, -0.8, math.radians(-178.0))), DT_S
        )
    wrench = Wrench(300.0, 0.0, 85.0)
    first = allocator.update(wrench, DT_S)
    assert first.achieved.yaw_nm < 40.0
    for _ in range(160):
        last = allocator.update(wrench, DT_S)
    assert (last.achieved.surge_n, last.achieved.yaw_nm) == pytest.approx((300.0, 85.0), rel=0.05)


# Surge, sway and yaw, a second apart, as ÅBOAT's path following asked for them in a corner of 130° in wind and current.
CORNER = (
    (0.9, -39.3, 22.0),
    (-7.9, -42.1, 86.3),
    (-29.5, -35.4, 92.1),
    (-56.9, -12.8, 46.2),
    (-51.7, -2.0, 72.3),
    (-58.2, 4.6, 229.6),
    (-71.7, 5.3, 279.8),
)


def test_pods_do_not_all_turn_round_at_once() -> None:
    """Without thrust on the way round, some of it must be left: both turned in this corner, and the boat lay without
    for three seconds."""
    allocator = Allocator(ABOAT, Parameters(ABOAT.parameters))
    for _ in range(20):
        allocator.update(Wrench(*CORNER[0]), DT_S)
    for a, b in itertools.pairwise(CORNER):
        for k in range(10):
            wrench = Wrench(*(x + (y - x) * k / 10 for x, y in zip(a, b, strict=True)))
            allocation = allocator.update(wrench, DT_S)
            assert any(abs(thruster.force_n) > 1.0 for thruster in allocation.thrusters), wrench
