"""Jumps of position: kept out from the first moment, and asked about."""

from __future__ import annotations

import math

import pytest

from companion.core.readings import FixType
from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.position_jump import PositionJump
from companion.nav.outliers import Verdict
from tests.unit.nav.integrity.seen import position

HZ = 20


def fixes(jump: PositionJump, spans: list[tuple[float, float, float]], **more: object) -> list[Verdict | None]:
    """Fixes 20 times a second; each span: (from_s, to_s, north of the estimate)."""
    verdicts = []
    for from_s, to_s, north_m in spans:
        for k in range(round(from_s * HZ), round(to_s * HZ)):
            noise = 0.005 * ((k * 7919) % 13 - 6) / 6
            fix = position(k / HZ, north_m + noise, noise, off=(north_m + noise, noise), **more)  # type: ignore[arg-type]
            verdicts.append(jump.screen(fix, True))
    return verdicts


def found(jump: PositionJump, now_s: float) -> list[str]:
    return [finding.fault for finding in jump.update(Evidence(driven=True), now_s)]


@pytest.mark.parametrize("distance_m", [0.5, 5.0, 50.0, 1e6])
def test_a_jump_is_kept_out_from_its_first_fix_and_named_soon(distance_m: float) -> None:
    jump = PositionJump()
    assert set(fixes(jump, [(0.0, 5.0, 0.0)])) == {None}
    assert set(fixes(jump, [(5.0, 5.3, distance_m)])) == {Verdict.REJECT}
    assert found(jump, 5.3) == []
    assert set(fixes(jump, [(5.3, 5.6, distance_m)])) == {Verdict.REJECT}
    [text] = found(jump, 5.6)
    assert text.startswith("jumped ") and text.endswith(" m")
    assert float(text.split()[1]) == pytest.approx(distance_m, abs=0.1)
    finding = jump.update(Evidence(driven=True), 5.6)[0]
    assert finding.asks and finding.jump and finding.since_s == pytest.approx(5.0)


def test_a_wild_point_passes_without_a_word() -> None:
    jump = PositionJump()
    verdicts = fixes(jump, [(0.0, 5.0, 0.0), (5.0, 5.05, 1000.0), (5.05, 9.0, 0.0)])
    assert verdicts.count(Verdict.REJECT) == 1 and found(jump, 9.0) == []


def test_a_boat_under_way_does_not_jump() -> None:
    jump = PositionJump()
    for k in range(200):
        fix = position(k / HZ, 3.0 * k / HZ, velocity=(3.0, 0.0))
        assert jump.screen(fix, True) is None


def test_a_second_without_fixes_in_waves_is_no_jump() -> None:
    """The mean of the velocities before and after says nothing of the way between: the forces do. A jump shows beside
    them as ever."""
    for jumps_m, verdict in ((0.0, None), (0.5, Verdict.REJECT)):
        jump = PositionJump()
        for t_s in (*(k / HZ for k in range(200)), *(11.15 + k / HZ for k in range(20))):
            way_m, mps = 0.2 * math.sin(4.0 * t_s), 0.8 * math.cos(4.0 * t_s)
            off_m = jumps_m if t_s > 10.5 else 0.0
            fix = position(
                t_s, way_m + off_m, 0.1 * t_s, off=(off_m, 0.0), velocity=(mps, 0.1), inertial=(way_m, 0.0),
                carried=(0.0, 0.1),
            )  # fmt: skip
            assert jump.screen(fix, True) is (verdict if t_s > 10.5 else None)


def test_a_jump_back_ends_it() -> None:
    jump = PositionJump()
    fixes(jump, [(0.0, 5.0, 0.0), (5.0, 7.0, 5.0)])
    assert found(jump, 7.0)
    fixes(jump, [(7.0, 7.2, 0.0)])
    assert not found(jump, 7.2)


def test_an_estimate_that_knows_less_and_less_does_not_follow() -> None:
    jump = PositionJump()
    fixes(jump, [(0.0, 5.0, 0.0)])
    assert set(fixes(jump, [(5.0, 60.0, 5.0)], estimate_sigma_m=10.0)) == {Verdict.REJECT}
    assert found(jump, 60.0)


def test_a_receiver_without_corrections_that_lies_on_does_not_come_to_agree() -> None:
    """Its claims and the estimate's doubts made 9 m of a jump of 10 m: a metre of wander was enough to be believed, and
    the boat went 8 m with it."""
    jump = PositionJump()
    plain: dict[str, object] = {"sigma_m": 2.0, "estimate_sigma_m": 1.2, "fix": FixType.FIX_3D}
    fixes(jump, [(0.0, 5.0, 0.0)], **plain)
    verdicts = fixes(
        jump, [(5.0, 30.0, 10.0), *((s, s + 1.0, 40.0 - s) for s in range(30, 34)), (34.0, 60.0, 7.0)], **plain
    )
    assert set(verdicts) == {Verdict.REJECT} and found(jump, 60.0)
    fixes(jump, [(60.0, 62.0, 4.0)], **plain)
    assert not found(jump, 62.0), "nearer to the estimate than to where it jumped to"


def test_what_the_receiver_claims_is_no_jump() -> None:
    """2 m of a receiver without corrections, and the change to and from such a fix."""
    plain = PositionJump()
    assert set(fixes(plain, [(0.0, 5.0, 0.0), (5.0, 9.0, 2.0)], sigma_m=1.5, fix=FixType.FIX_3D)) == {None}
    change = PositionJump()
    assert set(fixes(change, [(0.0, 5.0, 0.0)])) == {None}
    assert set(fixes(change, [(5.0, 9.0, 2.0)], sigma_m=1.5, fix=FixType.FIX_3D)) == {None}
    assert set(fixes(change, [(9.0, 12.0, 0.0)])) == {None}


def test_a_receiver_that_has_frozen_comes_back_where_the_estimate_can_be() -> None:
    jump = PositionJump()
    fixes(jump, [(0.0, 5.0, 0.0)])
    for k in range(100):  # 5 s of the same fix, while the boat drifts 1 m
        assert jump.screen(position(5.0 + k / HZ, 0.0, off=(-0.01 * k, 0.0)), True) is None
    near = position(10.1, 1.0, 0.02, off=(0.1, 0.0), estimate_sigma_m=0.2)
    assert jump.screen(near, True) is None
    gone = PositionJump()
    fixes(gone, [(0.0, 5.0, 0.0)])
    assert gone.screen(position(10.1, 9.0, off=(9.0, 0.0), estimate_sigma_m=0.2), True) is Verdict.REJECT


def test_disarmed_boats_jump_as_they_like() -> None:
    jump = PositionJump()
    for k in range(100):
        assert jump.screen(position(k / HZ, 50.0 * (k > 50)), False) is None


def test_accepted_it_is_believed() -> None:
    jump = PositionJump()
    fixes(jump, [(0.0, 5.0, 0.0), (5.0, 7.0, 5.0)])
    jump.accept(Channel(Sense.POSITION, "gnss"))
    assert set(fixes(jump, [(7.0, 9.0, 5.0)])) == {None}
    assert not found(jump, 9.0)


@pytest.mark.parametrize("other_m, confirmed", [(5.0, True), (0.0, False)])
def test_another_receiver_confirms_a_jump_or_does_not(other_m: float, confirmed: bool) -> None:
    jump = PositionJump()
    for k in range(8 * HZ):
        jumped = 5.0 if k >= 5 * HZ else 0.0
        noise = 0.004 * (k % 3)
        jump.screen(position(k / HZ, jumped + noise, off=(jumped, 0.0)), True)
        jump.screen(position(k / HZ, other_m + noise, off=(other_m, 0.0), source="spare"), True)
    assert found(jump, 8.0) == ["jumped 5.0 m"]
    assert jump.confirmed("gnss", frozenset(), 8.0) is confirmed
    assert not jump.confirmed("gnss", frozenset({Channel(Sense.POSITION, "spare")}), 8.0)
    assert not jump.confirmed("gnss", frozenset(), 99.0)


@pytest.mark.parametrize(("off_m", "verdict"), [(8.0, None), (9.5, Verdict.REJECT)])
def test_another_grade_of_fix_has_errors_of_its_own(off_m: float, verdict: Verdict | None) -> None:
    """5.3 sigma of the worse grade: one change in a million honest ones is farther off."""
    jump = PositionJump()
    fixes(jump, [(0.0, 5.0, 0.0)], fix=FixType.RTK_FIXED)
    worse = position(5.0, off_m, off=(off_m, 0.0), fix=FixType.FIX_3D, sigma_m=1.65)
    assert jump.screen(worse, True) is verdict


@pytest.mark.parametrize(("off_m", "verdict"), [(0.4, None), (1.0, Verdict.REJECT)])
def test_after_a_second_and_a_half_dead_reckoning_in_waves_may_be_off(off_m: float, verdict: Verdict | None) -> None:
    jump = PositionJump()
    fixes(jump, [(0.0, 5.0, 0.0)])
    assert jump.screen(position(6.5, off_m, off=(off_m, 0.0), estimate_sigma_m=0.05), True) is verdict
