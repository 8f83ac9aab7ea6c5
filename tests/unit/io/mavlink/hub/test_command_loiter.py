"""NAV_LOITER_UNLIM as a command: Hold, here or at a place."""

from __future__ import annotations

import math

import pytest

from tests.unit.io.mavlink.hub.conftest import Rig
from tests.unit.io.mavlink.hub.test_commands import ACCEPTED, DENIED, result

LOITER = 17
NAN = math.nan


@pytest.mark.parametrize("params", [(0.0,) * 7, (NAN,) * 7, (0.0, 0.0, 0.0, 0.0, NAN, NAN, 0.0)])
def test_here_as_pymavlink_sends_it(rig: Rig, params: tuple[float, ...]) -> None:
    assert result(rig.command(LOITER, *params)) == ACCEPTED
    assert rig.supervisor.asked == [("hold_here",)]


def test_at_a_place_in_both_wrappers(rig: Rig) -> None:
    assert result(rig.command(LOITER, 0.0, 0.0, 0.0, 0.0, 63.5, 10.5, 0.0)) == ACCEPTED
    assert result(rig.command_int(LOITER, (0.0, 0.0, 0.0, 0.0), 635000000, 105000000)) == ACCEPTED
    assert rig.supervisor.asked == [("go_to", 63.5, 10.5, None, None)] * 2


def test_nowhere_is_denied(rig: Rig) -> None:
    for lat, lon in ((NAN, 10.0), (91.0, 10.0), (63.0, 181.0), (math.inf, 0.0)):
        assert result(rig.command(LOITER, 0.0, 0.0, 0.0, 0.0, lat, lon, 0.0)) == DENIED
    assert result(rig.command_int(LOITER, (0.0, 0.0, 0.0, 0.0), 635000000, 105000000, the_frame=1)) == DENIED
    assert rig.supervisor.asked == []
