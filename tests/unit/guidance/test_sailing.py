"""What the wind allows: headings, tacks, turns, and what happens when the wind is not known."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, find, load, parse
from companion.core.actuation import ZERO_WRENCH, ThrusterCommand, Wrench
from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.setpoint import (
    HeadingSetpoint,
    NeutralSetpoint,
    PathSetpoint,
    PoseSetpoint,
    Progress,
    Setpoint,
    ThrusterSetpoint,
    WrenchSetpoint,
)
from companion.guidance.sailing import Sailor
from companion.params.store import Parameters
from companion.params.table import table_of
from tests.unit.config.test_sail import with_motor
from tests.unit.estimates import AT_REST

BOAT = load(find("sailbot"))
NORTH = 0.0  # where the wind comes from
LEAD_DEG = 30.0  # of the bow in a tack


class Crew:
    """A sailor with a boat that goes where it is told, and what it says."""

    def __init__(self, fence_east_m: float = math.inf, boat: VesselConfig = BOAT, **parameters: float) -> None:
        self.texts: list[str] = []
        self.kinds: list[TextKind] = []
        self.now_s = 0.0
        self.store = Parameters({**boat.parameters, **parameters}, table_of(boat))
        self.sailor = Sailor(boat, self.store, self._say, lambda _a, b: b[1] <= fence_east_m)

    def _say(self, _t_s: float, kind: TextKind, _name: str, text: str) -> None:
        self.texts.append(text)
        self.kinds.append(kind)

    def steer(self, setpoint: Setpoint, nav: NavState, times: int = 1) -> Setpoint:
        for _ in range(times):
            found = self.sailor.steer(setpoint, nav, self.now_s, 0.1)
            self.now_s += 0.1
        return found

    def heading_deg(self, setpoint: Setpoint, nav: NavState, times: int = 1) -> float:
        found = self.steer(setpoint, nav, times)
        assert isinstance(found, HeadingSetpoint)
        return math.degrees(found.yaw_rad) % 360.0


def sailing(yaw_deg: float, wind_mps: float | None = 5.0, surge_mps: float = 1.2, east_m: float = 0.0) -> NavState:
    """Under way, in a wind from north."""
    yaw = math.radians(yaw_deg)
    return replace(
        AT_REST,
        yaw_rad=math.remainder(yaw, math.tau),
        surge_mps=surge_mps,
        north_mps=surge_mps * math.cos(yaw),
        east_mps=surge_mps * math.sin(yaw),
        east_m=east_m,
        wind_speed_mps=wind_mps,
        wind_from_rad=None if wind_mps is None else NORTH,
    )


def to(course_deg: float, cross_m: float = 0.0, distance_m: float = 100.0) -> PathSetpoint:
    """A goal in that direction, on a leg of that course."""
    course = math.radians(course_deg)
    bearing = course - math.asin(cross_m / distance_m)
    progress = Progress(cross_track_error_m=cross_m, course_rad=course, distance_to_go_m=distance_m)
    return PathSetpoint(bearing, 2.5, progress=progress)


def test_a_course_that_the_wind_allows_is_sailed() -> None:
    assert Crew().heading_deg(to(90.0), sailing(90.0)) == pytest.approx(90.0, abs=0.5)


def test_off_the_line_it_comes_back_to_it() -> None:
    assert 90.0 < Crew().heading_deg(to(90.0, cross_m=-5.0), sailing(90.0)) < 150.0


def test_against_the_wind_it_beats_on_the_tack_that_it_is_on() -> None:
    crew = Crew()
    assert crew.heading_deg(to(0.0), sailing(50.0)) == pytest.approx(45.0, abs=2.0)
    assert crew.texts == ["Beating, port tack"]
    assert Crew().heading_deg(to(0.0), sailing(310.0)) == pytest.approx(315.0, abs=2.0)


def test_it_begins_a_beat_on_the_tack_that_leads_much_nearer() -> None:
    assert Crew().heading_deg(to(30.0), sailing(310.0)) == pytest.approx(310.0 + LEAD_DEG, abs=2.0)


def test_it_tacks_at_the_edge_of_the_corridor_and_not_at_once_again() -> None:
    crew = Crew()
    crew.steer(to(0.0), sailing(45.0), 100)
    assert crew.heading_deg(to(0.0, 14.0), sailing(45.0)) == pytest.approx(45.0, abs=2.0)
    assert crew.heading_deg(to(0.0, 16.0), sailing(45.0)) == pytest.approx(45.0 - LEAD_DEG, abs=2.0)
    assert crew.texts[-1] == "Tacking: starboard tack"
    assert crew.heading_deg(to(0.0, 16.0), sailing(315.0), 100) == pytest.approx(315.0, abs=2.0)


def test_it_tacks_where_the_other_tack_leads_to_the_goal() -> None:
    crew = Crew()
    crew.steer(to(0.0), sailing(45.0), 100)
    assert crew.heading_deg(to(300.0), sailing(45.0)) == pytest.approx(45.0 - LEAD_DEG, abs=1.0)
    assert not crew.sailor.beats


def test_it_tacks_before_the_fence() -> None:
    crew = Crew(fence_east_m=20.0)
    crew.steer(to(0.0), sailing(45.0), 100)
    assert crew.heading_deg(to(0.0), sailing(45.0, east_m=10.0)) == pytest.approx(45.0, abs=2.0)
    assert crew.heading_deg(to(0.0), sailing(45.0, east_m=13.0)) == pytest.approx(45.0 - LEAD_DEG, abs=2.0)


def test_it_tacks_as_asked_only_while_it_beats() -> None:
    crew = Crew()
    crew.steer(to(90.0), sailing(90.0))
    assert not crew.sailor.ask_tack()
    crew.steer(to(0.0), sailing(45.0), 100)
    assert crew.sailor.ask_tack()
    assert crew.heading_deg(to(0.0), sailing(45.0)) == pytest.approx(45.0 - LEAD_DEG, abs=2.0)


def test_in_a_tack_the_sail_luffs_near_the_wind() -> None:
    crew = Crew()
    crew.steer(to(0.0), sailing(45.0), 100)
    crew.sailor.ask_tack()
    crew.steer(to(0.0), sailing(45.0))
    near, far = crew.steer(to(0.0), sailing(20.0)), crew.steer(to(0.0), sailing(318.0))
    assert isinstance(near, HeadingSetpoint) and near.wrench == ZERO_WRENCH
    assert isinstance(far, HeadingSetpoint) and far.wrench.surge_n > 0.0


def test_a_tack_that_fails_is_followed_by_a_turn_before_the_wind() -> None:
    crew = Crew(SAIL_TACK_T=5.0)
    crew.steer(to(0.0), sailing(45.0), 100)
    crew.sailor.ask_tack()
    assert crew.heading_deg(to(0.0), sailing(30.0), 45) == pytest.approx(30.0 - LEAD_DEG, abs=2.0)
    assert crew.heading_deg(to(0.0), sailing(30.0), 10) == pytest.approx(130.0, abs=2.0)
    assert "Tack failed: gybing instead" in crew.texts
    assert crew.heading_deg(to(0.0), sailing(170.0)) == pytest.approx(270.0, abs=2.0)
    assert crew.heading_deg(to(0.0), sailing(200.0)) == pytest.approx(315.0, abs=2.0)


def test_a_bow_that_falls_back_in_a_tack_is_not_held_there() -> None:
    crew = Crew(SAIL_TACK_T=30.0)
    crew.steer(to(0.0), sailing(45.0), 100)
    crew.sailor.ask_tack()
    crew.steer(to(0.0), sailing(20.0), 25)
    assert crew.heading_deg(to(0.0), sailing(52.0), 3) == pytest.approx(52.0 - LEAD_DEG, abs=2.0)
    assert crew.heading_deg(to(0.0), sailing(52.0), 10) == pytest.approx(152.0, abs=2.0)
    assert "Tack failed: gybing instead" in crew.texts


def test_past_the_wind_the_boat_steers_for_the_other_tack() -> None:
    crew = Crew()
    crew.steer(to(0.0), sailing(45.0), 100)
    crew.sailor.ask_tack()
    crew.steer(to(0.0), sailing(45.0))
    assert crew.heading_deg(to(0.0), sailing(355.0)) == pytest.approx(315.0, abs=2.0)


def test_without_way_it_bears_away_before_a_tack_and_then_wears_round() -> None:
    crew = Crew()
    crew.steer(to(0.0), sailing(45.0), 100)
    crew.sailor.ask_tack()
    slow = sailing(45.0, surge_mps=0.2)
    assert crew.heading_deg(to(0.0), slow) == pytest.approx(60.0, abs=2.0)
    assert crew.heading_deg(to(0.0), slow, 130) == pytest.approx(145.0, abs=2.0)


@pytest.mark.parametrize("yaw_deg", [86.0, 90.0, 94.0])
def test_a_turn_right_round_keeps_its_direction(yaw_deg: float) -> None:
    """Both ways are about as long: the boat must not change its mind."""
    crew = Crew()
    crew.steer(to(270.0), sailing(88.0))
    assert crew.heading_deg(to(270.0), sailing(yaw_deg)) == pytest.approx(yaw_deg + 100.0, abs=2.0)


def test_from_reach_to_reach_it_gybes() -> None:
    assert Crew().heading_deg(to(285.0), sailing(80.0), 2) == pytest.approx(180.0, abs=2.0)


def test_weather_helm_is_learned_and_changes_its_side_with_the_tack() -> None:
    """Close-hauled the boat lies 5 degrees off the heading, to windward: it is steered further off, on both tacks."""
    crew = Crew()
    assert crew.heading_deg(to(0.0), sailing(40.0), 60) == pytest.approx(50.0, abs=1.0)
    crew.sailor.ask_tack()
    crew.steer(to(0.0), sailing(40.0), 60)
    assert crew.heading_deg(to(0.0), sailing(315.0)) == pytest.approx(315.0 - 5.0, abs=2.0)


def test_a_goal_that_was_missed_is_sailed_back_to() -> None:
    """Beyond it the line leads on: against the wind, for ever."""
    progress = Progress(cross_track_error_m=13.0, course_rad=0.0, distance_to_go_m=20.0)
    back = PathSetpoint(math.radians(220.0), 2.5, progress=progress)
    assert Crew().heading_deg(back, sailing(200.0)) == pytest.approx(220.0, abs=1.0)
    beside = PathSetpoint(math.radians(280.0), 2.5, progress=progress)
    assert Crew().heading_deg(beside, sailing(280.0)) == pytest.approx(280.0, abs=1.0)


def test_a_slower_speed_is_less_drive() -> None:
    fast, slow = (
        Crew().steer(replace(to(90.0), surge_mps=speed), sailing(90.0, surge_mps=0.5)) for speed in (2.5, 0.6)
    )
    assert isinstance(fast, HeadingSetpoint) and isinstance(slow, HeadingSetpoint)
    assert 0.0 < slow.wrench.surge_n < fast.wrench.surge_n == BOAT.limits.surge_n


def test_a_pose_is_a_goal_in_its_direction() -> None:
    assert Crew().heading_deg(PoseSetpoint(0.0, 50.0, 0.0, 1.0), sailing(90.0)) == pytest.approx(90.0, abs=1.0)


def test_a_heading_of_the_sticks_stays_out_of_the_no_go_zone_under_drive() -> None:
    def held(yaw_deg: float, surge_n: float) -> float:
        return Crew().heading_deg(HeadingSetpoint(math.radians(yaw_deg), Wrench(surge_n, 0.0, 0.0)), sailing(60.0))

    assert held(20.0, 5.0) == pytest.approx(45.0, abs=2.0)
    assert held(20.0, 0.0) == pytest.approx(20.0, abs=2.0)
    assert held(70.0, 5.0) == pytest.approx(70.0, abs=2.0)


def test_weather_helm_is_made_up_for_under_the_sticks_too() -> None:
    crew, setpoint = Crew(), HeadingSetpoint(math.radians(90.0), Wrench(5.0, 0.0, 0.0))
    assert crew.heading_deg(setpoint, sailing(85.0), 60) == pytest.approx(95.0, abs=1.0)


def test_forces_of_the_sticks_stay_as_they_are() -> None:
    setpoint = WrenchSetpoint(Wrench(3.0, 0.0, 1.0))
    assert Crew().steer(setpoint, sailing(0.0)) is setpoint


def test_a_lost_wind_vane_is_said_and_the_last_wind_counts_for_a_while() -> None:
    crew = Crew(SAIL_WIND_T=10.0)
    crew.steer(to(0.0), sailing(45.0))
    assert crew.heading_deg(to(0.0), sailing(45.0, wind_mps=None), 90) == pytest.approx(45.0, abs=2.0)
    assert crew.texts[-1] == "Wind vane lost: sails by the last wind, 10 s"
    assert isinstance(crew.steer(to(0.0), sailing(45.0, wind_mps=None), 20), NeutralSetpoint)
    assert crew.texts[-1] == "No wind known: sheet free, drifting"
    assert crew.kinds[-1] is TextKind.ALARM
    assert crew.heading_deg(to(0.0), sailing(45.0)) == pytest.approx(45.0, abs=2.0)
    assert "Wind vane: back" in crew.texts


def test_without_any_wind_yet_it_drifts() -> None:
    assert isinstance(Crew().steer(to(0.0), sailing(45.0, wind_mps=None)), NeutralSetpoint)


def test_light_wind_is_said_once_and_so_is_its_end() -> None:
    crew = Crew()
    crew.steer(to(90.0), sailing(90.0, wind_mps=0.6), 300)
    assert crew.texts == ["No wind: 0.6 m/s"]
    crew.steer(to(90.0), sailing(90.0, wind_mps=2.0), 300)
    assert len(crew.texts) == 2 and crew.texts[1].startswith("Wind again")


# --- motors beside the sail ----------------------------------------------------------------------------------------

FOR_MOTOR = parse(with_motor(), "boat.toml")


def test_by_motor_it_goes_straight_against_the_wind() -> None:
    crew = Crew(boat=FOR_MOTOR, SAIL_MOTOR=2)
    assert crew.heading_deg(to(0.0), sailing(0.0), times=5) == pytest.approx(0.0, abs=1.0)
    assert not crew.sailor.beats
    assert crew.sailor.rig[1:] == (False, True)
    assert crew.texts == ["By motor, sheet free"]
    crew.store.set("SAIL_MOTOR", 1)
    crew.steer(to(0.0), sailing(45.0))
    assert crew.sailor.beats
    assert crew.sailor.rig[1:] == (True, False)
    assert "Under sail" in crew.texts


def test_without_wind_the_motor_helps_unless_it_never_may() -> None:
    for use, drives in ((1, True), (0, False)):
        crew = Crew(boat=FOR_MOTOR, SAIL_MOTOR=use)
        crew.steer(to(0.0), sailing(0.0, wind_mps=0.3), times=90)
        assert not crew.sailor.rig.motors
        crew.steer(to(0.0), sailing(0.0, wind_mps=0.3), times=30)
        assert crew.sailor.rig.motors is drives
        assert ("By motor: no wind" in crew.texts) is drives


def test_a_boat_whose_vane_has_failed_goes_on_by_motor() -> None:
    crew = Crew(boat=FOR_MOTOR, SAIL_WIND_T=5.0)
    crew.steer(to(90.0), sailing(90.0))
    found = crew.steer(to(90.0), sailing(90.0, wind_mps=None), times=60)
    assert isinstance(found, HeadingSetpoint)
    assert found.wrench.surge_n > 0.0
    assert crew.sailor.rig.motors


def test_a_boat_without_a_motor_ignores_the_parameter() -> None:
    crew = Crew(SAIL_MOTOR=2)
    crew.steer(to(0.0), sailing(45.0), times=5)
    assert crew.sailor.beats
    assert not crew.sailor.has_motor


def test_the_stick_is_the_sheet_or_the_motor() -> None:
    sticks = ThrusterSetpoint((ThrusterCommand(4.0, 0.7, 0.2), ThrusterCommand(3.0, 0.7, None)))

    def throttles(**parameters: float) -> list[float]:
        found = Crew(boat=FOR_MOTOR, **parameters).steer(sticks, sailing(90.0))
        assert isinstance(found, ThrusterSetpoint)
        assert found.thrusters[0].azimuth_rad == 0.2
        return [command.throttle for command in found.thrusters]

    assert throttles() == [0.7, 0.0]
    assert throttles(SAIL_MOTOR=2) == [0.0, 0.7]
