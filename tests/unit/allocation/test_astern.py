"""How fast boats sail stern first."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.allocation.astern import astern_n, stern_first_mps
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import find, load

REVOLT, OTTER = load(find("revolt")), load(find("otter"))


def test_thrust_astern() -> None:
    assert astern_n(REVOLT) == pytest.approx(50.0), "pods turn round; the tunnel gives none"
    assert astern_n(OTTER) == pytest.approx(2.0 * 66.7), "propellers reverse, with less thrust"
    backwards = tuple(replace(thruster, azimuth_rad=3.141592653589793) for thruster in OTTER.thrusters)
    assert astern_n(replace(OTTER, thrusters=backwards)) == pytest.approx(OTTER.limits.surge_n)


def test_a_boat_with_less_thrust_astern_is_slower() -> None:
    ahead, astern = top_speed_mps(OTTER), stern_first_mps(OTTER)
    assert 0.4 * ahead < astern < 0.8 * ahead
    assert OTTER.hull.drag_n(astern) < astern_n(OTTER)
