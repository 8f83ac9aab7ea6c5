"""The law on a boat that knows where it is: gaps, follow positions, the keep-out circle, a leader that stops or goes
astern."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.cli.new_file import file_text
from companion.config.reversing import can_reverse
from companion.config.vessel import VesselConfig, find, load, parse
from companion.core.angles import wrap_pi
from companion.core.setpoint import PathSetpoint, WrenchSetpoint
from companion.following.clearance import Clearance
from companion.following.law import FollowLaw
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST
from tests.unit.following.leaders import DT_S, Carried, Jet, Lead, Twin, TwinScrew, leader_at
from tests.unit.guidance.test_long_hulls import LAUNCH
from tests.unit.rudder_boat import ANSWERS

JET = load(find("rescuerunner"))
TWIN = load(find("blueboat"))  # turns in place
ASTERN = (20.0, math.pi)
LEAST_M = 12.0


class Chase:
    """`sail(duration, speed, turn, follow_position)`. Remembers the least distance, and the law's last motion and
    setpoint."""

    def __init__(self, boat: Jet, lead: Lead, config: VesselConfig = JET, **parameters: float) -> None:
        self.boat, self.lead = boat, lead
        reverses = can_reverse(config.thrusters)
        self.law = FollowLaw(config, Parameters({**config.parameters, **parameters}), reverses)
        self.now_s = 0.0
        self.least_m = math.inf
        self.turned_rad = 0.0
        self.started = False

    def sail(
        self,
        duration_s: float,
        speed_mps: float,
        turn_radps: float = 0.0,
        follow_position: tuple[float, float] = ASTERN,
    ) -> None:
        for _ in range(round(duration_s / DT_S)):
            self.now_s += DT_S
            leader = self.lead.step(speed_mps, turn_radps)
            if not self.started:
                self.law.start(self.boat.nav, leader, follow_position, self.now_s)
                self.started = True
            self.motion = self.law.update(self.boat.nav, leader, follow_position, self.now_s)
            self.setpoint = self.law.setpoint(self.motion, self.boat.nav, DT_S)
            nav = self.boat.step(self.setpoint)
            self.turned_rad += nav.yaw_rate_radps * DT_S
            self.least_m = min(self.least_m, self.distance_m)

    @property
    def distance_m(self) -> float:
        return math.hypot(self.boat.nav.north_m - self.lead.north_m, self.boat.nav.east_m - self.lead.east_m)


def astern_of(lead: Lead, distance_m: float = 20.0, **parameters: float) -> Chase:
    return Chase(Jet(JET, lead.north_m - distance_m, lead.east_m), lead, **parameters)


def test_gap_and_track_through_a_sharp_turn() -> None:
    """This hull does not slip in a turn, which the law counts on."""
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(25.0, 8.2)
    assert chase.motion.off_m == pytest.approx(0.0, abs=0.7)
    for turn in (0.26, 0.0, -0.26):
        for _ in range(60):
            chase.sail(DT_S, 8.2, turn)
            assert (
                chase.motion.cross_m is not None and abs(chase.motion.cross_m) < 2.5 and abs(chase.motion.off_m) < 2.0
            )


def test_a_boat_that_steers_late_looks_further_along_the_track() -> None:
    """So it begins a bend sooner: of two boats at one place of it, that one asks for the course further round."""
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(20.0, 8.2)
    chase.sail(3.0, 8.2, 0.26)
    nav, leader = chase.boat.nav, chase.lead.step(8.2, 0.26)
    usual = chase.law.update(nav, leader, ASTERN, chase.now_s)
    late = chase.law.update(nav, leader, ASTERN, chase.now_s, steers_late_s=1.2)
    assert late.course_rad > usual.course_rad + 0.02


def test_a_hull_that_its_rudder_turns_late_begins_a_bend_before_the_leaders_track_does() -> None:
    """A launch began each bend 3 m too late, and came out of it 3 to 9 m off the track. With a keep-out circle that the
    leader, so near, is clear of."""
    asked, boat = [], replace(AT_REST, north_m=27.0, surge_mps=1.5, north_mps=1.5)
    for damping in (LAUNCH.hull.damping, replace(LAUNCH.hull.damping, y_v=1e6)):  # the second slides nowhere
        parameters = Parameters({**LAUNCH.parameters, "FOLL_MIN_DIST": 2.0})
        law = FollowLaw(replace(LAUNCH, hull=replace(LAUNCH.hull, damping=damping)), parameters, True)
        lead, now_s = Lead(20.0, 0.0), 0.0
        law.start(boat, lead.step(1.5), ASTERN, now_s)
        while lead.course_rad < 1.5:
            now_s += DT_S
            motion = law.update(boat, lead.step(1.5, 0.2 if lead.north_m > 30.0 else 0.0), ASTERN, now_s)
        assert not motion.evading
        asked.append(motion.course_rad)
    assert asked[0] > asked[1] + 0.1


def test_a_boat_that_its_rudder_turns_comes_back_to_the_track_without_crossing_it() -> None:
    leans = []
    outboard = replace(LAUNCH, thrusters=tuple(replace(t, kind="azimuth", rudder=None) for t in LAUNCH.thrusters))
    for config in (LAUNCH, outboard):
        law = FollowLaw(config, Parameters(LAUNCH.parameters), True)
        boat = replace(AT_REST, east_m=5.0, surge_mps=2.2, north_mps=2.2)
        leader = leader_at(25.0, speed_mps=2.2)
        law.start(boat, leader, ASTERN, 0.0)
        leans.append(-law.update(boat, leader, ASTERN, 0.1).course_rad)
        look_m = law.lookahead_m
    assert leans[1] == pytest.approx(math.atan(5.0 / look_m), abs=0.01)
    assert leans[0] < leans[1] - 0.05


def test_a_fast_leader_is_closed_up_with_to_the_gap() -> None:
    """The look-ahead took both boats at different moments, half a second apart, and held the boat 20 m too far off."""
    chase = astern_of(Lead(0.0, 0.0), 45.0)
    for _ in range(600):
        chase.sail(DT_S, 14.0)
        assert not chase.motion.evading
    assert chase.motion.off_m == pytest.approx(0.0, abs=0.7)


def test_a_boat_that_brakes_counts_on_the_way_that_the_leader_goes_on_while_it_closes_up() -> None:
    """From 25 m behind its place ÅBOAT took 52 s, as if that place stood still: behind a leader of 1 m/s 43 s do."""
    aboat = load(find("aboat"))
    chase = Chase(Twin(aboat, -45.0, 0.0), Lead(0.0, 0.0), aboat)
    chase.sail(46.0, 1.0)
    assert chase.motion.off_m < 3.0
    chase.sail(30.0, 1.0)
    assert chase.motion.off_m == pytest.approx(0.0, abs=1.0) and chase.least_m > 19.0


def test_a_boat_far_behind_a_slow_leader_does_not_make_room_for_it_in_a_sharp_bend() -> None:
    """At 45 m it stood still for 12 s, and fell 19 m behind: the leader was nearer than 0.85 times that."""
    otter = load(find("otter"))
    far = (45.0, math.pi)
    chase = Chase(Twin(otter, -45.0, 0.0), Lead(0.0, 0.0), otter)
    chase.sail(30.0, 1.5, follow_position=far)
    for turn, duration_s in ((0.26, 6.0), (0.0, 24.0)):
        for _ in range(round(duration_s / DT_S)):
            chase.sail(DT_S, 1.5, turn, far)
            assert not chase.motion.evading and abs(chase.motion.off_m) < 3.0


def test_leader_stops_and_the_boat_beside_it_without_circling() -> None:
    for speed, gap in ((8.2, 20.0), (4.0, 20.0), (8.2, 45.0)):
        chase = astern_of(Lead(0.0, 0.0), gap)
        chase.sail(25.0, speed, follow_position=(gap, math.pi))
        turned = chase.turned_rad
        chase.sail(50.0, 0.0, follow_position=(gap, math.pi))
        assert chase.least_m > LEAST_M + 2.0
        assert 0.7 * gap < chase.distance_m < 1.4 * gap and chase.boat.nav.surge_mps < 0.3
        assert abs(chase.turned_rad - turned) < 1.2 * math.pi
        assert isinstance(chase.setpoint, WrenchSetpoint) and chase.motion.resting


def test_drifted_off_beside_a_leader_that_stands_it_comes_back_on_its_own_side() -> None:
    """A jet that wind had set ahead of its leader sailed back astern of it, past it at 4 m/s."""
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(25.0, 8.2)
    chase.sail(50.0, 0.0)
    assert chase.motion.resting
    chase.boat.nav = replace(chase.boat.nav, north_m=chase.lead.north_m + 35.0, east_m=chase.lead.east_m)
    chase.least_m = math.inf
    chase.sail(30.0, 0.0)
    assert chase.motion.resting and chase.boat.nav.north_m > chase.lead.north_m
    assert chase.least_m > 15.0


def test_a_boat_goes_slowly_round_a_leader_at_rest() -> None:
    """One with an outboard that wind had carried beside it came back round it at 3.8 m/s."""
    chase = Chase(Twin(TWIN, 14.0, 14.0), Lead(0.0, 0.0), TWIN)
    fastest_mps = 0.0
    for _ in range(round(45.0 / DT_S)):
        chase.sail(DT_S, 0.0, follow_position=(20.0, math.pi))
        fastest_mps = max(fastest_mps, chase.motion.speed_mps)
    assert 0.5 < fastest_mps < 1.21 and chase.motion.off_m < 5.0 and chase.least_m > LEAST_M


def test_after_something_else_has_steered_the_heading_asked_for_begins_at_the_boats() -> None:
    """It began at that of before the wait: a boat that had turned its bow into the stream turned the long way round."""
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(5.0, 8.2)
    turned = replace(chase.boat.nav, yaw_rad=math.radians(170.0))
    chase.law.let_go()
    setpoint = chase.law.setpoint(chase.motion, turned, DT_S)
    assert isinstance(setpoint, PathSetpoint) and abs(wrap_pi(setpoint.yaw_rad - turned.yaw_rad)) < 0.1


def test_leader_goes_astern_and_the_boat_makes_room() -> None:
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(25.0, 8.2)
    chase.sail(35.0, 0.0)
    chase.sail(25.0, -2.0)
    assert chase.least_m > LEAST_M
    chase.sail(20.0, 0.0)
    chase.sail(40.0, 5.0)
    assert chase.least_m > LEAST_M and chase.motion.off_m == pytest.approx(0.0, abs=1.5), "and it follows again"


def test_the_boat_seeks_no_follow_position_in_the_way_of_a_leader_that_backs() -> None:
    """It lay clear of the leader's way, and turned into it to be astern of it again."""
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(25.0, 8.2)
    chase.sail(35.0, 0.0)
    drifted = replace(
        chase.boat.nav, north_m=chase.lead.north_m - 16.0, east_m=chase.lead.east_m - 18.0, yaw_rad=math.radians(-121.0)
    )
    chase.boat.nav = drifted
    chase.sail(2.0, 0.0)
    chase.sail(22.0, -2.0)
    assert chase.boat.nav.east_m < drifted.east_m + 4.0, "it stays on its side"
    assert chase.least_m > LEAST_M + 2.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_boat_little_faster_than_the_leader_comes_round_it_from_abeam_to_ahead(side: float) -> None:
    """Its velocity, cut down to what it reaches, led into the keep-out circle: it stayed abeam for good."""
    chase = Chase(Twin(TWIN, 0.0, side * 25.0), Lead(0.0, 0.0), TWIN, MPC_XY_VEL_MAX=2.2)
    chase.sail(40.0, 1.5, follow_position=(25.0, side * math.pi / 2.0))
    assert chase.motion.off_m < 2.0
    chase.sail(75.0, 1.5, follow_position=(30.0, 0.0))
    assert chase.motion.off_m < 2.0 and chase.least_m > LEAST_M


@pytest.mark.parametrize("speed", [0.0, 3.0, 8.2])
def test_follow_positions_all_round_never_through_the_keep_out_circle(speed: float) -> None:
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(25.0, speed)
    for bearing_deg in (90.0, 0.0, 180.0, -90.0, 180.0, 0.0, 135.0):
        chase.sail(45.0, speed, follow_position=(20.0, math.radians(bearing_deg)))
        assert chase.least_m > LEAST_M, bearing_deg
        if speed > 5.0:
            assert chase.motion.off_m < 4.0, bearing_deg


@pytest.mark.parametrize("bearing_deg", [90.0, -90.0, 45.0, 0.0])
@pytest.mark.parametrize("turn", [0.26, -0.26])
def test_a_turning_leader_is_kept_clear_of(bearing_deg: float, turn: float) -> None:
    """Inside the turn the follow position crawls, outside it outruns the boat; either way the distance is kept, and the position
    is found again."""
    follow_position = (20.0, math.radians(bearing_deg))
    lead = Lead(0.0, 0.0)
    chase = Chase(Jet(JET, 20.0 * math.cos(follow_position[1]), 20.0 * math.sin(follow_position[1])), lead)
    chase.sail(30.0, 8.2, follow_position=follow_position)
    chase.sail(12.0, 8.2, turn, follow_position)
    assert chase.least_m > LEAST_M
    chase.sail(35.0, 8.2, follow_position=follow_position)
    assert chase.least_m > LEAST_M and chase.motion.off_m < 3.0


def test_a_turn_straight_back_is_followed_round() -> None:
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(25.0, 8.2)
    chase.sail(math.pi / 0.26, 8.2, 0.26)
    chase.sail(15.0, 8.2)
    assert chase.motion.cross_m == pytest.approx(0.0, abs=0.5) and chase.turned_rad == pytest.approx(
        chase.lead.course_rad % math.tau, abs=0.15
    )
    assert chase.least_m > 15.0


def test_a_boat_that_turns_in_place_is_not_predicted_with_the_way_that_a_jet_needs_to_turn() -> None:
    """By JET_STEER_N, which is of jets alone: 5 m/s, and more than the top speed of a launch with a rudder."""
    parameters = Parameters(TWIN.parameters)
    assert Clearance(TWIN, parameters, can_reverse=True).turning_mps == 0.0
    launch = Parameters(LAUNCH.parameters)
    assert 0.0 < Clearance(LAUNCH, launch, can_reverse=True).turning_mps < 0.6 * launch["MPC_XY_VEL_MAX"]
    jet = Parameters(JET.parameters)
    assert Clearance(JET, jet, can_reverse=False).turning_mps == pytest.approx(2.5, abs=0.1)


@pytest.mark.parametrize("off_deg", [0.0, 60.0, 100.0, 180.0])
def test_while_it_keeps_clear_a_boat_that_turns_in_place_makes_no_way_where_its_bow_points_meanwhile(
    off_deg: float,
) -> None:
    """It kept half of its speed ahead, whatever lay there."""
    law = FollowLaw(TWIN, Parameters(TWIN.parameters), can_reverse=True)
    leader = leader_at(19.0)
    law.start(AT_REST, leader, ASTERN, 0.0)
    motion = replace(law.update(AT_REST, leader, ASTERN, 0.1), speed_mps=1.0, evading=True, resting=False)
    setpoint = law.setpoint(replace(motion, course_rad=wrap_pi(math.radians(off_deg))), AT_REST, DT_S)
    assert isinstance(setpoint, PathSetpoint)
    assert setpoint.surge_mps == pytest.approx(math.cos(math.radians(off_deg)), abs=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_slow_leader_that_turns_back_past_the_boat_is_made_room_for(side: float) -> None:
    """In a circle that is narrower than the keep-out circle. The boat was taken to reach 5 m/s by turning, three times
    its top speed, and had no way astern to speak of."""
    lead = Lead(0.0, 0.0)
    chase = Chase(Twin(TWIN, -17.0, 0.0), lead, TWIN)
    chase.sail(30.0, 1.0, follow_position=(15.0, math.pi))
    chase.sail(math.pi / 0.26, 1.0, side * 0.26, follow_position=(15.0, math.pi))
    chase.sail(20.0, 1.0, follow_position=(15.0, math.pi))
    assert chase.least_m > LEAST_M + 1.0
    chase.sail(35.0, 1.0, follow_position=(15.0, math.pi))
    assert chase.motion.cross_m == pytest.approx(0.0, abs=1.5) and abs(chase.motion.off_m) < 2.0, "and follows it again"


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_ship_that_its_rudders_turn_ahead_gets_out_of_the_way_of_a_leader_that_turns_back(side: float) -> None:
    """Astern it turns slowly, and with all its thrust. It stood there and turned, and with a real ship came to 9 m."""
    answers = replace(
        ANSWERS, layout="two-rudders", length_m=10.0, beam_m=3.0, mass_kg=9000.0, motor="4000", spread_m=1.4
    )
    ship = parse(file_text(answers), "ship.toml")
    lead = Lead(0.0, 0.0)
    chase = Chase(TwinScrew(ship, -30.0, 0.0), lead, ship)
    astern = (30.0, math.pi)
    chase.sail(60.0, 1.3, follow_position=astern)
    chase.sail(math.pi / 0.26, 1.3, side * 0.26, follow_position=astern)
    chase.sail(40.0, 1.3, follow_position=astern)
    assert chase.least_m > LEAST_M + 1.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_jet_gets_out_of_the_way_of_a_slow_leader_while_that_still_turns_back(side: float) -> None:
    """It waited until the leader headed for it, and came nearer than it keeps: with a real jet, to 9 m of 12."""
    chase = astern_of(Lead(0.0, 0.0))
    chase.sail(15.0, 1.0)
    chase.sail(math.pi / 0.26, 1.0, side * 0.26)
    chase.sail(40.0, 1.0)
    assert chase.least_m > 15.5, "FOLL_MIN_DIST and FOLL_MARGIN"


@pytest.mark.parametrize("heading_deg", [0.0, 40.0])
def test_a_current_that_sets_the_boat_onto_a_leader_at_rest_is_allowed_for(heading_deg: float) -> None:
    """It was expected to carry the boat nowhere: an Otter that turned its bow into it came to 9.9 m of 12."""
    otter = load(find("otter"))
    chase = Chase(Carried(otter, -19.0, 0.0, math.radians(heading_deg)), Lead(0.0, 0.0), otter)
    chase.sail(90.0, 0.0)
    assert chase.least_m > LEAST_M


def test_a_boat_that_cannot_push_itself_sideways_lies_bow_to_its_drift() -> None:
    otter, jet = load(find("otter")), load(find("rescuerunner"))
    nav = replace(AT_REST, yaw_rad=1.0, current_north_mps=0.0, current_east_mps=0.6, current_accuracy_mps=0.1)
    lies = Clearance(otter, Parameters(otter.parameters), can_reverse=True)
    assert lies.lying_rad(nav) == pytest.approx(-0.5 * math.pi)
    assert lies.lying_rad(replace(nav, current_accuracy_mps=0.7)) == 1.0, "not surely known"
    assert lies.lying_rad(replace(nav, current_east_mps=0.1)) == 1.0, "too slow"
    assert Clearance(jet, Parameters(jet.parameters), can_reverse=False).lying_rad(nav) == 1.0


@pytest.mark.parametrize("place", [(-300.0, 0.0), (-150.0, 200.0), (250.0, 30.0), (20.0, -200.0)])
@pytest.mark.parametrize("speed", [0.0, 6.0])
def test_approach_from_300_m(place: tuple[float, float], speed: float) -> None:
    chase = Chase(Jet(JET, *place), Lead(0.0, 0.0))
    chase.sail(160.0, speed)
    assert chase.least_m > LEAST_M
    assert chase.motion.off_m < (2.0 if speed else 10.0) and chase.distance_m < 32.0


def test_no_nearer_than_the_keep_out_allows_whatever_follow_position_is_asked_for() -> None:
    chase = astern_of(Lead(0.0, 0.0), 30.0)
    chase.sail(40.0, 6.0, follow_position=(5.0, math.pi))
    assert chase.law.distance_m > 12.0 + 1.4 * 3.5 and chase.least_m > 15.0


def test_speed_is_capped() -> None:
    chase = Chase(Jet(JET, -200.0, 0.0), Lead(0.0, 0.0), FLW_TGT_MAX_VEL=7.0)
    chase.sail(20.0, 6.5)
    assert chase.setpoint.surge_mps <= 7.0 + 1e-9 and chase.boat.nav.surge_mps > 6.5


@pytest.mark.parametrize("speed", [1.0, 1.5, 2.0, 3.0])
def test_behind_a_slow_leader_that_stops_a_jet_keeps_out_of_the_circle_however_near_it_is_asked_to_be(
    speed: float,
) -> None:
    chase = astern_of(Lead(0.0, 0.0), 22.0)
    chase.sail(60.0, speed, follow_position=(15.0, math.pi))
    chase.sail(60.0, 0.0, follow_position=(15.0, math.pi))
    assert chase.least_m > LEAST_M
