"""The scenarios that repeat the theses' trials: figures by leg, the turn of a sway demand, laws without supervision,
headings ashore."""

from __future__ import annotations

import math

import pytest

from sitl.hull import Hull
from sitl.scenarios import SCENARIOS, approach, follow, four_corner, route, shore_compass, sway_demand
from sitl.scenarios.positioning import PositioningLog
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import ScenarioError
from sitl.tow import TowedHull
from tests.unit.sitl.test_hull import SAILED

LEG_S = 10.0


def box(errors: list[tuple[float, float, float]], sway_over_rate_m: float = 0.0) -> PositioningLog:
    """One tick a second; each leg has one error (north m, east m, heading rad) throughout, and turns at 0.1 rad/s."""
    truth, ticks = [], []
    for k in range(round(len(errors) * LEG_S)):
        north, east, yaw = errors[int(k / LEG_S)]
        still = {"yaw_rate_radps": 0.1, "sway_mps": 0.1 * sway_over_rate_m}
        truth.append({"t_s": float(k), "north_m": north, "east_m": east, "yaw_rad": yaw, **still})
        ticks.append({"t_s": float(k), "desired_north_m": 0.0, "desired_east_m": 0.0, "desired_yaw_rad": 0.0})
    return PositioningLog(truth, ticks)


def test_the_leg_with_the_largest_error_of_each_kind() -> None:
    legs = [(0.1, 0.1, 0.0), (0.1, -0.9, 0.0), (0.1, 0.1, -0.2), (0.3, 0.2, 0.1), (-0.5, 0.1, 0.0)]
    found = four_corner.by_leg(box(legs), 0.0, LEG_S)
    assert (found["north_worst_leg"], found["east_worst_leg"], found["heading_worst_leg"]) == (5.0, 2.0, 3.0)
    assert (found["north_leg4_m"], found["east_leg4_m"]) == (0.3, 0.2)
    assert found["heading_leg4_deg"] == pytest.approx(math.degrees(0.1))


def test_a_boat_that_slides_to_port_as_it_turns_to_starboard_pivots_ahead_of_its_middle() -> None:
    found = four_corner.by_leg(box([(0.0, 0.0, 0.0)] * 5, sway_over_rate_m=-0.3), 0.0, LEG_S)
    assert found["pivot_m"] == pytest.approx(0.3)


def test_turn_and_way_are_positive_to_starboard_of_the_heading_at_first() -> None:
    track = [
        {"north_m": 1.0, "east_m": 1.0, "yaw_rad": math.pi / 2.0},
        {"north_m": -1.0, "east_m": 1.5, "yaw_rad": math.radians(-175.0)},
    ]
    turn_rad, way_m = sway_demand.turned(track)
    assert math.degrees(turn_rad) == pytest.approx(95.0) and way_m == pytest.approx(2.0)


def test_measured_levers_are_those_of_the_plant() -> None:
    def levers(**changes: str) -> list[float]:
        settings = {**SCENARIOS["sway_demand"].defaults, **changes}
        prepared = sway_demand.prepare(Conditions("revolt", plant=changes.get("plant")), settings)
        return [] if prepared.known is None else [one.x_m for one in prepared.known.thrusters]

    assert levers() == []
    assert levers(levers="measured") == [-1.12, -1.12, 1.12]
    assert levers(levers="measured", plant="thesis") == [-1.65, -1.65, 1.15], "this plant has none of its own"
    with pytest.raises(ScenarioError, match="file, measured"):
        levers(levers="guessed")


def test_the_theses_boats_doubt_neither_thruster_nor_sensor() -> None:
    unwatched = {"THR_WATCH": 0.0, "NAV_INTEG": 0.0}
    own = follow.prepare(Conditions("rescuerunner"), {**follow.DEFAULTS, "law": "thesis"}).parameters
    assert unwatched.items() <= own.items()
    settings = {**SCENARIOS["route"].defaults, "law": "thesis", "gains": "100/40/0"}
    gains = {"WPT_KP_YAW": 100.0, "WPT_KI_YAW": 40.0, "WPT_KD_YAW": 0.0}
    assert route.prepare(Conditions("aboat"), settings).parameters == {**unwatched, **gains}


@pytest.mark.parametrize("module", [follow, approach])
def test_ours_stays_watched(module: object) -> None:
    prepare, defaults = module.prepare, module.SCENARIO.defaults  # type: ignore[attr-defined]
    assert not {"THR_WATCH", "NAV_INTEG"} & prepare(Conditions("rescuerunner"), defaults).parameters.keys()
    assert route.prepare(Conditions("aboat"), SCENARIOS["route"].defaults) == Conditions("aboat")


@pytest.mark.parametrize(
    ("changes", "told"), [({"law": "thesis", "gains": "1/2"}, "KP/KI/KD"), ({"gains": "1/2/3"}, "only with")]
)
def test_gains_of_a_route_that_are_none(changes: dict[str, str], told: str) -> None:
    with pytest.raises(ScenarioError, match=told):
        route.prepare(Conditions("aboat"), {**SCENARIOS["route"].defaults, **changes})


def test_the_boards_ashore_turn_once_around_in_sixteen_steps_and_stay_where_they_are() -> None:
    legs = shore_compass.legs({})
    hull: Hull = TowedHull(SAILED, legs)
    turned, last, rest = 0.0, 0.0, []
    for k in range(round(sum(leg.duration_s for leg in legs) * 20.0)):
        hull.step(0.0, 0.0, 0.0, 0.05)
        turned += math.remainder(hull.yaw_rad - last, math.tau)
        last = hull.yaw_rad
        if (k + 1) % 340 == 260:  # 30 s, then every 17 s: the end of a rest
            rest.append(abs(hull.yaw_rate_radps))
    assert math.degrees(turned) == pytest.approx(360.0, abs=1.0)
    assert math.hypot(hull.north_m, hull.east_m) < 0.01 and max(rest) < 1.0e-6
