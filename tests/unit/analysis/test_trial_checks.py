"""Lever arms and offsets of an inertial sensor that is known; the words of a check. `test_trial_identify` has the rest."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from companion.analysis.log_reader import Log
from companion.analysis.manoeuvre import Manoeuvre
from companion.analysis.trial_checks import DEAD_BAND, Check, dead_band_check, inertial_checks
from companion.analysis.trial_identify import band_row, rescaled, sensor_rows
from companion.cli.new_file import file_text
from companion.config.devices import ThrusterConfig
from companion.config.dimensions.limits import figures
from companion.config.vessel import find, load, parse
from companion.config.yaw_limit import YawLimit
from companion.core.readings import Imu
from companion.nav.lever_arms import normal_gravity_mps2
from tests.unit.rudder_boat import ANSWERS

AHEAD_M, STARBOARD_M, OFFSET_MPS2 = 0.4, -0.15, 0.05
GRAVITY = normal_gravity_mps2(63.4389)


def spinning(rate_radps: float) -> Manoeuvre:
    """A minute on the spot, with a yaw rate to and fro."""
    t_s = np.arange(0.0, 60.0, 0.1)
    rate = rate_radps * np.sin(0.3 * t_s)
    velocity = np.stack([np.zeros_like(t_s), np.zeros_like(t_s), rate], axis=1)
    nothing = np.zeros((len(t_s), 1))
    return Manoeuvre(t_s, np.zeros_like(t_s), velocity, nothing, nothing, ((0, len(t_s)),), 0.1)


def sensed(rate_radps: float) -> list[Imu]:
    """What a sensor at that place measures, with noise."""
    noise = np.random.default_rng(7).normal(0.0, 0.05, (2, 6000))
    made = []
    for k, t_s in enumerate(np.arange(0.0, 60.0, 0.01).tolist()):
        r, turn = rate_radps * math.sin(0.3 * t_s), 0.3 * rate_radps * math.cos(0.3 * t_s)
        x = -r * r * AHEAD_M - turn * STARBOARD_M + OFFSET_MPS2 + noise[0, k]
        y = -r * r * STARBOARD_M + turn * AHEAD_M + noise[1, k]
        made.append(Imu(t_s, "imu", x, y, -GRAVITY, 0.0, 0.0, r, 0.0, 0.0))
    return made


@pytest.fixture(scope="module")
def log() -> Log:
    return Log(Path(), load(find("revolt")), {})


def test_the_place_of_a_sensor_shows_in_turns(log: Log) -> None:
    name = next(sensor.name for sensor in log.config.sensors if sensor.driver == "mtdata2")
    found = {check.name: check for check in inertial_checks(log, spinning(1.0), name, sensed(1.0))}
    ahead, starboard = found[f"{name}: place ahead"], found[f"{name}: place to starboard"]
    assert ahead.told and ahead.value == pytest.approx(AHEAD_M, abs=ahead.interval)
    assert starboard.told and starboard.value == pytest.approx(STARBOARD_M, abs=starboard.interval)
    offset = found[f"{name}: offset ahead"]
    assert offset.differs and offset.value == pytest.approx(OFFSET_MPS2, abs=0.01)
    assert found[f"{name}: gravity"].value == pytest.approx(GRAVITY, abs=0.01)


def test_without_turns_the_missing_manoeuvre_is_named(log: Log) -> None:
    name = next(sensor.name for sensor in log.config.sensors if sensor.driver == "mtdata2")
    found = {check.name: check for check in inertial_checks(log, spinning(0.005), name, sensed(0.005))}
    ahead = found[f"{name}: place ahead"]
    assert not ahead.told and not ahead.differs
    assert ahead.text.endswith("spins at 80 % to both sides would")


def test_a_value_is_told_with_its_interval_and_what_the_file_has() -> None:
    check = Check("gnss: place ahead", 0.31, 0.02, "m", 0.1)
    assert check.text == "gnss: place ahead: 0.31 ± 0.02 m; the file has 0.1, which is outside"
    assert not Check("gnss: place ahead", 0.31, 0.5, "m", 0.1).differs


def test_places_that_the_log_tells_stand_in_the_overlay() -> None:
    sensors = tuple(
        replace(load(find("otter")).sensors[0], name=name, x_m=-0.4, y_m=0.0, heading="none", antennas=1)
        for name in ("gnss", "other")
    )
    found = (
        Check("gnss: place ahead", 0.1, 0.2, "m", -0.4),
        Check("gnss: place to starboard", 0.3, 0.5, "m", 0.0),
        Check("other: place ahead", 0.1, 0.7, "m", -0.4, "spins"),
    )
    rows = tomllib.loads("\n".join(sensor_rows(sensors, found, 0.0)))["sensor"]
    assert rows == [{"name": "gnss", "x_m": 0.1}, {"name": "other", "x_m": -0.4}]
    turned = tomllib.loads("\n".join(sensor_rows((replace(sensors[0], antennas=2),), (), 0.1)))["sensor"]
    assert turned == [{"name": "gnss", "heading_offset_deg": pytest.approx(-5.73)}]


def test_a_dead_band_and_limits_that_are_as_before_stay(log: Log) -> None:
    """The file's came back with a second trial that found what the first one had told."""
    check = Check(DEAD_BAND, 0.06, 0.02, "of full throttle", 0.05)
    assert band_row(0.05, (check,)) == band_row(0.05, ()) == ["dead_band = 0.050"]
    assert band_row(0.0, (check,)) == []
    assert band_row(0.0, (replace(check, value=0.08),)) == ["dead_band = 0.080"]
    thrusters, limits = log.config.thrusters, log.config.limits
    assert rescaled(limits, thrusters, with_thrust(thrusters, 1.004)) == limits
    assert rescaled(limits, thrusters, with_thrust(thrusters, 0.5)).surge_n == pytest.approx(0.5 * limits.surge_n)


def with_thrust(thrusters: tuple[ThrusterConfig, ...], k: float) -> tuple[ThrusterConfig, ...]:
    return tuple(
        replace(t, max_n=k * t.max_n, min_n=k * t.min_n, ahead_n=k * t.ahead_n, astern_n=k * t.astern_n)
        for t in thrusters
    )


def test_limits_after_a_trial_are_those_of_the_thrusters_that_it_found() -> None:
    """A rudder that gives half as much again turns the boat harder. As they were, the limits would be somebody's choice
    to `YawLimit`, which then counts neither race nor speed for the rudders."""
    boat = parse(file_text(replace(ANSWERS, layout="two-rudders", spread_m=0.3)), "boat.toml")
    found = tuple(
        replace(t, rudder=replace(t.rudder, lift_scale=1.5 * t.rudder.lift_scale)) if t.rudder else t
        for t in with_thrust(boat.thrusters, 1.2)
    )
    limits = rescaled(boat.limits, boat.thrusters, found)
    surge, sway, yaw = figures(found)
    assert limits.surge_n == pytest.approx(surge.value, rel=0.01) and limits.sway_n == sway.value == 0.0
    assert limits.yaw_nm == pytest.approx(yaw.value, rel=0.01) and limits.yaw_nm > 1.25 * boat.limits.yaw_nm
    after = YawLimit(replace(boat, thrusters=found, limits=limits))
    assert after.nm(0.8 * limits.surge_n) > 1.2 * limits.yaw_nm


def test_a_wide_dead_band_is_checked_too(log: Log) -> None:
    """Above 0.245 the checks ended in an error, and the places of the sensors were not checked either."""
    thrusters = tuple(replace(thruster, dead_band=0.3) for thruster in log.config.thrusters)
    wide = replace(log, config=replace(log.config, thrusters=thrusters))
    evidence: Any = SimpleNamespace(squares=lambda band: 1e6 * (band - 0.32) ** 2)
    check = dead_band_check(evidence, wide)
    assert (check.file, check.value) == (0.3, pytest.approx(0.32)) and check.differs
