"""Cross-flow drag by strips and lift, against closed forms, printed regressions and the stability they are made for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.config.hull import DampingConfig, HullConfig
from companion.config.hull_flow import CrossFlowConfig, LiftConfig
from companion.config.vessel import PlantConfig, VesselConfig, bundled, find, load
from sitl.hull import Hull, dynamics, with_flows
from sitl.hull_flow import flows, hull_of, lift, lift_slope, own_derivatives, regression, strips
from sitl.manoeuvres import course_roots
from sitl.otter_equations import OtterHull
from sitl.wave_hull import WaveHull, wave_hull

REVOLT, ABOAT, OTTER = (load(find(name)) for name in ("revolt", "aboat", "otter"))
BOAT = WaveHull(3.0, 0.72, 0.72, 0.23, 4.0, 400.0)
MODEL = HullConfig(263.93, 306.44, 322.15, 7.0, 7.03, mass_kg=257.0, draft_m=0.23)
speeds = st.floats(-2.0, 2.0)


def plant_of(vessel: VesselConfig, name: str) -> PlantConfig:
    assert vessel.sitl is not None
    return vessel.sitl.plants[name]


# --- strips ----------------------------------------------------------------------------------------------------------


def test_strips_across_and_in_a_turn_are_the_integrals() -> None:
    drag = strips(CrossFlowConfig(coefficient=0.8, length_m=4.0, draft_m=0.5, strips=100), BOAT)
    half = 0.5 * 1025.0 * 0.8 * 0.5
    sway, yaw = drag(9.9, 0.3, 0.0)
    assert sway == pytest.approx(-half * 4.0 * 0.3**2) and yaw == pytest.approx(0.0, abs=1e-9)
    sway, yaw = drag(0.0, 0.0, -0.2)
    assert yaw == pytest.approx(half * 4.0**4 / 32.0 * 0.2**2, rel=1e-3) and sway == pytest.approx(0.0, abs=1e-9)


def test_strips_take_dimensions_of_the_hull_and_count_hulls() -> None:
    one = strips(CrossFlowConfig(coefficient=1.0), BOAT)(0.0, 0.5, 0.1)
    same = strips(CrossFlowConfig(coefficient=1.0, length_m=3.0, draft_m=0.23), BOAT)(0.0, 0.5, 0.1)
    two = strips(CrossFlowConfig(coefficient=1.0, hulls=2), BOAT)(0.0, 0.5, 0.1)
    assert one == same and two == pytest.approx((2.0 * one[0], 2.0 * one[1]))


@given(speeds, speeds)
@settings(deadline=None, derandomize=True, max_examples=100)
def test_strips_only_take_energy(v: float, r: float) -> None:
    sway, yaw = strips(CrossFlowConfig(coefficient=1.0), BOAT)(0.0, v, r)
    assert sway * v + yaw * r <= 0.0


# --- lift ------------------------------------------------------------------------------------------------------------


def test_slope_of_lift_is_soedings() -> None:
    assert lift_slope(1.0) == pytest.approx(2.0 * math.pi * 1.7 / 2.7**2)
    assert lift_slope(1e6) == pytest.approx(2.0 * math.pi, rel=1e-5)


def test_clarke_as_printed() -> None:
    """With π(T/L)² = 0.018466, C_B = 0.50469, B/T = 3.13043, B/L = 0.24, T/L = 0.076667."""
    found = regression("clarke", MODEL, BOAT)
    scale = math.pi * (0.23 / 3.0) ** 2
    expected = (
        -scale * (1.0 + 0.40 * 0.504693 * 3.130435) * 0.5 * 1025.0 * 3.0**2,
        -scale * (-0.5 + 2.2 * 0.24 - 0.080 * 3.130435) * 0.5 * 1025.0 * 3.0**3,
        -scale * (0.5 + 2.4 * 0.0766667) * 0.5 * 1025.0 * 3.0**3,
        -scale * (0.25 + 0.039 * 3.130435 - 0.56 * 0.24) * 0.5 * 1025.0 * 3.0**4,
    )
    assert (found.y_v, found.y_r, found.n_v, found.n_r) == pytest.approx(expected, rel=1e-5)
    assert found.n_r == pytest.approx(-182.2, abs=0.1) and found.n_v == pytest.approx(-174.8, abs=0.1)


def test_inoue_as_printed() -> None:
    """With k = 2T/L = 0.153333. The force by yaw has the added mass in surge besides: 257 − 263.93 kg."""
    found, k, unit = regression("inoue", MODEL, BOAT), 0.46 / 3.0, 0.5 * 1025.0 * 3.0 * 0.23
    assert found.y_v == pytest.approx(-unit * (0.5 * math.pi * k + 1.4 * 0.504693 * 0.24), rel=1e-5)
    assert found.y_r == pytest.approx(unit * 3.0 * 0.25 * math.pi * k - 6.93, rel=1e-5)
    assert found.n_v == pytest.approx(-unit * 3.0 * k)
    assert found.n_r == pytest.approx(-unit * 9.0 * (0.54 * k - k * k))


def test_both_regressions_say_nearly_the_same_of_revolt() -> None:
    clarke, inoue = (regression(law, MODEL, BOAT) for law in ("clarke", "inoue"))
    assert inoue.y_v == pytest.approx(clarke.y_v, rel=0.1)
    assert inoue.n_v == pytest.approx(clarke.n_v, rel=0.1)
    assert inoue.n_r == pytest.approx(clarke.n_r, rel=0.1)


def test_a_catamaran_has_the_derivatives_of_two_hulls() -> None:
    twin, single = replace(BOAT, hulls=2), replace(MODEL, mass_kg=128.5)
    both, one = regression("clarke", MODEL, twin), regression("clarke", single, BOAT)
    assert (both.y_v, both.n_v) == pytest.approx((2.0 * one.y_v, 2.0 * one.n_v))


def test_the_plant_with_lift_has_the_derivatives_of_the_regression() -> None:
    """Forces of C(ν)ν and of the option together, as a difference of the equations of motion times inertia."""
    rate = with_flows(dynamics(MODEL), [lift(LiftConfig(law="clarke"), MODEL, BOAT)])
    inertia = np.array([[306.44, 7.0], [7.03, 322.15]])
    small, found = 1e-5, regression("clarke", MODEL, BOAT)
    by_v, by_r = (
        inertia @ (np.array(rate(1.0, *motion, 0.0, 0.0, 0.0)[1:]) / small) for motion in ((small, 0.0), (0.0, small))
    )
    assert by_v == pytest.approx([found.y_v, found.n_v], rel=1e-6)
    assert by_r == pytest.approx([found.y_r - 257.0, found.n_r], rel=1e-6)


def test_fins_at_the_stern_hold_the_bow_into_the_flow_ahead_and_not_astern() -> None:
    bare = lift(LiftConfig(law="clarke"), MODEL, BOAT)
    finned = lift(LiftConfig(law="clarke", fin_area_m2=0.02, fin_x_m=-1.0), MODEL, BOAT)
    ahead = finned(1.0, 0.1, 0.0)[1] - bare(1.0, 0.1, 0.0)[1]
    astern = finned(-1.0, 0.1, 0.0)[1] - bare(-1.0, 0.1, 0.0)[1]
    assert ahead == pytest.approx(0.5 * 1025.0 * 0.02 * lift_slope(2.0) * 0.1) and astern == ahead > 0.0
    turn = finned(1.0, 0.0, 0.1)[1] - bare(1.0, 0.0, 0.1)[1]
    assert turn < 0.0


def test_lift_is_gone_at_rest_and_changes_over_astern_as_a_hull_of_equal_ends_does() -> None:
    force = lift(LiftConfig(law="clarke"), MODEL, BOAT)
    assert force(0.0, 0.3, 0.2) == (0.0, 0.0)
    ahead, astern = force(0.8, 0.3, 0.2), force(-0.8, 0.3, -0.2)
    assert astern == pytest.approx((ahead[0], -ahead[1]))


# --- boats -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vessel", "usual", "speed_mps"), [(REVOLT, "as_sailed", 0.9), (ABOAT, "as_rigged", 1.2)], ids=["revolt", "aboat"]
)
def test_lift_makes_the_hull_stable_on_its_course(vessel: VesselConfig, usual: str, speed_mps: float) -> None:
    assert course_roots(vessel, plant_of(vessel, usual), speed_mps)[0].real > 0.25
    slender = plant_of(vessel, "slender")
    for law in ("clarke", "inoue"):
        assert slender.lift is not None
        other = replace(slender, lift=replace(slender.lift, law=law))
        assert -0.4 < course_roots(vessel, other, speed_mps)[0].real < -0.05
    without = replace(slender, lift=None)
    assert course_roots(vessel, without, speed_mps) == pytest.approx(
        course_roots(vessel, plant_of(vessel, usual), speed_mps)
    )


def test_course_roots_are_those_of_the_matrix() -> None:
    hull = HullConfig(100.0, 200.0, 50.0, damping=DampingConfig(y_v=30.0, n_r=20.0))
    found = course_roots(REVOLT, PlantConfig(hull=hull), 0.5)
    matrix = np.array([[-30.0 / 200.0, -100.0 * 0.5 / 200.0], [-(200.0 - 100.0) * 0.5 / 50.0, -20.0 / 50.0]])
    expected = sorted(np.linalg.eigvals(matrix), key=lambda root: -root.real)
    assert [root.real for root in found] == pytest.approx([root.real for root in expected], abs=1e-8)


@pytest.mark.parametrize(("name", "grows"), [("as_sailed", True), ("slender", False)])
def test_a_disturbed_course_grows_or_dies_by_the_root(name: str, grows: bool) -> None:
    plant = plant_of(REVOLT, name)
    hull, speed_mps = hull_of(REVOLT, plant), 0.9
    hull.place(0.0, 0.0, 0.0, speed_mps, 0.0, 1e-5)
    rates = []
    for _ in range(2):
        for _ in range(500):
            hull.water_surge_mps = speed_mps
            hull.step(0.0, 0.0, 0.0, 0.01)
        rates.append(abs(hull.yaw_rate_radps))
    assert (rates[1] > rates[0]) == grows
    assert math.log(rates[1] / rates[0]) / 5.0 == pytest.approx(
        course_roots(REVOLT, plant, speed_mps)[0].real, abs=0.03
    )


def test_plants_without_the_tables_move_as_before() -> None:
    for name in bundled():
        vessel = load(find(name))
        assert vessel.sitl is not None
        if vessel.thrusters[0].kind == "sail":  # its hull is all lift
            continue
        usual = vessel.sitl.plants[vessel.sitl.plant]
        assert flows(usual, vessel) == () and usual.equations == "companion" and usual.lag_on == "thrust"
    assert type(hull_of(OTTER, plant_of(OTTER, "fossen"))) is Hull
    assert type(hull_of(OTTER, plant_of(OTTER, "published"))) is OtterHull


def test_own_derivatives_are_munks_and_the_added_mass() -> None:
    own = own_derivatives(MODEL)
    assert own.n_v == pytest.approx(263.93 - 306.44) and own.y_r == pytest.approx(257.0 - 263.93)
    assert wave_hull(MODEL, REVOLT).draft_m == 0.23
