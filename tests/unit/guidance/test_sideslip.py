"""The hull's own sideslip in turns, against the plant's equations."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.guidance.crab_compensation import CrabCompensation
from companion.guidance.sideslip import Sideslip, SteeredHull, steered_hull_of
from sitl.hull import dynamics
from tests.unit.control.simple_boat import nav_state
from tests.unit.guidance.test_long_hulls import LAUNCH

DT_S, SUB_STEPS = 0.1, 10
SPEED_MPS, PERIOD_S = 2.0, 14.0
OTTER = load(find("otter"))
RUDDER = steered_hull_of(LAUNCH)
assert RUDDER is not None


def weaving(steered: SteeredHull, moment_nm: float, duration_s: float = 60.0) -> list[tuple[float, float]]:
    """(sway, yaw rate) every DT_S of a boat at 2 m/s whose steering goes to and fro."""
    accelerations, v, r, found = dynamics(steered.hull), 0.0, 0.0, []
    for step in range(round(duration_s / DT_S)):
        moment = moment_nm * math.sin(math.tau * step * DT_S / PERIOD_S)
        for _ in range(SUB_STEPS):
            _, dv, dr = accelerations(SPEED_MPS, v, r, 0.0, moment * steered.steers_1pm, moment)
            v, r = v + dv * DT_S / SUB_STEPS, r + dr * DT_S / SUB_STEPS
        found.append((v, r))
    return found


@pytest.mark.parametrize(
    ("steered", "moment_nm"),
    [(RUDDER, 600.0), (SteeredHull(LAUNCH.hull), 600.0), (steered_hull_of(OTTER), 40.0)],
)
def test_it_is_the_sway_of_a_boat_that_weaves_in_still_water(steered: SteeredHull, moment_nm: float) -> None:
    sideslip = Sideslip(steered)
    motion = weaving(steered, moment_nm)
    largest = max(abs(v) for v, _ in motion)
    assert largest > 0.07
    for v, r in motion:
        slip = sideslip.update(nav_state(surge_mps=SPEED_MPS, sway_mps=v, yaw_rate_radps=r), DT_S)
        assert slip == pytest.approx(v, abs=0.12 * largest)


def test_what_it_is_of_a_bundled_vessel() -> None:
    assert steered_hull_of(load(find("revolt"))) is None
    otter, jet = steered_hull_of(OTTER), load(find("rescuerunner"))
    assert otter is not None and otter.steers_1pm == 0.0
    steered = steered_hull_of(jet)
    assert steered is not None and steered.steers_1pm == pytest.approx(1.0 / jet.thrusters[0].x_m)


def test_it_is_gone_after_the_turn_though_the_model_is_of_a_hull_that_does_not_go_straight() -> None:
    damping = replace(LAUNCH.hull.damping, n_uv=-1e5)
    sideslip = Sideslip(SteeredHull(replace(LAUNCH.hull, damping=damping), RUDDER.steers_1pm if RUDDER else 0.0))
    turning, straight = nav_state(surge_mps=SPEED_MPS, yaw_rate_radps=0.1), nav_state(surge_mps=SPEED_MPS)
    assert max(abs(sideslip.update(turning, DT_S)) for _ in range(100)) < SPEED_MPS
    assert abs([sideslip.update(straight, DT_S) for _ in range(400)][-1]) < 0.02


def test_a_boat_that_weaves_learns_the_stream_alone() -> None:
    """By its sway as it is, drift is learnt to and fro with the boat, and the bow swings all the more."""
    stream_mps = 0.1
    crab, blind = CrabCompensation(3.0, RUDDER), CrabCompensation(3.0)
    learnt: list[tuple[float, float]] = []
    for v, r in weaving(RUDDER, 300.0, 120.0) if RUDDER else ():
        nav = nav_state(surge_mps=SPEED_MPS, sway_mps=v + stream_mps, yaw_rate_radps=r)
        for one in (crab, blind):
            one.update(nav, SPEED_MPS, max(0.0, 1.0 - 2.0 * abs(r) / math.radians(12.0)), DT_S)
        learnt.append((crab.water(nav)[1], blind.water(nav)[1]))
    told, blindly = ([one[i] - stream_mps for one in learnt[600:]] for i in (0, 1))
    assert max(map(abs, told)) < 0.03 < 0.06 < max(map(abs, blindly))
