"""The thesis's rule, and the gate that replaces it."""

from __future__ import annotations

import pytest

from companion.nav.outliers import POSITION_GATE, FirstPosition, InnovationGate, ThesisOutlierRule, Verdict


def started_rule() -> ThesisOutlierRule:
    rule = ThesisOutlierRule()
    for _ in range(20):
        rule.update(0.0, 0.0)
    return rule


def test_thesis_rule_begins_with_the_median_of_20() -> None:
    rule = ThesisOutlierRule()
    points = [(0.0, 0.0)] * 13 + [(5000e3, -3000e3)] * 6
    assert {rule.update(*point) for point in points} == {Verdict.REJECT}
    assert rule.approved is None
    rule.update(0.2, 0.1)
    assert rule.approved == (0.0, 0.0)


def test_thesis_rule_rejects_20_and_approves_the_21st() -> None:
    rule = started_rule()
    assert rule.update(0.9, 0.0) is Verdict.ACCEPT
    assert [rule.update(3.0, 0.0) for _ in range(20)] == [Verdict.REJECT] * 20
    assert rule.approved == (0.9, 0.0)
    assert rule.update(3.0, 0.1) is Verdict.RESET
    assert rule.approved == (3.0, 0.1)


def test_thesis_rule_counts_only_rejections_in_a_row() -> None:
    rule = started_rule()
    for _ in range(20):
        assert rule.update(3.0, 0.0) is Verdict.REJECT
    assert rule.update(0.0, 0.0) is Verdict.ACCEPT
    assert rule.update(3.0, 0.0) is Verdict.REJECT


def verdicts(gate: InnovationGate, innovations: list[tuple[float, float]], sigma: float = 0.05) -> list[Verdict]:
    return [gate.update(n, e, (n * n + e * e) / sigma**2, sigma) for n, e in innovations]


def test_gate_resets_at_the_21st_that_agrees() -> None:
    gate = InnovationGate(POSITION_GATE)
    found = verdicts(gate, [(3.0, 0.0)] * 21)
    assert found == [Verdict.REJECT] * 20 + [Verdict.RESET]
    assert gate.rejections == 0


def test_gate_rejects_scattered_points() -> None:
    gate = InnovationGate(POSITION_GATE)
    scattered = [(10.0 * (-1) ** k * (k + 1), 7.0 * k) for k in range(90)]
    assert set(verdicts(gate, scattered)) == {Verdict.REJECT}


def test_gate_is_not_locked_out_when_the_prediction_runs_away() -> None:
    """Innovations that grow without end never agree with their median; after 100 it is the prediction that is wrong."""
    gate = InnovationGate(POSITION_GATE)
    found = verdicts(gate, [(2.0 + 0.2 * k, 0.0) for k in range(101)])
    assert found == [Verdict.REJECT] * 100 + [Verdict.RESET]


def test_gate_resets_at_the_fifth_where_a_prediction_that_may_go_astray_does() -> None:
    def found(innovations: list[tuple[float, float]]) -> list[Verdict]:
        gate = InnovationGate(POSITION_GATE)
        return [gate.update(n, e, 1e6, 0.05, drifts=True) for n, e in innovations]

    assert found([(2.0 + 2.0 * k, 1.0 + k) for k in range(5)]) == [Verdict.REJECT] * 4 + [Verdict.RESET]
    assert set(found([(5.0, 0.0)] * 20)) == {Verdict.REJECT}  # it has jumped
    assert set(found([(10.0 * (-1) ** k * (k + 1), 7.0 * k) for k in range(90)])) == {Verdict.REJECT}


def test_gate_opens_with_the_covariance() -> None:
    """One metre after an outage that made the predicted sigma 0.5 m is accepted."""
    gate = InnovationGate(POSITION_GATE)
    assert gate.update(1.0, 0.0, 1.0 / 0.5**2, 0.05) is Verdict.ACCEPT
    assert gate.update(1.0, 0.0, 1.0 / 0.05**2, 0.05) is Verdict.REJECT


def test_gate_passes_small_innovations_whatever_the_covariance() -> None:
    assert InnovationGate(POSITION_GATE).update(0.2, 0.2, 1e6, 0.01) is Verdict.ACCEPT


def test_first_position_of_a_moving_boat_is_the_newest() -> None:
    first = FirstPosition()
    found = [first.update(0.05 * k, 0.0, 0.02, 0.05 * k) for k in range(20)]
    assert found[:19] == [None] * 19
    assert found[19] == pytest.approx((0.95, 0.0))


def test_first_position_waits_while_the_newest_is_an_outlier() -> None:
    first = FirstPosition()
    for k in range(19):
        assert first.update(0.0, 0.0, 0.02, 0.05 * k) is None
    assert first.update(4000e3, 0.0, 0.02, 0.95) is None
    assert first.update(0.01, 0.0, 0.02, 1.0) == (0.01, 0.0)


def test_first_position_of_a_slow_receiver() -> None:
    first = FirstPosition()
    found = [first.update(0.0, 0.0, 1.5, float(k)) for k in range(3)]
    assert found == [None, None, (0.0, 0.0)]


def test_the_first_positions_tell_how_fast_the_boat_is() -> None:
    first = FirstPosition()
    for k in range(20):
        first.update(3.0 * 0.05 * k + (4000.0 if k == 7 else 0.0), -0.05 * k, 0.02, 0.05 * k)
    way = first.way(0.02)
    assert (way.north_mps, way.east_mps) == pytest.approx((3.0, -1.0), abs=1e-6)  # whatever one outlier says
    assert 0.5 < way.sigma_mps < 1.0
    assert first.way(1.0).sigma_mps > 1.5  # the noise of positions is that of the velocity between two


def test_before_any_two_positions_nobody_knows_how_fast_the_boat_is() -> None:
    first = FirstPosition()
    assert first.way(0.02).sigma_mps >= 5.0
    first.update(1.0, 2.0, 0.02, 3.0)
    assert first.way(0.02)[:2] == (0.0, 0.0) and first.way(0.02).sigma_mps >= 5.0
