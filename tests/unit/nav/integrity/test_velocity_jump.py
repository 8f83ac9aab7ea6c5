"""Jumps of velocity: told from those of the accelerometers."""

from __future__ import annotations

from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.velocity_jump import VelocityJump
from companion.nav.outliers import Verdict
from tests.unit.nav.integrity.seen import velocity

HZ = 20


def test_a_velocity_that_no_force_explains_is_kept_out() -> None:
    jump = VelocityJump()
    for k in range(100):
        assert jump.screen(velocity(k / HZ, 0.001 * (k % 7)), True) is None
    verdicts = [jump.screen(velocity(5.0 + k / HZ, 0.5 + 0.001 * (k % 7), off=(0.5, 0.0)), True) for k in range(20)]
    assert set(verdicts) == {Verdict.REJECT} and jump.suspects("gnss")
    assert [finding.fault for finding in jump.update(Evidence(driven=True), 6.0)] == ["jumped 0.5 m/s"]
    jump.accept(Channel(Sense.VELOCITY, "gnss"))
    assert not jump.suspects("gnss")


def test_a_velocity_that_a_force_explains_is_used() -> None:
    jump = VelocityJump()
    for k in range(100):
        speed = 0.1 * k + 0.001 * (k % 7)  # 2 m/s²
        assert jump.screen(velocity(k / HZ, speed, felt=(0.1 * k, 0.0)), True) is None


def test_accelerometers_that_jump_are_not_the_receivers_fault() -> None:
    jump = VelocityJump()
    for k in range(100):
        felt = (3.0, 0.0) if k > 50 else (0.0, 0.0)
        assert jump.screen(velocity(k / HZ, 0.001 * (k % 7), felt=felt), True) is None


def test_without_accelerometers_a_boat_may_accelerate() -> None:
    jump = VelocityJump()
    for k in range(100):
        assert jump.screen(velocity(k / HZ, 0.14 * k, felt=None), True) is None
    assert jump.screen(velocity(5.0, 16.0, felt=None), True) is Verdict.REJECT


def test_an_outlier_in_waves_is_none() -> None:
    """It comes and goes in steps of which one is smaller than what the accelerometers felt."""
    jump = VelocityJump()
    steps = {60: -0.14, 61: 0.23, 62: -0.09}
    apart = 0.0
    for k in range(100):
        apart += steps.get(k, 0.0)
        felt = 0.1 * k
        jump.screen(velocity(k / HZ, felt + apart + 0.001 * (k % 7), felt=(felt, 0.0)), True)
        assert not jump.update(Evidence(driven=True), k / HZ)
    assert not jump.suspects("gnss")


def test_dead_reckoning_that_has_got_worse_does_not_agree_with_a_small_jump() -> None:
    jump = VelocityJump()
    for k in range(100):
        assert jump.screen(velocity(k / HZ, 0.001 * (k % 7)), True) is None
    for k in range(100):
        assert jump.screen(velocity(5.0 + k / HZ, 0.22 + 0.001 * (k % 7), off=(0.13, 0.0)), True) is Verdict.REJECT
    back = [jump.screen(velocity(10.0 + k / HZ, 0.22 + 0.001 * (k % 7), off=(0.05, 0.0)), True) for k in range(40)]
    assert back[-1] is None, "there it does"
