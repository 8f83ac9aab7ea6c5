"""Where a jet boat is expected to go that turns, against the plant with the allocation that really steers it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from companion.allocation.jet import JetAllocator
from companion.config.vessel import find, load
from companion.core.actuation import Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.obstacles.nozzle_turn import NozzleTurn
from companion.params.store import Parameters
from sitl.hull import Hull
from sitl.jet import Jet
from tests.unit.estimates import AT_REST

VESSEL = load(find("rescuerunner"))
PARAMETERS = Parameters(VESSEL.parameters)
DT_S, STEP_S, COUNT = 0.05, 0.5, 20


class Boat:
    """The plant, with a heading loop that asks for all of the moment and a speed loop."""

    def __init__(self, surge_mps: float) -> None:
        assert VESSEL.sitl is not None
        jet = VESSEL.thrusters[0].jet
        assert jet is not None
        self.hull = Hull(VESSEL.sitl.plants["as_estimated"].hull)
        self.hull.place(0.0, 0.0, 0.0, surge_mps)
        self.jet = Jet(VESSEL.thrusters[0], 0.5, jet)
        self.allocator = JetAllocator(VESSEL, PARAMETERS)

    def sail(self, yaw_rad: float, surge_mps: float, duration_s: float) -> None:
        hull, model = self.hull, VESSEL.hull
        most = math.radians(PARAMETERS["PATH_YAW_RATE"])
        for _ in range(round(duration_s / DT_S)):
            u = hull.water_surge_mps
            rate = max(-most, min(most, wrap_pi(yaw_rad - hull.yaw_rad)))
            yaw_nm = 1500.0 * (rate - hull.turn_radps) + (60.0 + 52.0 * u + 200.0 * abs(rate)) * rate
            surge_n = model.drag_n(surge_mps) + 0.8 * model.m11_kg * (surge_mps - u)
            held_nm = max(-VESSEL.limits.yaw_nm, min(VESSEL.limits.yaw_nm, yaw_nm))
            (command,) = self.allocator.update(Wrench(surge_n, 0.0, held_nm), DT_S, u).thrusters
            self.jet.demand(command.throttle, command.azimuth_rad)
            self.jet.step(DT_S, u)
            hull.step(*self.jet.wrench(), DT_S)

    def estimate(self) -> NavState:
        hull = self.hull
        return replace(
            AT_REST,
            north_m=hull.north_m,
            east_m=hull.east_m,
            yaw_rad=hull.yaw_rad,
            surge_mps=hull.water_surge_mps,
            sway_mps=hull.water_sway_mps,
            yaw_rate_radps=hull.turn_radps,
        )


def places(nav: NavState, yaw_rad: float, surge_mps: float) -> np.ndarray:
    """Predicted, shape (COUNT, 2)."""
    turn = NozzleTurn(VESSEL, PARAMETERS, STEP_S, COUNT)
    found = turn.predicted(np.array([yaw_rad]), np.array([surge_mps]), nav, np.array([math.inf]))
    speeds = np.stack((found.north_mps[0], found.east_mps[0]), axis=1)
    ways = np.cumsum(0.5 * STEP_S * (speeds[1:] + speeds[:-1]), axis=0)
    return np.array([nav.north_m, nav.east_m]) + np.vstack((np.zeros((1, 2)), ways))


@pytest.mark.parametrize("turn_deg", [45.0, -90.0, 170.0])
@pytest.mark.parametrize("surge_mps", [0.3, 1.3, 2.2])
def test_a_turn_leads_where_the_boat_goes(surge_mps: float, turn_deg: float) -> None:
    """Asked for 0.5 m/s it makes up to 2 m/s in the turn: 8 m in 6 s, where 3 m were expected."""
    boat = Boat(surge_mps)
    expected = places(boat.estimate(), math.radians(turn_deg), 0.5)
    boat.sail(math.radians(turn_deg), 0.5, 6.0)
    at = expected[round(6.0 / STEP_S)]
    assert math.dist(at, (boat.hull.north_m, boat.hull.east_m)) < 2.0


def test_a_boat_that_turns_goes_on_turning() -> None:
    """Told to turn back to starboard amid a turn to port, it turns on to port first."""
    boat = Boat(1.3)
    boat.sail(math.radians(-170.0), 0.5, 4.0)
    nav = boat.estimate()
    assert nav.yaw_rate_radps < -0.3
    expected = places(nav, nav.yaw_rad + math.radians(60.0), 0.5)
    boat.sail(nav.yaw_rad + math.radians(60.0), 0.5, 4.0)
    assert math.dist(expected[round(4.0 / STEP_S)], (boat.hull.north_m, boat.hull.east_m)) < 2.0


def test_in_a_stream_it_is_carried() -> None:
    nav = replace(AT_REST, yaw_rad=1.0, current_north_mps=0.0, current_east_mps=0.4)
    nav = replace(nav, surge_mps=0.4 * math.sin(1.0), sway_mps=0.4 * math.cos(1.0), east_mps=0.4)
    at = places(nav, 1.0, 0.4 * math.sin(1.0))[-1]
    assert at == pytest.approx((0.0, 0.4 * STEP_S * (COUNT - 1)), abs=0.05)
