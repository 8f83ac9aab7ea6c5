"""Jumps of heading: told from those of the gyro."""

from __future__ import annotations

import math

import pytest

from companion.nav.integrity.evidence import Evidence
from companion.nav.integrity.heading_jump import HeadingJump
from companion.nav.outliers import Verdict
from tests.unit.nav.integrity.seen import heading

HZ = 20


def test_a_heading_turned_round_is_kept_out() -> None:
    jump = HeadingJump()
    for k in range(100):
        assert jump.screen(heading(k / HZ, 0.001 * (k % 7)), True) is None
    for k in range(20):
        turned = heading(5.0 + k / HZ, math.pi - 0.001 * (k % 7), off_rad=math.pi)
        assert jump.screen(turned, True) is Verdict.REJECT
    finding = jump.update(Evidence(driven=True), 6.0)[0]
    assert finding.fault == "jumped 180 deg" and finding.asks
    jump.accept(finding.channel)
    assert not jump.update(Evidence(driven=True), 6.0)


def test_a_turn_that_the_gyro_felt_is_none() -> None:
    jump = HeadingJump()
    for k in range(200):
        yaw = math.remainder(0.05 * k, math.tau)
        assert jump.screen(heading(k / HZ, yaw, 0.05 * k), True) is None


def test_a_gyro_that_jumps_is_not_the_headings_fault() -> None:
    jump = HeadingJump()
    for k in range(100):
        assert jump.screen(heading(k / HZ, 0.001 * (k % 7), 1.0 if k > 50 else 0.0), True) is None


def test_after_a_gap_the_gyro_has_carried_the_heading() -> None:
    jump = HeadingJump()
    jump.screen(heading(0.0, 0.0), True)
    assert jump.screen(heading(10.0, 0.5, 0.5, off_rad=0.02), True) is None
    assert jump.screen(heading(20.0, 2.0, 0.5, off_rad=1.5), True) is Verdict.REJECT


@pytest.mark.parametrize("outlier_rad", [-0.11, 0.11])
def test_an_outlier_in_a_turn_is_none(outlier_rad: float) -> None:
    """Going back, the heading turns by less than the gyro felt."""
    jump = HeadingJump()
    for k in range(100):
        yaw_rad = -0.07 * k
        seen = heading(k / HZ, math.remainder(yaw_rad + (outlier_rad if k == 60 else 0.0), math.tau), yaw_rad)
        assert (jump.screen(seen, True) is None) is (k != 60 or outlier_rad > 0.0)
        assert not jump.update(Evidence(driven=True), k / HZ)
