"""A velocity over ground of a boat without sideways thrust, whose estimated current is wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.guidance.motion_request import MotionRequest
from companion.guidance.sideslip import SteeredHull
from companion.guidance.velocity_course import VelocityCourse
from companion.params.store import Parameters
from companion.params.table import table_of
from tests.unit.control.simple_boat import nav_state

DT = 0.1
OTTER = load(find("otter"))
PARAMETERS = Parameters(OTTER.parameters, table_of(OTTER))


class Drifting:
    """Speed comes a second late, the heading `late_s`, and unknown water carries the boat along."""

    def __init__(self, drift: tuple[float, float], known: tuple[float, float] | None, late_s: float = 1.0) -> None:
        self.late_s = late_s
        self.drift, self.known = drift, known
        self.yaw_rad = self.surge_mps = self.yaw_rate_radps = 0.0
        self.headings: list[float] = []
        self.made: list[tuple[float, float]] = []
        hull = replace(OTTER.hull, m22_kg=6.0 * OTTER.hull.m22_kg) if late_s > 1.0 else OTTER.hull
        self.course = VelocityCourse(PARAMETERS, 2.4, True, SteeredHull(hull) if late_s > 1.0 else None)
        self.course.start(self.nav())

    def nav(self) -> NavState:
        aside_mps = ned_to_body(*self.drift, self.yaw_rad)[1]
        return nav_state(
            yaw_rad=self.yaw_rad,
            surge_mps=self.surge_mps,
            sway_mps=aside_mps,
            yaw_rate_radps=self.yaw_rate_radps,
            current=self.known,
        )

    def sail(self, wanted: tuple[float, float], duration_s: float) -> tuple[float, float]:
        """The velocity over ground at the end."""
        for _ in range(round(duration_s / DT)):
            setpoint = self.course.update(MotionRequest(velocity=wanted), self.nav(), DT)
            assert setpoint.yaw_rad is not None
            turn = DT / self.late_s * wrap_pi(setpoint.yaw_rad - self.yaw_rad)
            self.yaw_rad, self.yaw_rate_radps = self.yaw_rad + turn, turn / DT
            self.surge_mps += DT * (setpoint.surge_mps - self.surge_mps)
            self.headings.append(self.yaw_rad)
            nav = self.nav()
            self.made.append((nav.north_mps, nav.east_mps))
        return self.made[-1]


@pytest.mark.parametrize("known", [(0.0, 0.0), (-0.15, 0.1), None])
@pytest.mark.parametrize("towards_deg", [0, 70, 130, 250])
def test_the_velocity_is_made_in_a_drift_that_the_estimate_does_not_know(
    known: tuple[float, float] | None, towards_deg: int
) -> None:
    """The current triangle alone left all of the drift that the estimate had wrong."""
    a = math.radians(towards_deg)
    boat = Drifting((0.25 * math.cos(a), 0.25 * math.sin(a)), known)
    assert boat.sail((0.6, 0.8), 60.0) == pytest.approx((0.6, 0.8), abs=0.01)
    assert boat.sail((0.0, -1.0), 60.0) == pytest.approx((0.0, -1.0), abs=0.01)


def test_it_comes_onto_the_velocity_without_swinging_past_it() -> None:
    boat = Drifting((0.0, 0.3), (0.0, 0.0))
    boat.sail((1.0, 0.0), 60.0)
    assert max(east for _, east in boat.made) < 0.31 and min(east for _, east in boat.made) > -0.03
    assert min(boat.headings) > boat.headings[-1] - math.radians(2.0)


def test_nothing_is_learnt_while_the_boat_turns_onto_the_course() -> None:
    boat = Drifting((0.0, 0.0), (0.0, 0.0))
    boat.sail((1.0, 0.0), 20.0)
    boat.sail((0.0, 1.0), 8.0)
    assert boat.made[-1] == pytest.approx((0.0, 1.0), abs=0.03)


@pytest.mark.parametrize("drift_mps", [0.0, 0.2])
def test_a_boat_whose_bow_follows_late_does_not_swing_past_the_course(drift_mps: float) -> None:
    """A ship of 12 m, whose bow follows in 5 s, snaked by 8 degrees."""
    boat = Drifting((drift_mps, 0.0), (0.0, 0.0), late_s=5.0)
    boat.sail((1.0, 0.0), 60.0)
    boat.made.clear()
    boat.sail((0.0, 1.0), 90.0)
    assert boat.made[-1] == pytest.approx((0.0, 1.0), abs=0.02)
    assert min(north for north, _ in boat.made) > -0.03
