"""Dead reckoning by the hull's model: when it speaks, what it says, and how sure it is."""

from __future__ import annotations

import itertools
import math

import pytest

from companion.config import vessel as vessel_config
from companion.core.actuation import Wrench
from companion.nav.current import CurrentObserver, GroundMotion
from companion.nav.solution import Motion
from companion.nav.velocity_aid import VelocityAid

REVOLT = vessel_config.load(vessel_config.find("revolt"))
DT_S = 0.1
THRUST_N = 25.0
SPEED_MPS = THRUST_N / REVOLT.hull.damping.x_u  # where thrust and drag agree
CURRENT = (0.1, -0.05)
FULL = Wrench(THRUST_N, 0.0, 0.0)


class Sail:
    """Straight ahead on a heading, at a steady speed through moving water; `north_mps`, `east_mps` are what the
    estimate says."""

    def __init__(self, yaw_rad: float = 0.5) -> None:
        self.observer = CurrentObserver(REVOLT)
        self.aid = VelocityAid(self.observer)
        self.yaw_rad, self.now_s, self.variance_m2 = yaw_rad, 0.0, 0.0
        self.north_mps = SPEED_MPS * math.cos(yaw_rad) + CURRENT[0]
        self.east_mps = SPEED_MPS * math.sin(yaw_rad) + CURRENT[1]

    def go(
        self, duration_s: float, measured: bool, thrust: Wrench | None = FULL, drift_mps2: float = 0.0
    ) -> list[tuple[float, float, float, float]]:
        """What the aid gives, as (t_s, north, east, sigma), and in `variance_m2` all that it adds to the position; `drift_mps2`: how the estimate goes wrong meanwhile."""
        given = []
        for k in range(round(duration_s / DT_S)):
            self.now_s += DT_S
            velocity = (self.north_mps + drift_mps2 * k * DT_S, self.east_mps, 0.0)
            motion = Motion(
                self.now_s, (0.0, 0.0, 0.0), velocity, (0.0, 0.0, self.yaw_rad), (0.0, 0.0, 0.0), 0.01, 0.01, 0.01
            )
            self.observer.update(
                self.now_s, thrust, GroundMotion(velocity[0], velocity[1], self.yaw_rad, 0.0, None, None), measured
            )
            aid = self.aid.update(self.now_s, measured, motion)
            if aid is not None:
                given.append((self.now_s, *aid[:3]))
                self.variance_m2 += aid.variance_m2
        return given


def test_a_velocity_comes_once_a_second_while_nothing_is_measured() -> None:
    sail = Sail()
    assert sail.go(60.0, measured=True) == []
    given = sail.go(10.0, measured=False)
    assert [b[0] - a[0] for a, b in itertools.pairwise(given)] == pytest.approx([1.0] * (len(given) - 1))
    assert 9 <= len(given) <= 10
    assert sail.go(5.0, measured=True) == []


def test_the_aid_does_not_follow_the_drifting_estimate() -> None:
    sail = Sail()
    sail.go(60.0, measured=True)
    for _, north, east, _ in sail.go(12.0, measured=False, drift_mps2=0.02):
        assert (north, east) == pytest.approx((sail.north_mps, sail.east_mps), abs=0.02)


def test_it_loses_speed_as_the_hull_does_when_thrust_ends() -> None:
    sail = Sail(0.0)
    sail.go(60.0, measured=True)
    rows = sail.go(6.0, measured=False, thrust=Wrench(0.0, 0.0, 0.0))
    t_s, north, _, _ = rows[-1]
    left = SPEED_MPS * math.exp(-(t_s - 60.0) * REVOLT.hull.damping.x_u / REVOLT.hull.m11_kg)
    assert north - CURRENT[0] == pytest.approx(left, abs=0.03)


def test_its_sigma_grows_with_the_gap_and_with_a_change_of_speed() -> None:
    steady, slowing = Sail(), Sail()
    for sail in (steady, slowing):
        sail.go(60.0, measured=True)
    first, *_, last = steady.go(12.0, measured=False)
    assert last[3] > 1.2 * first[3]
    assert slowing.go(12.0, measured=False, thrust=Wrench(0.0, 0.0, 0.0))[-1][3] > last[3]


def test_what_lasts_of_its_error_takes_the_position_off_in_proportion_to_time() -> None:
    """It has built up after a minute. Errors that come anew all the time would go with the root of it."""
    sail = Sail()
    sail.go(60.0, measured=True)
    off_m = []
    for _ in range(9):
        given = sail.go(10.0, measured=False)
        off_m.append(math.sqrt(sail.variance_m2))
    sigma_mps = given[-1][3] / math.sqrt(6.0)
    assert off_m[0] < 1.5 * sigma_mps
    assert off_m[8] - off_m[7] == pytest.approx(0.7 * 10.0 * sigma_mps, rel=0.1)
    sail.go(1.0, measured=True)
    before_m2 = sail.variance_m2
    sail.go(10.0, measured=False)
    assert math.sqrt(sail.variance_m2 - before_m2) == pytest.approx(off_m[0], rel=0.2)


def test_without_known_thrust_it_gives_none() -> None:
    sail = Sail()
    sail.go(60.0, measured=True, thrust=None)
    assert sail.go(10.0, measured=False) == []
    sail = Sail()
    sail.go(60.0, measured=True)
    sail.go(0.1, measured=False, thrust=None)
    assert sail.go(10.0, measured=False) == []


def test_a_swing_in_waves_is_not_carried_on() -> None:
    """The measurements end at the crest of an orbit: its velocity is no error of the model."""
    swinging, steady = Sail(), Sail()
    north_mps = swinging.north_mps
    for k in range(398):
        swinging.north_mps = north_mps + 0.4 * math.sin(math.tau * k * DT_S / 3.0)
        assert swinging.go(DT_S, measured=True) == []
    steady.go(39.8, measured=True)
    (_, swung, _, _), (_, calm, _, _) = swinging.go(5.0, measured=False)[-1], steady.go(5.0, measured=False)[-1]
    assert swung == pytest.approx(calm, abs=0.1)
