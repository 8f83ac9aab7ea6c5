"""What the solution with an inertial sensor makes of the slow errors of positions, at rest."""

from __future__ import annotations

import pytest

from companion.core.readings import Imu
from companion.nav.inertial import InertialSolution
from companion.nav.lever_arms import ZERO
from companion.nav.measured_off import Wander
from companion.nav.outliers import Verdict
from companion.nav.solution import Motion

G = 9.82


def at_rest(wander_m: float) -> InertialSolution:
    made = InertialSolution(G, ZERO)
    made.expect_wander(Wander(wander_m, 300.0), another=False)
    made.sample(Imu(0.0, "imu", 0.0, 0.0, -G, 0.0, 0.0, 0.0))
    made.start(Motion(0.0, ZERO, ZERO, ZERO, ZERO, 0.1, 0.05, 0.01), (0.0, 0.0))
    return made


def fixes(made: InertialSolution, north_m: float, from_s: float, seconds: float) -> list[Verdict]:
    """Samples at 100 Hz, a fix and a velocity every tenth of a second."""
    verdicts = []
    for k in range(1, round(seconds * 100) + 1):
        t_s = from_s + k / 100
        made.sample(Imu(t_s, "imu", 0.0, 0.0, -G, 0.0, 0.0, 0.0))
        if k % 10 == 0:
            made.velocity(t_s, 0.0, 0.0, ZERO, 0.02)
            verdicts.append(made.position(t_s, north_m, 0.0, ZERO, 0.02))
    return verdicts


def test_the_first_position_after_the_start_says_where_the_boat_is() -> None:
    """As far as it is off by its slow error, which the sigma holds."""
    made = at_rest(0.5)
    assert fixes(made, 0.1, 0.0, 0.1) == [Verdict.ACCEPT]
    motion = made.motion(0.1)
    assert motion.position[0] == pytest.approx(0.1, abs=1e-6)
    assert motion.position_sigma_m == pytest.approx(0.5, abs=0.01)


def test_a_jump_that_the_slow_error_explains_does_not_move_the_boat() -> None:
    """As when other satellites come. One that it does not explain moves it."""
    made = at_rest(0.5)
    fixes(made, 0.0, 0.0, 10.0)
    assert Verdict.REJECT in fixes(made, 1.2, 10.0, 5.0)
    motion, place = made.motion(15.0), made.place(15.0)
    assert abs(motion.position[0]) < 0.9 and place.north_m == pytest.approx(1.2, abs=0.02)
    assert motion.position[0] + made.filter.wander[0] == pytest.approx(1.2, abs=0.02)
    assert Verdict.RESET in fixes(made, 30.0, 15.0, 5.0)
    assert made.motion(20.0).position[0] == pytest.approx(30.0, abs=0.05)


def test_another_receiver_shares_a_part_of_the_slow_error() -> None:
    made = at_rest(0.5)
    fixes(made, 0.3, 0.0, 10.0)
    fixes(made, 0.6, 10.0, 10.0)
    before = made.filter.wander[0]
    made.expect_wander(Wander(0.5, 300.0), another=True)
    assert made.filter.wander[0] == pytest.approx(0.7 * before)
