"""Wind, current and waves: what is asked for, in the mean and in the spread."""

from __future__ import annotations

import math
import statistics

import pytest

from companion.config.hull import WindageConfig
from companion.config.vessel import ConfigError
from sitl.environment import AIR_DENSITY_KGPM3, CurrentModel, Waves, WindModel, parse_directed, wind_force


def test_parse_directed() -> None:
    assert parse_directed("2@45") == (2.0, pytest.approx(math.pi / 4))
    assert parse_directed("0.5@-90") == (0.5, pytest.approx(1.5 * math.pi))
    assert parse_directed("3") == (3.0, None)


@pytest.mark.parametrize("text", ["", "x", "2@", "2@north", "-1", "nan", "1@nan", "99", "2@45@3", "2@inf"])
def test_parse_directed_says_how_to_write_it(text: str) -> None:
    with pytest.raises(ConfigError, match=r"wind '.*': "):
        parse_directed(text, "wind")


def test_wind_has_its_mean_its_gusts_and_its_wander() -> None:
    wind = WindModel(8.0, 1.0, seed=3)
    speeds, directions = [], []
    for _ in range(60_000):
        wind.update(0.1)
        speeds.append(wind.speed_mps)
        directions.append(math.remainder(wind.from_rad - 1.0, 2.0 * math.pi))
    assert statistics.fmean(speeds) == pytest.approx(8.0, abs=0.3)
    assert statistics.stdev(speeds) == pytest.approx(1.2, abs=0.15)
    assert statistics.fmean(directions) == pytest.approx(0.0, abs=math.radians(4.0))
    assert statistics.stdev(directions) == pytest.approx(math.radians(8.0), abs=math.radians(2.0))
    lag = 100  # 10 s, the time constant of the gusts
    mean = statistics.fmean(speeds)
    covariance = statistics.fmean((a - mean) * (b - mean) for a, b in zip(speeds, speeds[lag:], strict=False))
    assert covariance / statistics.variance(speeds) == pytest.approx(math.exp(-1.0), abs=0.12)


def test_wind_from_the_north_blows_south() -> None:
    wind = WindModel(5.0, 0.0, seed=0)
    norths, easts = [], []
    for _ in range(36_000):
        wind.update(0.1)
        norths.append(wind.north_mps)
        easts.append(wind.east_mps)
    assert (statistics.fmean(norths), statistics.fmean(easts)) == pytest.approx((-5.0, 0.0), abs=0.2)


def test_missing_directions_come_from_the_seed() -> None:
    froms = {WindModel(2.0, None, seed).mean_from_rad for seed in range(20)}
    assert len(froms) == 20 and max(froms) - min(froms) > 3.0
    assert WindModel(2.0, None, 7).mean_from_rad == WindModel(2.0, None, 7).mean_from_rad
    assert (
        CurrentModel(0.2, None, 7).north_mps
        == CurrentModel(0.2, None, 7).north_mps
        != CurrentModel(0.2, None, 8).north_mps
    )


def test_no_wind_is_still() -> None:
    wind = WindModel(0.0, None, 1)
    for _ in range(100):
        wind.update(0.1)
    assert wind.speed_mps == 0.0


def test_current_sets_towards_its_direction() -> None:
    current = CurrentModel(0.3, math.pi / 2, 0)
    assert (current.north_mps, current.east_mps) == pytest.approx((0.0, 0.3))
    current.update(10.0)
    assert (current.north_mps, current.east_mps) == pytest.approx((0.0, 0.3))


def test_current_varies_slowly_where_asked() -> None:
    current = CurrentModel(0.3, 0.0, 5, variation_mps=0.05)
    norths = []
    for _ in range(60_000):
        current.update(1.0)
        norths.append(current.north_mps)
    assert statistics.fmean(norths) == pytest.approx(0.3, abs=0.01)
    assert statistics.stdev(norths) == pytest.approx(0.05, rel=0.15)


WINDAGE = WindageConfig(frontal_m2=0.35, lateral_m2=1.2)


def test_head_wind_pushes_astern() -> None:
    surge_n, sway_n, yaw_nm = wind_force(WINDAGE, 3.0, -10.0, 0.0)
    assert surge_n == pytest.approx(-0.5 * AIR_DENSITY_KGPM3 * 0.7 * 0.35 * 100.0)
    assert (sway_n, yaw_nm) == (0.0, 0.0)


def test_wind_from_starboard_pushes_to_port() -> None:
    surge_n, sway_n, yaw_nm = wind_force(WINDAGE, 3.0, 0.0, -10.0)
    assert sway_n == pytest.approx(-0.5 * AIR_DENSITY_KGPM3 * 0.9 * 1.2 * 100.0)
    assert (surge_n, yaw_nm) == (0.0, 0.0)


def test_wind_on_the_starboard_bow_turns_the_bow_away() -> None:
    component = -10.0 / math.sqrt(2.0)
    assert wind_force(WINDAGE, 3.0, component, component)[2] == pytest.approx(
        -0.5 * AIR_DENSITY_KGPM3 * 0.1 * 1.2 * 3.0 * 100.0
    )
    assert wind_force(WINDAGE, 3.0, component, -component)[2] > 0.0


def test_waves_roll_and_pitch_a_little_and_their_rates_are_their_derivatives() -> None:
    waves = Waves(WindModel(6.0, 0.0, 1), seed=1)
    rolls, pitches, before = [], [], 0.0
    for k in range(6000):
        waves.update(0.01 * k)
        if k:
            assert waves.roll_rate_radps == pytest.approx((waves.roll_rad - before) / 0.01, abs=2e-3)
        before = waves.roll_rad
        rolls.append(waves.roll_rad)
        pitches.append(waves.pitch_rad)
    assert 0.8 < math.degrees(max(rolls)) < 2.0
    assert 0.3 < math.degrees(max(pitches)) < 2.0
    assert waves.heave_m == 0.0
