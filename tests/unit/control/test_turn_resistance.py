"""How much harder the water resists a turn than the vessel's file says: learned from turns, and steered with."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.control.model import coriolis, damping
from companion.control.turn_resistance import TurnResistance
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import NO_ESTIMATE, NavState
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters

OTTER = load(find("otter"))
DT_S = 0.1
SURGE_MPS, SWAY_MPS = 1.2, -0.1


class Turning:
    """A boat at a steady speed whose yaw the water resists `harder` times as the model says."""

    def __init__(self, harder: float) -> None:
        self.harder, self.rate_radps, self.t_s = harder, 0.0, 0.0

    @property
    def nav(self) -> NavState:
        return replace(
            NO_ESTIMATE, t_s=self.t_s, surge_mps=SURGE_MPS, sway_mps=SWAY_MPS, yaw_rate_radps=self.rate_radps
        )

    def step(self, moment_nm: float) -> None:
        hull = OTTER.hull
        _, _, munk = coriolis(hull, SURGE_MPS, SWAY_MPS, 0.0)
        munk += hull.damping.n_uv * SURGE_MPS * SWAY_MPS
        for _ in range(10):
            resisted_nm = self.harder * damping(hull, SURGE_MPS, 0.0, self.rate_radps)[2]
            self.rate_radps += 0.1 * DT_S * (moment_nm - munk - resisted_nm) / hull.m33_kgm2
        self.t_s += DT_S


def learned(harder: float, turns: int = 4, seconds: float = 6.0, moment_share: float = 0.6) -> TurnResistance:
    """After turns to alternate sides, with straight ways between them."""
    boat, resistance = Turning(harder), TurnResistance(OTTER)
    for turn in range(turns):
        for moment_nm in ((-1.0) ** turn * moment_share * OTTER.limits.yaw_nm, 0.0):
            for _ in range(round(seconds / DT_S)):
                boat.step(moment_nm)
                resistance.update(boat.nav, Wrench(30.0, 0.0, moment_nm), DT_S)
    return resistance


@pytest.mark.parametrize("harder", [2.0, 3.0, 4.0])
def test_it_learns_what_turns_tell(harder: float) -> None:
    """By the first turn that it is marked, by four what it is."""
    assert learned(harder, turns=1).factor > 1.0 + 0.4 * (harder - 1.0)
    assert learned(harder).factor == pytest.approx(harder, rel=0.15)


@pytest.mark.parametrize("harder", [0.5, 0.8, 1.0, 1.2])
def test_a_file_that_is_about_right_is_believed(harder: float) -> None:
    assert learned(harder).factor == 1.0


def test_a_straight_way_tells_nothing() -> None:
    assert learned(3.0, moment_share=0.02).factor == 1.0


def test_it_stays_within_bounds_and_can_be_forgotten() -> None:
    resistance = learned(8.0, turns=12)
    assert resistance.factor == 5.0
    resistance.restart()
    assert resistance.factor == 5.0
    resistance.reset()
    assert resistance.factor == 1.0


def test_no_number_teaches_nothing() -> None:
    resistance = TurnResistance(OTTER)
    for nav in (replace(NO_ESTIMATE, surge_mps=math.nan), Turning(1.0).nav):
        for wrench in (Wrench(0.0, 0.0, math.inf), ZERO_WRENCH):
            resistance.update(nav, wrench, DT_S)
    assert resistance.factor == 1.0


def lag_deg(harder: float, rate_dps: float = 6.0) -> float:
    """How far the bow is behind a heading that turns steadily, after six such turns of a quarter of a minute."""
    loop, boat, bias = YawLoop(OTTER, Parameters(OTTER.parameters)), Turning(harder), BiasForce(OTTER.limits)
    yaw_rad = wanted_rad = given_nm = 0.0
    for k in range(900):
        rate = math.radians(rate_dps) * (1.0 if k // 150 % 2 == 0 else -1.0)
        wanted_rad += rate * DT_S
        loop.pushes(Wrench(30.0, 0.0, given_nm))
        setpoint = PathSetpoint(wanted_rad, SURGE_MPS, 0.0, rate)
        asked_nm = loop.moment_nm(setpoint, replace(boat.nav, yaw_rad=yaw_rad), bias, DT_S)
        given_nm = min(OTTER.limits.yaw_nm, max(-OTTER.limits.yaw_nm, asked_nm))
        boat.step(given_nm)
        yaw_rad += boat.rate_radps * DT_S
    return abs(math.degrees(wanted_rad - yaw_rad))


def test_the_bow_follows_a_turn_that_the_water_resists() -> None:
    """A RIB of 3 m in rough water, whose propeller lost momentum across its shaft, was 20 degrees behind its heading
    and swung to and fro across its track."""
    assert lag_deg(1.0) < 2.0
    assert lag_deg(2.5) < 1.5
