"""Chop of the wind as a boat under way meets it."""

from __future__ import annotations

import itertools
import math
import statistics

import pytest

from companion.config.hull import HullConfig
from sitl.environment import WindModel
from sitl.hull import Hull
from sitl.seaway import Seaway

DT_S = 0.005
WIND_FROM_NORTH = 0.0


def sailed(
    speed_mps: float, yaw_rad: float, height_m: float = 0.5, rate_radps: float = 0.0, duration_s: float = 120.0
) -> list[tuple[float, ...]]:
    """Rows of (roll, roll rate, pitch, pitch rate, heave, surge_n, sway_n, yaw_nm) of a boat led along."""
    hull = Hull(HullConfig(472.5, 585.0, 741.0))
    sea = Seaway(WindModel(100.0 * height_m, WIND_FROM_NORTH, 1), 3.6, 1, hull, 472.5)
    rows = []
    north = east = 0.0
    for k in range(round(duration_s / DT_S)):
        yaw = yaw_rad + rate_radps * k * DT_S
        north, east = north + speed_mps * math.cos(yaw) * DT_S, east + speed_mps * math.sin(yaw) * DT_S
        hull.place(north, east, yaw, speed_mps)
        sea.update(k * DT_S)
        rows.append(
            (sea.roll_rad, sea.roll_rate_radps, sea.pitch_rad, sea.pitch_rate_radps, sea.heave_mps2, *sea.force())
        )
    return rows


def crossings_hz(values: list[float]) -> float:
    return sum(a < 0.0 <= b for a, b in itertools.pairwise(values)) / (len(values) * DT_S)


def test_head_seas_are_met_faster_than_following_ones() -> None:
    """ω_e = ω (1 + ω U / g) against them: between that of the longest and of the shortest component, 0.8 and 1.2 times
    2.97 s at half a metre."""
    for speed, rows in ((0.0, sailed(0.0, 0.0)), (8.0, sailed(8.0, 0.0))):
        omegas = [math.tau / (share * 4.2 * math.sqrt(0.5)) for share in (1.2, 0.8)]
        low, high = (omega * (1.0 + omega * speed / 9.81) / math.tau for omega in omegas)
        assert low < crossings_hz([row[2] for row in rows]) < high
    follows = sailed(4.0, math.pi)
    assert crossings_hz([row[2] for row in follows]) < 0.3


@pytest.mark.parametrize("rate_radps", [0.0, 0.4])
def test_rates_lead_from_attitude_to_attitude_also_in_a_turn(rate_radps: float) -> None:
    """Rates that leave the turning of the hull among the waves out had an inertial filter believe in tilt that was not
    there."""
    rows = sailed(6.0, 0.7, rate_radps=rate_radps, duration_s=30.0)
    for angle, rate in ((0, 1), (2, 3)):
        total = sum(row[rate] for row in rows[1:]) * DT_S
        assert total == pytest.approx(rows[-1][angle] - rows[0][angle], abs=1e-9)


def test_it_pushes_to_and_fro_and_turns() -> None:
    rows = sailed(8.0, math.radians(45.0))
    for column, least in ((4, 0.3), (5, 50.0), (6, 50.0), (7, 5.0)):
        values = [row[column] for row in rows]
        spread = statistics.pstdev(values)
        assert spread > least and abs(statistics.fmean(values)) < 0.1 * spread
    assert math.radians(1.0) < max(abs(row[0]) for row in rows) < math.radians(25.0)


def test_beam_seas_roll_and_head_seas_pitch() -> None:
    beam, head = sailed(0.0, math.radians(90.0)), sailed(0.0, 0.0)
    assert statistics.pstdev(row[0] for row in beam) > 2.0 * statistics.pstdev(row[2] for row in beam)
    assert statistics.pstdev(row[2] for row in head) > 2.0 * statistics.pstdev(row[0] for row in head)


def test_no_wind_is_flat_water() -> None:
    assert all(value == 0.0 for row in sailed(8.0, 0.3, height_m=0.0, duration_s=2.0) for value in row)
