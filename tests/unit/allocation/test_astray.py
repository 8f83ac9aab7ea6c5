"""When thrusters turn away from where they will push."""

from __future__ import annotations

import math

import pytest

from companion.allocation.astray import Astray
from companion.allocation.geometry import thrusters_of
from companion.config.vessel import find, load

ABOAT = load(find("aboat"))
DT_S = 0.1
STEP_RAD = ABOAT.thrusters[0].azimuth_rate_radps * DT_S
ASKED = (0.1, 0.1)


def seen(astray: Astray, azimuths_rad: list[float], shares: tuple[float, float] = ASKED) -> list[bool]:
    """Whether both turn to an aim of 0, at the azimuth of each cycle."""
    return [astray.update(shares, (0.0, 0.0), (azimuth, -azimuth), DT_S) for azimuth in azimuths_rad]


def test_thrusters_that_turn_away_are_turned_to_their_aims_until_they_are_near() -> None:
    astray = Astray(thrusters_of(ABOAT))
    away = seen(astray, [1.0 + STEP_RAD * k for k in range(6)])
    assert away[0] is False and away[-1] is True
    back = seen(astray, [1.4 - STEP_RAD * k for k in range(20)])
    assert back[0] is True and back[-1] is False


@pytest.mark.parametrize("shares, sign", [(ASKED, -1.0), ((0.01, 0.01), 1.0)], ids=["on the way", "hardly asked for"])
def test_others_are_left_alone(shares: tuple[float, float], sign: float) -> None:
    astray = Astray(thrusters_of(ABOAT))
    assert not any(seen(astray, [math.pi / 2 + sign * STEP_RAD * k for k in range(15)], shares))


def test_to_and_fro_counts_as_away() -> None:
    astray = Astray(thrusters_of(ABOAT))
    wave = [1.0 + 3.0 * STEP_RAD * math.sin(math.tau * k / 12) for k in range(24)]
    assert seen(astray, wave)[-1]
    astray.reset()
    assert not seen(astray, wave[:1])[0]
