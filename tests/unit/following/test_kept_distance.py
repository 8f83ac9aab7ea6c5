"""The distance that is kept for a follow position: what the boat needs to lose its way when the leader stops."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.following.keep_out import round_m
from companion.following.kept_distance import KeptDistance
from companion.params.store import Parameters

ASTERN, ABEAM = (15.0, math.pi), (15.0, 0.5 * math.pi)
JET = load(find("rescuerunner"))


def kept(config: VesselConfig, **parameters: float) -> tuple[KeptDistance, Parameters]:
    table = Parameters({**config.parameters, **parameters})
    return KeptDistance(config, table), table


def test_a_hull_without_way_astern_keeps_the_room_that_it_needs_to_lose_its_way() -> None:
    """It takes about 6 m to turn aside or to coast from 1 to 2 m/s; 5 m outside the circle were kept."""
    distance, table = kept(JET)
    assert 12.0 + 6.0 < distance.of(ASTERN) < 21.0
    assert distance.of(ABEAM) == pytest.approx(round_m(table)), "beside the leader, it passes it"
    assert distance.of((30.0, math.pi)) == 30.0 and distance.of((30.0, 0.0)) == 30.0


def test_a_heavier_hull_that_coasts_further_keeps_more() -> None:
    heavy = replace(JET, hull=replace(JET.hull, m11_kg=2.0 * JET.hull.m11_kg, m22_kg=2.0 * JET.hull.m22_kg))
    assert kept(heavy)[0].of(ASTERN) > kept(JET)[0].of(ASTERN) + 0.5


@pytest.mark.parametrize("name", ["otter", "wamv16", "aboat"])
def test_a_boat_that_brakes_keeps_outside_the_circle_as_before(name: str) -> None:
    distance, table = kept(load(find(name)))
    assert distance.of(ASTERN) == pytest.approx(round_m(table))


def test_it_follows_the_parameters() -> None:
    distance, table = kept(JET)
    before = distance.of(ASTERN)
    table.set("FOLL_MIN_DIST", 20.0)
    assert distance.of(ASTERN) == pytest.approx(before + 8.0)
    table.set("PATH_YAW_RATE", 20.0)
    assert distance.of(ASTERN) > before + 8.5, "it turns aside more slowly"
