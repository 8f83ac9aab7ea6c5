"""What the hull model tells the estimate."""

from __future__ import annotations

import math

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.nav.model_aid import ModelAid
from companion.nav.solution import Motion
from companion.nav.validity import Validity
from companion.params.store import Parameters

TICK_S = 0.1
REVOLT = load(find("revolt"))


def motion(north_mps: float) -> Motion:
    return Motion(0.0, (0.0, 0.0, 0.0), (north_mps, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.01, 0.02, 0.01)


def aid(config: VesselConfig = REVOLT) -> tuple[ModelAid, Validity]:
    parameters = Parameters(config.parameters)
    return ModelAid(config, parameters), Validity(parameters)


def drift(model: ModelAid, validity: Validity, seconds: float, from_s: float = 0.0) -> list[tuple[float, ...]]:
    """A boat without thrust, carried to the north at 0.2 m/s; what is fused."""
    fused = []
    for k in range(1, round(seconds / TICK_S) + 1):
        now_s = from_s + k * TICK_S
        model.observe(now_s, ZERO_WRENCH, motion(0.2), None, validity)
        found = model.velocity(now_s, motion(0.2), validity)
        fused += [found] if found is not None else []
    return fused


def test_a_silent_receiver_is_stood_in_for_by_the_current() -> None:
    model, validity = aid()
    for k in range(300):
        validity.position(k * TICK_S, 0.0)
        assert drift(model, validity, TICK_S, k * TICK_S) == []
    fused = drift(model, validity, 3.0, 30.0)
    assert fused and fused[0][:2] == (pytest.approx(0.2, abs=0.02), pytest.approx(0.0, abs=0.02))
    model.begin_anew()
    assert drift(model, validity, 3.0, 33.0) == []


def test_speeds_that_no_boat_of_that_kind_has_are_impossible() -> None:
    model, _ = aid()
    assert not model.is_impossible(motion(6.0))
    assert model.is_impossible(motion(12.0)) and model.is_impossible(motion(math.inf))


def test_waves_are_looked_for_where_the_parameter_says() -> None:
    model, _ = aid()
    off = ModelAid(REVOLT, Parameters({**REVOLT.parameters, "DP_WAVES": 0.0}))
    assert off.waves(0.1, ZERO_WRENCH, motion(0.0), None) is None
    for k in range(1, 600):
        now_s = k * TICK_S
        rocked = motion(0.3 * math.sin(5.0 * now_s))
        found = model.waves(now_s, ZERO_WRENCH, rocked, None)
        assert off.waves(now_s, ZERO_WRENCH, rocked, None) is None
    assert found is not None


def test_the_wind_on_the_hull_is_no_wave() -> None:
    """A boat in waves whose thrust counters what a gust pushes it with by the model."""
    model, _ = aid()
    area_n = 0.8 * 0.5 * 1.225 * REVOLT.windage.cx * REVOLT.windage.frontal_m2
    taken = []
    for k in range(1, 700):
        now_s = k * TICK_S
        gust_mps = 12.0 * min(1.0, max(0.0, 0.5 * (now_s - 40.0)))
        rocked = motion(0.1 * math.sin(3.3 * now_s))
        found = model.waves(now_s, Wrench(-area_n * gust_mps**2, 0.0, 0.0), rocked, (gust_mps, 0.0))
        taken.append(0.0 if found is None else found.north_mps)
    whole = round(math.tau / 3.3 / TICK_S)
    assert max(abs(sum(taken[k : k + whole]) / whole) for k in range(390, 600)) < 0.01
