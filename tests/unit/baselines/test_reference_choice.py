"""Two reference generators behind one interface, changed under way."""

from __future__ import annotations

import pytest

from companion.baselines.reference_choice import ChosenReference
from companion.params.store import Parameters


@pytest.mark.parametrize(("first", "second"), [(0, 1), (1, 0)])
def test_a_change_of_law_under_way_is_no_jump_and_arrives(first: int, second: int) -> None:
    parameters = Parameters({"DP_LAW": first})
    reference = ChosenReference(parameters)
    reference.start(0.0, 0.0, 0.0)
    reference.retarget(5.0, -2.0, 0.5)
    for _ in range(100):
        before = reference.update(0.1)
    parameters.set("DP_LAW", second)
    after = reference.update(0.1)
    assert before.north_m is not None and after.north_m is not None
    assert after.north_m - before.north_m == pytest.approx(0.1 * before.surge_mps, abs=0.02) and before.surge_mps > 0.05
    assert after.surge_mps == pytest.approx(before.surge_mps, abs=0.03)
    for _ in range(1500):
        last = reference.update(0.1)
    assert reference.arrived and reference.target == pytest.approx((5.0, -2.0, 0.5))
    assert (last.north_m, last.east_m, last.yaw_rad) == pytest.approx((5.0, -2.0, 0.5), abs=0.01)
