"""Dispatch, feed-forward, gains, bias and wind of the controller."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.baselines.controller_choice import controller_with_baselines
from companion.cli.new_file import file_text
from companion.config.vessel import LimitsConfig, parse
from companion.control.bias import BiasForce
from companion.control.controller import Controller
from companion.control.dynamic_positioning import pole_placement
from companion.control.model import force_for
from companion.control.wind import wind_force
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import NavState, WaveMotion
from companion.core.frames import ned_to_body
from companion.core.setpoint import (
    NEUTRAL_SETPOINT,
    PATH_STEP_S,
    HeadingSetpoint,
    PathSetpoint,
    PlannedPose,
    PoseSetpoint,
    ThrusterSetpoint,
    WrenchSetpoint,
)
from companion.params.store import Parameters
from tests.unit.control.simple_boat import REVOLT, nav_state
from tests.unit.rudder_boat import ANSWERS

DT_S = 0.1
HERE = PoseSetpoint(0.0, 0.0, 0.0)


def controller(**values: float) -> Controller:
    parameters = Parameters(REVOLT.parameters)
    for name, value in values.items():
        assert parameters.set(name, value) is None
    return controller_with_baselines(REVOLT, parameters)


def axes(wrench: Wrench) -> tuple[float, float, float]:
    return wrench.surge_n, wrench.sway_n, wrench.yaw_nm


def test_at_the_reference_the_demand_is_zero() -> None:
    assert axes(controller().update(HERE, nav_state(), ZERO_WRENCH, DT_S)) == pytest.approx((0.0, 0.0, 0.0))


def test_errors_pull_back_by_the_placed_gains_in_body_axes() -> None:
    c = controller(DP_INTEGRAL=0.0)
    hull = REVOLT.hull
    wrench = c.update(HERE, nav_state(north_m=0.1), ZERO_WRENCH, DT_S)
    bandwidth = Parameters(REVOLT.parameters)
    surge, sway = bandwidth["DP_BW_SURGE"], bandwidth["DP_BW_SWAY"]
    assert axes(wrench) == pytest.approx((-0.1 * hull.m11_kg * surge**2, 0.0, 0.0), rel=1e-6)
    c = controller(DP_INTEGRAL=0.0)
    east = PoseSetpoint(0.0, 0.0, math.pi / 2.0)
    wrench = c.update(east, nav_state(north_m=0.1, yaw_rad=math.pi / 2.0), ZERO_WRENCH, DT_S)
    assert axes(wrench) == pytest.approx((0.0, 0.1 * hull.m22_kg * sway**2, 0.0), rel=1e-6, abs=1e-9)


def test_far_off_the_demand_points_to_the_point() -> None:
    """Cut on each axis by itself it pointed ahead: a boat 10 m off to the side sailed 9 m past its point."""
    yaw_rad = math.radians(-23.0)
    c = controller(DP_INTEGRAL=0.0)
    wrench = c.update(replace(HERE, yaw_rad=yaw_rad), nav_state(1.7, 9.8, yaw_rad), ZERO_WRENCH, DT_S)
    x, y = ned_to_body(-1.7, -9.8, yaw_rad)
    of = Parameters(REVOLT.parameters)
    gain = (REVOLT.hull.m11_kg * of["DP_BW_SURGE"] ** 2) / (REVOLT.hull.m22_kg * of["DP_BW_SWAY"] ** 2)
    assert wrench.sway_n == pytest.approx(-REVOLT.limits.sway_n, rel=1e-3)
    assert wrench.surge_n / wrench.sway_n == pytest.approx(gain * x / y, rel=1e-3)


def test_positioning_leaves_waves_alone_and_answers_what_remains() -> None:
    waves = WaveMotion(3.0, 0.08, -0.03, 0.01, 0.2, -0.1, 0.02)
    surge, sway = ned_to_body(0.2, -0.1, 0.01)
    moved = replace(nav_state(0.08, -0.03, 0.01, surge, sway, 0.02), waves=waves)
    assert axes(controller().update(HERE, moved, ZERO_WRENCH, DT_S)) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    still = axes(controller().update(HERE, nav_state(north_m=0.1), ZERO_WRENCH, DT_S))
    off = replace(moved, north_m=0.18)
    assert axes(controller().update(HERE, off, ZERO_WRENCH, DT_S)) == pytest.approx(still)


def test_yaw_error_is_wrapped() -> None:
    c = controller(DP_INTEGRAL=0.0)
    wrench = c.update(
        PoseSetpoint(0.0, 0.0, math.radians(179.0)),
        nav_state(yaw_rad=math.radians(-179.0)),
        ZERO_WRENCH,
        DT_S,
    )
    assert wrench.yaw_nm == pytest.approx(
        -math.radians(2.0) * REVOLT.hull.m33_kgm2 * Parameters(REVOLT.parameters)["DP_BW_YAW"] ** 2, rel=1e-5
    )


def test_gains_place_the_poles() -> None:
    kp, ki, kd = pole_placement(300.0, 20.0, 0.4, 0.9, 0.1)
    assert kp / 300.0 == pytest.approx(0.4**2)
    assert (kd + 20.0) / 300.0 == pytest.approx(2.0 * 0.9 * 0.4)
    assert ki == pytest.approx(0.1 * 0.4 * kp)
    assert pole_placement(300.0, 1.0e4, 0.4, 0.9, 0.1)[2] == pytest.approx(0.25 * 2.0 * 0.9 * 0.4 * 300.0)


def test_feed_forward_alone_moves_a_perfect_model() -> None:
    setpoint = PoseSetpoint(0.0, 0.0, 0.0, 0.3, 0.05, 0.02, 0.05, 0.01, 0.005)
    wrench = controller().update(
        setpoint, nav_state(surge_mps=0.3, sway_mps=0.05, yaw_rate_radps=0.02), ZERO_WRENCH, DT_S
    )
    assert axes(wrench) == pytest.approx(axes(force_for(REVOLT.hull, 0.3, 0.05, 0.02, 0.05, 0.01, 0.005)))
    nothing = controller(DP_FEEDFORWARD=0.0).update(
        setpoint, nav_state(surge_mps=0.3, sway_mps=0.05, yaw_rate_radps=0.02), ZERO_WRENCH, DT_S
    )
    assert axes(nothing) == pytest.approx((0.0, 0.0, 0.0))


def test_the_demand_never_exceeds_the_limits() -> None:
    wrench = controller().update(HERE, nav_state(north_m=-50.0, east_m=50.0, yaw_rad=3.0), ZERO_WRENCH, DT_S)
    limits = REVOLT.limits
    assert axes(wrench) == (-limits.surge_n, limits.sway_n, -limits.yaw_nm)


def test_rudders_beside_other_thrusters_are_asked_for_more_by_speed_through_the_water() -> None:
    boat = parse(file_text(replace(ANSWERS, layout="two-rudders", spread_m=0.3)), "boat.toml")
    control, asked = Controller(boat, Parameters(boat.parameters)), WrenchSetpoint(Wrench(20.0, 0.0, 1.0e3))
    still, under_way = nav_state(surge_mps=0.0), nav_state(surge_mps=2.0)
    carried = replace(under_way, current_north_mps=2.0, current_east_mps=0.0)

    def moment_nm(nav: NavState) -> float:
        return control.update(asked, nav, ZERO_WRENCH, 0.1).yaw_nm

    assert moment_nm(under_way) > 2.0 * moment_nm(still)
    assert moment_nm(carried) == moment_nm(still)


def test_under_way_a_thruster_in_the_bow_turns_the_boat_before_it_pushes_it_aside() -> None:
    boat = parse(file_text(replace(ANSWERS, layout="twin-bow", spread_m=0.3)), "boat.toml")
    control, off = Controller(boat, Parameters(boat.parameters)), nav_state(yaw_rad=-2.0)
    under_way_nm = control.update(PathSetpoint(1.0, 0.0, 0.0, 0.0, 0.0), off, ZERO_WRENCH, 0.1).yaw_nm
    held_nm = control.update(HERE, off, ZERO_WRENCH, 0.1).yaw_nm
    assert held_nm == boat.limits.yaw_nm
    assert under_way_nm > 1.2 * boat.limits.yaw_nm


def test_known_wind_is_countered() -> None:
    nav = nav_state(wind=(3.0, math.pi / 2.0))
    wrench = controller().update(HERE, nav, ZERO_WRENCH, DT_S)
    beam = 0.8 * 0.5 * 1.225 * 0.9 * 1.2 * 9.0
    assert axes(wrench) == pytest.approx((0.0, beam, 0.0), abs=1e-9)
    assert wind_force(REVOLT.windage, 3.0, nav_state()) == (0.0, 0.0, 0.0)
    x, y, n = wind_force(REVOLT.windage, 3.0, nav_state(wind=(3.0, math.radians(45.0))))
    assert x < 0.0 and y < 0.0 and n < 0.0, "from the starboard bow: pushed astern and to port, bow falls off to port"


def test_under_way_short_gusts_are_left_to_the_loops() -> None:
    """Thrust follows the wind within PATH_GUST_T, in the boat's axes of the moment; in Hold it answers at once."""
    ahead = PathSetpoint(0.0)
    quick, slow = controller(PATH_GUST_T=0.0), controller(PATH_GUST_T=3.0)
    for law in (quick, slow):
        law.update(ahead, nav_state(wind=(3.0, 0.0)), ZERO_WRENCH, DT_S)
    gust = nav_state(wind=(4.0, 0.0))
    at_once, first = (law.update(ahead, gust, ZERO_WRENCH, DT_S).surge_n for law in (quick, slow))
    before = controller().update(ahead, nav_state(wind=(3.0, 0.0)), ZERO_WRENCH, DT_S).surge_n
    assert at_once == pytest.approx(before * 16.0 / 9.0)
    assert before < first < before + 0.1 * (at_once - before)
    for _ in range(150):
        last = slow.update(ahead, gust, ZERO_WRENCH, DT_S).surge_n
    assert last == pytest.approx(at_once, rel=0.01)
    turned = slow.update(ahead, nav_state(yaw_rad=math.pi / 2.0, wind=(4.0, 0.0)), ZERO_WRENCH, DT_S)
    assert abs(turned.surge_n) < 0.05 * at_once


def test_the_bias_stays_fixed_in_ned_while_the_boat_turns() -> None:
    bias = BiasForce(REVOLT.limits)
    bias.grow(10.0, 0.0, 0.0, 0.0, 1.0)
    assert bias.in_body(math.pi / 2.0) == pytest.approx((0.0, -10.0, 0.0), abs=1e-12)


def test_without_sideways_thrust_the_bias_turns_with_the_boat_unless_it_keeps_a_place() -> None:
    """A catamaran that turned its bow into 10 m/s of wind then pushed with it, and was carried 10 m, over a fence."""
    bias = BiasForce(LimitsConfig(50.0, 0.0, 32.0))
    for keeps, ahead_again_n in ((True, -30.0), (False, 30.0)):
        bias.reset()
        bias.keeps_across = keeps
        bias.grow(30.0, 0.0, 0.0, 0.0, 1.0)
        for degrees in range(181):
            bias.grow(0.0, 0.0, 0.0, math.radians(degrees), 0.1)
        assert bias.in_body(math.pi)[0] == pytest.approx(ahead_again_n, rel=0.05)


@pytest.mark.parametrize(("off_rad", "left_to_waves"), [(0.1, True), (0.6, False)])
def test_a_boat_that_keeps_a_place_leaves_the_waves_alone_unless_it_turns(off_rad: float, left_to_waves: bool) -> None:
    waves = WaveMotion(3.0, 0.08, 0.0, 0.0, 0.3, 0.0, 0.1)
    moved = replace(nav_state(), north_mps=0.3, surge_mps=0.3, yaw_rate_radps=0.1, waves=waves)
    for keeps in (True, False):
        setpoint = PathSetpoint(off_rad, keeps_place=keeps)
        got, still = (controller().update(setpoint, nav, ZERO_WRENCH, DT_S) for nav in (moved, nav_state()))
        same = axes(got) == pytest.approx(axes(still), abs=1e-6)
        assert same == (keeps and left_to_waves)


def test_the_bias_is_bounded_and_gives_back_what_falls_short() -> None:
    bias = BiasForce(LimitsConfig(50.0, 20.0, 32.0))
    for _ in range(1000):
        bias.grow(100.0, 100.0, 100.0, 0.0, 0.1)
    assert bias.in_body(0.0) == pytest.approx((45.0, 18.0, 28.8))
    for _ in range(1000):
        bias.unwind(Wrench(60.0, 30.0, 40.0), Wrench(30.0, 10.0, 10.0), 0.0, 0.1)
    assert bias.in_body(0.0) == pytest.approx((0.0, 0.0, 0.0)), "back to nothing, and not past it"


def test_integration_stops_while_the_thrusters_fall_short() -> None:
    c = controller(DP_SMOOTH_T=0.0)
    off = nav_state(east_m=-1.5)
    for _ in range(600):
        demanded = c.update(HERE, off, Wrench(0.0, 8.0, 0.0), DT_S)
    assert demanded.sway_n == pytest.approx(REVOLT.limits.sway_n)
    back = c.update(HERE, nav_state(), Wrench(0.0, 8.0, 0.0), DT_S)
    assert back.sway_n < 6.0, "hardly any bias was built up in a minute"


def test_the_bias_learns_little_while_the_reference_moves() -> None:
    """ÅBOAT fell behind as it entered Hold in wind and current, and was carried 0.45 m past its point by what it learnt
    from that."""

    def learnt_n(setpoint: PoseSetpoint) -> float:
        c = controller(DP_SMOOTH_T=0.0, DP_FEEDFORWARD=0.0)
        wrench = [c.update(setpoint, nav_state(north_m=-0.2, surge_mps=setpoint.surge_mps), ZERO_WRENCH, DT_S)]
        for _ in range(20):
            demanded = wrench[-1]
            wrench.append(c.update(setpoint, nav_state(north_m=-0.2, surge_mps=setpoint.surge_mps), demanded, DT_S))
        return wrench[-1].surge_n - wrench[0].surge_n

    speed = Parameters(REVOLT.parameters)["DP_SPEED_AHEAD"]
    moving = PoseSetpoint(0.0, 0.0, 0.0, surge_mps=speed)
    assert 0.0 < learnt_n(moving) < 0.2 * learnt_n(HERE)


def test_neutral_and_wrench_setpoints() -> None:
    c = controller()
    nav = nav_state()
    assert c.update(WrenchSetpoint(wrench=Wrench(100.0, -5.0, 3.0)), nav, ZERO_WRENCH, DT_S) == Wrench(50.0, -5.0, 3.0)
    assert c.update(WrenchSetpoint(wrench=Wrench(math.nan, 0.0, 0.0)), nav, ZERO_WRENCH, DT_S) == ZERO_WRENCH
    assert c.update(ThrusterSetpoint(()), nav, ZERO_WRENCH, DT_S) == ZERO_WRENCH
    assert c.update(NEUTRAL_SETPOINT, nav, ZERO_WRENCH, DT_S) == ZERO_WRENCH


def test_heading_keeps_the_sticks_forces_and_steers() -> None:
    setpoint = HeadingSetpoint(yaw_rad=0.3, wrench=Wrench(12.0, -3.0, 0.0))
    wrench = controller().update(setpoint, nav_state(), ZERO_WRENCH, DT_S)
    assert wrench.surge_n == 12.0 and wrench.sway_n == -3.0 and wrench.yaw_nm > 5.0


def test_a_path_setpoint_brings_speed_and_heading_up() -> None:
    setpoint = PathSetpoint(yaw_rad=0.1, surge_mps=0.5)
    wrench = controller().update(setpoint, nav_state(), ZERO_WRENCH, DT_S)
    assert wrench.surge_n == pytest.approx(50.0) and wrench.yaw_nm > 0.0
    steady = controller().update(PathSetpoint(yaw_rad=0.0, surge_mps=0.5), nav_state(surge_mps=0.5), ZERO_WRENCH, DT_S)
    assert axes(steady) == pytest.approx((50.66 * 0.5, 0.0, 0.0), abs=1e-6)


def test_the_bias_survives_a_change_of_law_and_neutral_resets_it() -> None:
    c = controller(DP_BW_SURGE=0.35, DP_INTEGRAL=0.12)
    for _ in range(300):
        held = c.update(HERE, nav_state(north_m=-0.1), Wrench(6.0, 0.0, 0.0), DT_S)
    learnt = held.surge_n - 0.1 * REVOLT.hull.m11_kg * 0.35**2
    assert learnt > 2.0
    sailing = c.update(PathSetpoint(yaw_rad=0.0), nav_state(), held, DT_S)
    assert sailing.surge_n == pytest.approx(learnt, rel=0.02)
    c.update(NEUTRAL_SETPOINT, nav_state(), ZERO_WRENCH, DT_S)
    assert axes(c.update(HERE, nav_state(), ZERO_WRENCH, DT_S)) == pytest.approx((0.0, 0.0, 0.0))


def test_a_non_finite_input_gives_no_thrust_and_leaves_nothing_behind() -> None:
    c = controller()
    assert c.update(HERE, nav_state(north_m=math.nan), ZERO_WRENCH, DT_S) == ZERO_WRENCH
    assert axes(c.update(HERE, nav_state(), ZERO_WRENCH, DT_S)) == pytest.approx((0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    "setpoint",
    [PoseSetpoint(1.0, 0.0, 0.1), PathSetpoint(0.1, 1.0), PathSetpoint(0.1, 1.0, exact=True)],
    ids=["pose", "path", "planned"],
)
@pytest.mark.parametrize(
    "bad",
    [nav_state(surge_mps=math.nan), nav_state(yaw_rad=math.nan), nav_state(wind=(math.nan, 0.5))],
    ids=["speed", "heading", "wind"],
)
def test_after_a_non_finite_state_every_law_begins_anew(setpoint: PoseSetpoint | PathSetpoint, bad: NavState) -> None:
    good = nav_state(wind=(3.0, 0.5))
    fresh = axes(controller().update(setpoint, good, ZERO_WRENCH, DT_S))
    c = controller()
    c.update(setpoint, good, ZERO_WRENCH, DT_S)
    assert c.update(setpoint, bad, ZERO_WRENCH, DT_S) == ZERO_WRENCH
    assert axes(c.update(setpoint, good, ZERO_WRENCH, DT_S)) == pytest.approx(fresh)


def poses(rate_radps: float) -> tuple[PlannedPose, ...]:
    """A circle at 1 m/s, north at first."""
    found, north_m, east_m = [], 0.0, 0.0
    for k in range(12):
        yaw_rad = rate_radps * k * PATH_STEP_S
        found.append(PlannedPose(north_m, east_m, yaw_rad))
        north_m, east_m = north_m + PATH_STEP_S * math.cos(yaw_rad), east_m + PATH_STEP_S * math.sin(yaw_rad)
    return tuple(found)


def test_the_demands_ahead_are_those_of_the_planned_poses() -> None:
    c = controller()
    under_way = nav_state(surge_mps=1.0)
    straight = PathSetpoint(0.0, 1.0, exact=True, ahead=poses(0.0))
    wrench = c.update(straight, under_way, ZERO_WRENCH, DT_S)
    assert len(c.ahead) == 9
    for later in c.ahead:
        assert axes(later) == pytest.approx(axes(wrench), abs=1.0e-6)
    c.update(replace(straight, ahead=()), under_way, ZERO_WRENCH, DT_S)
    assert c.ahead == ()


def test_poses_that_are_not_finite_demand_nothing() -> None:
    c = controller()
    broken = (*poses(0.0)[:6], PlannedPose(math.nan, 0.0, 0.0), *poses(0.0)[7:])
    c.update(PathSetpoint(0.0, 1.0, exact=True, ahead=broken), nav_state(surge_mps=1.0), ZERO_WRENCH, DT_S)
    assert c.ahead == ()


def test_in_a_bend_ahead_the_wind_comes_from_another_side_of_the_boat() -> None:
    """Wind from north, against a boat that will have turned east: its force moves from the bow to the port side."""
    windy = nav_state(surge_mps=1.0, wind=(5.0, 0.0))
    quiet = nav_state(surge_mps=1.0)
    bend = PathSetpoint(0.0, 1.0, exact=True, ahead=poses(0.5 * math.pi / (10 * PATH_STEP_S)))
    more = []
    for nav in (windy, quiet):
        c = controller()
        now = c.update(bend, nav, ZERO_WRENCH, DT_S)
        more.append((c.ahead[-1].surge_n - now.surge_n, c.ahead[-1].sway_n - now.sway_n))
    assert more[0][0] < more[1][0] - 0.5, "less thrust ahead is needed"
    assert more[0][1] < more[1][1] - 0.5, "and more to port"
