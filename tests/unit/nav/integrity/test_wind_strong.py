"""A wind that no small boat lies in."""

from __future__ import annotations

import pytest

from companion.core.readings import Wind
from companion.nav.integrity.evidence import Channel, Evidence, LieFound, Sense
from companion.nav.integrity.wind_strong import WindStrong

HZ = 4


def blow(hypothesis: WindStrong, speed_mps: float, from_s: float, seconds: float, **boat: float) -> list[LieFound]:
    """What is found at the end."""
    found: list[LieFound] = []
    for k in range(round(seconds * HZ)):
        t_s = from_s + k / HZ
        evidence = Evidence(winds=[Wind(t_s, "wind", speed_mps, 0.3)], driven=True)
        evidence.north_mps = boat.get("north_mps", 0.0)
        found = list(hypothesis.update(evidence, t_s))
    return found


def test_a_breeze_that_is_told_ten_times_too_strong_is_not_used() -> None:
    hypothesis = WindStrong()
    assert blow(hypothesis, 4.0, 0.0, 20.0) == []
    (finding,) = blow(hypothesis, 40.0, 20.0, 6.0)
    assert finding.channel == Channel(Sense.WIND, "wind") and finding.fault == "says 40 m/s"
    assert not finding.lasting and 20.0 < finding.since_s < 24.0
    assert blow(hypothesis, 30.0, 26.0, 6.0), "near the limit it comes and goes else"
    assert blow(hypothesis, 15.0, 32.0, 20.0), "nor is a lull the end of it"
    assert blow(hypothesis, 4.0, 52.0, 20.0) == []


def test_it_is_found_where_it_was_so_from_the_start() -> None:
    (finding,) = blow(WindStrong(), 40.0, 0.0, 1.0)
    assert finding.fault == "says 40 m/s"


@pytest.mark.parametrize(("speed_mps", "north_mps"), [(32.0, 0.0), (45.0, 15.0)])
def test_a_storm_and_a_fast_boat_in_the_wind_are_honest(speed_mps: float, north_mps: float) -> None:
    assert blow(WindStrong(), speed_mps, 0.0, 60.0, north_mps=north_mps) == []


def test_one_wild_wind_is_none() -> None:
    hypothesis = WindStrong()
    assert blow(hypothesis, 8.0, 0.0, 20.0) == []
    assert blow(hypothesis, 99.0, 20.0, 1.0 / HZ) == []
