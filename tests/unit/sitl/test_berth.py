"""The fender line against statics, an oscillator in closed form, and the hull that drifts onto it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.hull import DampingConfig
from companion.config.vessel import DockConfig, find, load
from companion.core.geodesy import LocalFrame
from sitl.berth import BerthModel
from sitl.hull import Hull
from sitl.world import World, WorldConditions

REVOLT = load(find("revolt"))
HALF_BEAM_M = 0.36


def berth(heading_deg: float = 0.0, side: str = "port", clearance_m: float = 0.0) -> BerthModel:
    dock = DockConfig(REVOLT.home.lat_deg, REVOLT.home.lon_deg, math.radians(heading_deg), side, 2.0, clearance_m)  # type: ignore[arg-type]
    return BerthModel(dock, REVOLT.home, REVOLT.length_m, REVOLT.beam_m, REVOLT.hull.m22_kg)


def hull_at(north_m: float, east_m: float, yaw_rad: float = 0.0, sway_mps: float = 0.0) -> Hull:
    hull = Hull(REVOLT.hull)
    hull.place(north_m, east_m, yaw_rad, 0.0, sway_mps)
    return hull


@pytest.mark.parametrize(
    ("side", "x", "y"), [("port", 0.0, 0.36), ("starboard", 0.0, -0.36), ("bow", -1.5, 0.0), ("stern", 1.5, 0.0)]
)
@pytest.mark.parametrize("heading_deg", [0.0, -40.0, 155.0])
def test_two_corners_press_with_the_stiffness_of_both(side: str, x: float, y: float, heading_deg: float) -> None:
    yaw = math.radians(heading_deg)
    length = math.hypot(x, y)
    for gap_m in (0.02, -0.01):
        a, b = x * (1.0 + gap_m / length), y * (1.0 + gap_m / length)
        line = berth(heading_deg, side)
        surge_n, sway_n, yaw_nm = line.push(
            hull_at(math.cos(yaw) * a - math.sin(yaw) * b, math.sin(yaw) * a + math.cos(yaw) * b, yaw)
        )
        assert line.gap_m == pytest.approx(gap_m, abs=1e-6)
        expected_n = 0.0 if gap_m > 0.0 else 2.0 * 4000.0 * 0.01
        assert (surge_n, sway_n) == pytest.approx((expected_n * x / length, expected_n * y / length), abs=1e-3)
        assert yaw_nm == pytest.approx(0.0, abs=1e-6) and line.force_n == pytest.approx(expected_n, abs=1e-3)


def test_one_corner_turns_the_boat_parallel() -> None:
    line = berth()
    _, sway_n, yaw_nm = line.push(hull_at(0.0, 0.36 + 0.02, math.radians(-2.0)))  # bow to port: the bow's corner is in
    assert sway_n > 0.0 and yaw_nm > 0.0


def test_fenders_do_not_pull() -> None:
    assert berth().push(hull_at(0.0, 0.359, sway_mps=1.0)) == pytest.approx((0.0, 0.0, 0.0))


@pytest.mark.parametrize("place", [(7.0, 0.3), (0.0, -2.0), (200.0, 0.0)])
def test_beside_and_behind_there_is_nothing(place: tuple[float, float]) -> None:
    assert berth().push(hull_at(*place)) == pytest.approx((0.0, 0.0, 0.0))


def test_the_fenders_stand_out_from_the_face() -> None:
    line = berth(clearance_m=0.25)
    line.push(hull_at(0.0, 1.0))
    assert line.gap_m == pytest.approx(1.0 - 0.36 - 0.25)


def test_the_speeds_of_the_last_touch_are_kept() -> None:
    line = berth()
    assert math.isnan(line.touch_sway_mps)
    line.push(hull_at(0.0, 0.355, sway_mps=-0.06))
    assert line.touch_sway_mps == pytest.approx(-0.06)
    line.push(hull_at(0.0, 0.355, sway_mps=-0.02))
    assert line.touch_sway_mps == pytest.approx(-0.06)
    line.push(hull_at(0.0, 0.5))
    line.push(hull_at(0.0, 0.355, sway_mps=-0.03))
    assert line.touch_sway_mps == pytest.approx(-0.03)


def compression_m(speed_mps: float) -> float:
    """Half a period of a damped oscillator: x = v/ω_d · e^(−ζωt) sin ω_d t."""
    mass, k, c = REVOLT.hull.m22_kg, 2.0 * 4000.0, 2.0 * 500.0
    omega, zeta = math.sqrt(k / mass), 0.5 * c / math.sqrt(k * mass)
    damped = omega * math.sqrt(1.0 - zeta * zeta)
    t_s = math.atan2(damped, zeta * omega) / damped
    return speed_mps / damped * math.exp(-zeta * omega * t_s) * math.sin(damped * t_s)


def test_compression_of_a_boat_that_drifts_on() -> None:
    line = berth()
    hull = hull_at(0.0, 0.36, sway_mps=-0.05)
    deepest_m = 0.0
    for _ in range(200):
        hull.step(*line.push(hull), 0.01)
        deepest_m = max(deepest_m, -line.gap_m)
    assert deepest_m == pytest.approx(compression_m(0.05), rel=0.1)


@pytest.mark.parametrize("share", [0.01, 1.0, 100.0])
def test_boats_of_any_mass_come_to_rest_alike(share: float) -> None:
    """Fenders as hard as ReVolt's throw a boat of 3 kg about, and a ship of 30 t sinks into them."""
    given = REVOLT.hull
    mass = {key: share * getattr(given, key) for key in ("m11_kg", "m22_kg", "m33_kgm2", "m23_kgm")}
    hull = Hull(replace(given, **mass, damping=DampingConfig(), m32_kgm=share * (given.m32_kgm or given.m23_kgm)))
    hull.place(0.0, 0.36, 0.0, 0.0, -0.05)
    dock = DockConfig(REVOLT.home.lat_deg, REVOLT.home.lon_deg, 0.0, "port", 2.0, 0.0)
    line = BerthModel(dock, REVOLT.home, REVOLT.length_m, REVOLT.beam_m, share * given.m22_kg)
    gaps_m = []
    for _ in range(400):
        hull.step(*line.push(hull), 0.01)
        gaps_m.append(line.gap_m)
    assert -min(gaps_m) == pytest.approx(compression_m(0.05), rel=0.05)
    assert abs(hull.sway_mps) < 0.04 and abs(hull.yaw_rate_radps) < 0.05


def test_a_long_ship_has_a_long_berth() -> None:
    dock = DockConfig(REVOLT.home.lat_deg, REVOLT.home.lon_deg, 0.0, "port", 8.0, 0.0)
    line = BerthModel(dock, REVOLT.home, 16.0, 4.5, 40000.0)
    line.push(hull_at(0.0, 2.24))
    assert line.gap_m == pytest.approx(-0.01) and line.force_n > 0.0


def test_a_world_has_the_vessels_berth_or_the_one_it_is_given() -> None:
    assert World(replace(REVOLT, dock=None)).berth is None
    lat_deg, lon_deg = LocalFrame(REVOLT.home.lat_deg, REVOLT.home.lon_deg).to_geodetic(0.0, -HALF_BEAM_M - 0.05)
    world = World(REVOLT, WorldConditions(dock=DockConfig(lat_deg, lon_deg, 0.0, "port", 2.0, 0.0)))
    world.set_state(sway_mps=-0.1)
    world.advance(20.0)
    assert world.berth is not None and world.berth.touch_sway_mps == pytest.approx(-0.1, abs=0.01)
    assert world.truth.east_m > -0.07 and world.berth.gap_m > -0.02
