"""How fast a hull that is unstable on its course can be sailed."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from companion.cli.new_file import file_text
from companion.config.dimensions.derivation import top_speed_mps
from companion.config.dimensions.steady_course import COMES_BACK_RAD, mastered_rad, steady_mps
from companion.config.hull import DampingConfig, HullConfig
from companion.config.vessel import VesselConfig, find, load, parse
from companion.control.model import force_for
from tests.unit.rudder_boat import ANSWERS

# Hidden boat 224 of `tests.scenarios.identified_hulls`, rounded, as its Trial found it.
UNSTABLE = HullConfig(
    m11_kg=70.0,
    m22_kg=115.0,
    m33_kgm2=19.0,
    m23_kgm=1.5,
    damping=DampingConfig(x_u=10.0, x_uu=15.0, y_v=4.0, y_vv=80.0, n_r=3.0, n_rr=6.0, y_uv=20.0, n_uv=-6.0, n_ur=5.0),
)


def twins(m22_kg: float) -> VesselConfig:
    """Two fixed thrusters 0.3 m apart."""
    text = file_text(replace(ANSWERS, layout="twin", spread_m=0.3))
    return parse(text.replace("[hull]\n", f"[hull]\nm22_kg = {m22_kg}\n"), "twins.toml")


def motion(speed_mps: float) -> tuple[NDArray[np.floating[Any]], NDArray[np.floating[Any]]]:
    """(A, b) of ẋ = A x + b N for x = (v, r), by the derivatives of the controller's model."""
    small = 1.0e-6
    inertia = np.array(
        [[UNSTABLE.m22_kg, UNSTABLE.m23_kgm], [UNSTABLE.yaw_coupling_kgm, UNSTABLE.m33_kgm2]], dtype=np.float64
    )
    columns = [force_for(UNSTABLE, speed_mps, v, r, 0.0, 0.0, 0.0) for v, r in ((small, 0.0), (0.0, small))]
    damping = np.array([[c.sway_n for c in columns], [c.yaw_nm for c in columns]]) / small
    return -np.linalg.solve(inertia, damping), np.linalg.solve(inertia, np.array([0.0, 1.0]))


@pytest.mark.parametrize("speed_mps", [0.6, 1.0, 1.5])
def test_mastered_is_by_the_unstable_eigenvector(speed_mps: float) -> None:
    a, b = motion(speed_mps)
    values, vectors = np.linalg.eig(a.T)
    unstable = int(np.argmax(values.real))
    weights = vectors[:, unstable].real
    v_mps = abs(weights @ b) * 9.5 / values[unstable].real / abs(weights[0])
    assert mastered_rad(UNSTABLE, speed_mps, 9.5) == pytest.approx(math.atan2(v_mps, speed_mps), rel=1e-4)


@pytest.mark.parametrize(("share", "comes_back"), [(0.97, True), (1.03, False)])
def test_the_full_moment_brings_back_what_it_masters_and_no_more(share: float, comes_back: bool) -> None:
    speed_mps, moment_nm = 1.2, 9.5
    a, b = motion(speed_mps)
    # against a drift to port, which turns the bow to port, all of the moment to starboard
    side = -np.sign(np.linalg.solve(a, b)[0])
    x = np.array([share * speed_mps * math.tan(mastered_rad(UNSTABLE, speed_mps, moment_nm)), 0.0])
    x *= side
    for _ in range(20_000):
        x = x + 1.0e-3 * (a @ x + b * moment_nm)
    assert (abs(x[0]) < 0.1 or x[0] * side < 0.0) == comes_back


def test_a_stable_hull_masters_any_drift() -> None:
    otter = load(find("otter"))
    assert mastered_rad(otter.hull, 2.0, 1.0) == math.inf
    top_mps = top_speed_mps(otter.hull, otter.limits.surge_n)
    assert steady_mps(otter.hull, otter.thrusters, otter.limits.yaw_nm, top_mps) == math.inf


def test_steady_is_the_last_speed_from_which_it_comes_back() -> None:
    thrusters = twins(82).thrusters
    speed_mps = steady_mps(UNSTABLE, thrusters, 9.5, 2.0)
    assert 0.3 < speed_mps < 1.0
    assert mastered_rad(UNSTABLE, speed_mps + 0.3, 2.0 * 9.5) < COMES_BACK_RAD
    assert steady_mps(UNSTABLE, thrusters, 95.0, 2.0) == math.inf
    assert steady_mps(UNSTABLE, thrusters, 9.5, math.inf) == math.inf


def test_a_hull_without_inertia_is_left_to_other_checks() -> None:
    assert mastered_rad(replace(UNSTABLE, m23_kgm=500.0), 1.0, 9.5) == math.inf


def test_speeds_that_follow_from_the_dimensions_keep_within_it() -> None:
    usual, heavy = map(twins, (82, 200))
    top_mps = top_speed_mps(heavy.hull, heavy.limits.surge_n)
    steady = steady_mps(heavy.hull, heavy.thrusters, heavy.limits.yaw_nm, top_mps)
    assert heavy.parameters["WP_SPEED"] == heavy.parameters["MPC_XY_VEL_MAX"] == pytest.approx(steady, abs=1e-3)
    assert heavy.parameters["WP_SPEED"] < 0.8 * usual.parameters["WP_SPEED"]
