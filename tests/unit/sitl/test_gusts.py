"""Gusts by their spectra, against the variance in closed form; the wind's profile; heel and the centre of windage."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from companion.config.vessel import ConfigError, VesselConfig, find, load
from sitl.gusts import SPECTRA, Gusts, at_height, at_ten_metres, davenport, kaimal, npd, parse_wind
from sitl.plant_error import with_wrong_windage
from sitl.world import World, WorldConditions, chosen_plant

REVOLT = load(find("revolt"))


def test_texts() -> None:
    assert parse_wind("6@90/npd") == (6.0, pytest.approx(0.5 * math.pi), "npd")
    assert parse_wind("6") == (6.0, None, "")
    for text in ("6/storm", "6@90/", "strong/npd"):
        with pytest.raises(ConfigError):
            parse_wind(text)


def test_davenport_holds_six_times_the_drag_of_the_surface() -> None:
    """∫ 4 κ U² χ/(1 + χ²)^(4/3) dχ = 6 κ U²."""
    total = quad(lambda x: float(davenport(np.array([math.exp(x)]), 8.0, 10.0)[0]) * math.exp(x), -20.0, 8.0)[0]
    assert total == pytest.approx(6.0 * 0.0015 * 64.0, rel=0.02)


def test_kaimal_holds_its_share_of_the_friction() -> None:
    """∫ 105/(1 + 33 n)^(5/3) dn = 105 · 3/(2 · 33) = 4.77 u*²."""
    total = quad(lambda x: float(kaimal(np.array([math.exp(x)]), 8.0, 2.0)[0]) * math.exp(x), -25.0, 15.0)[0]
    friction = 0.4 * 8.0 / math.log(10.0 / 0.0002)
    assert total == pytest.approx(105.0 * 1.5 / 33.0 * friction**2, rel=0.02)


def test_npd_at_ten_metres_and_ten_metres_a_second() -> None:
    """320/(1 + (172 f)^0.468)^3.561, written out at one frequency."""
    assert npd(np.array([0.01]), 10.0, 10.0)[0] == pytest.approx(320.0 / (1.0 + 1.72**0.468) ** (5.0 / 1.404))


@pytest.mark.parametrize("name", SPECTRA)
def test_gusts_have_the_spectrum_s_variance(name: str) -> None:
    gusts = Gusts(name, 8.0, 2.0, 3)
    values = [gusts.update(0.5) for _ in range(20_000)]
    f_hz = np.geomspace(1.0 / 600.0, 1.0, 5000)
    density = SPECTRA[name][0](f_hz, 8.0, 2.0)
    wanted = float(np.sum(0.5 * (density[1:] + density[:-1]) * np.diff(f_hz)))
    assert statistics.pvariance(values) == pytest.approx(wanted, rel=0.1)
    assert statistics.fmean(values) == pytest.approx(0.0, abs=0.1)


def test_the_wind_is_weaker_near_the_water() -> None:
    for name in SPECTRA:
        assert at_height(name, 8.0, 10.0) == pytest.approx(8.0)
        assert 0.5 * 8.0 < at_height(name, 8.0, 1.0) < 0.95 * 8.0
    world = World(REVOLT, WorldConditions(wind="8@90/npd"))
    assert 4.0 < world.wind.mean_mps < 7.5


@pytest.mark.parametrize("name", SPECTRA)
@pytest.mark.parametrize(("wind_mps", "height_m"), [(3.0, 0.135), (12.0, 0.135), (13.9, 0.135), (12.0, 2.0)])
def test_the_wind_at_ten_metres_makes_that_at_the_boat(name: str, wind_mps: float, height_m: float) -> None:
    assert at_height(name, at_ten_metres(name, wind_mps, height_m), height_m) == pytest.approx(wind_mps)


def test_a_wind_that_no_profile_makes_at_the_boat_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"wind of 15 m/s at the boat, 0\.14 m .* 14\.1 m/s .* at most; ask for less"):
        at_ten_metres("npd", 15.0, 0.135)


def with_centre(centre: tuple[float, float] | None) -> VesselConfig:
    sitl = REVOLT.sitl
    assert sitl is not None
    plant = replace(sitl.plants[sitl.plant], wind_centre_m=centre)
    return replace(REVOLT, sitl=replace(sitl, plants={**sitl.plants, sitl.plant: plant}))


def test_wind_heels_to_leeward_and_turns_about_its_centre() -> None:
    heeled, turned = {}, {}
    for centre in (None, (0.4, 0.5)):
        world = World(with_centre(centre), WorldConditions(wind="6@270"))  # from port
        rolls = []
        for k in range(1, 101):
            world.advance(0.1 * k)
            rolls.append(world.waves.roll_rad)
        heeled[centre], turned[centre] = statistics.fmean(rolls[20:]), world.truth.yaw_rad
    assert heeled[0.4, 0.5] - heeled[None] > math.radians(0.5)
    assert math.remainder(turned[0.4, 0.5] - turned[None], math.tau) > math.radians(2.0)


def test_windage_is_wrong_by_the_share_that_was_asked() -> None:
    plant, ratios = chosen_plant(REVOLT, None), set()
    right = plant.windage
    for seed in range(8):
        wrong = with_wrong_windage(plant, 0.3, seed)
        assert replace(wrong, windage=right) == plant
        windage = wrong.windage
        ratios.add((round(windage.frontal_m2 / right.frontal_m2, 6), round(windage.lateral_m2 / right.lateral_m2, 6)))
    assert ratios == {(a, b) for a in (0.7, 1.3) for b in (0.7, 1.3)}
    with pytest.raises(ConfigError, match="share from 0 to below 1"):
        with_wrong_windage(plant, 1.5, 0)


def test_the_world_sails_the_wrong_windage_that_was_asked_for() -> None:
    drifted = {}
    for error in (None, 0.5):
        world = World(REVOLT, WorldConditions(wind="6@90", windage_error=error))
        world.advance(5.0)
        drifted[error] = abs(world.truth.east_m)
    assert abs(drifted[0.5] / drifted[None] - 1.0) > 0.3


@pytest.mark.parametrize("name", SPECTRA)
def test_the_wind_at_ten_metres_is_found_again(name: str) -> None:
    assert at_ten_metres(name, at_height(name, 8.0, 0.3), 0.3) == pytest.approx(8.0)
