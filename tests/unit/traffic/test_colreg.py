"""Encounters by the sectors of the rules, and the closest point of approach against a numerical minimiser."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from companion.core.estimate import Contact
from companion.traffic.colreg import Encounter, closest_approach, encounter, gives_way, keeps_astern, sides


def other(bearing_deg: float, course_deg: float, speed_mps: float, away_m: float = 100.0) -> Contact:
    b, c = math.radians(bearing_deg), math.radians(course_deg)
    return Contact(
        1,
        "NORA",
        away_m * math.cos(b),
        away_m * math.sin(b),
        speed_mps * math.cos(c),
        speed_mps * math.sin(c),
        radius_m=4.0,
        status=0,
    )


@pytest.mark.parametrize("turned_deg", [0.0, 77.0, 200.0])
@pytest.mark.parametrize(
    ("bearing_deg", "course_deg", "speed_mps", "expected"),
    [
        (0.0, 180.0, 1.0, Encounter.HEAD_ON),
        (5.0, 190.0, 1.0, Encounter.HEAD_ON),
        (45.0, 270.0, 1.0, Encounter.CROSSING_STARBOARD),
        (100.0, 300.0, 1.5, Encounter.CROSSING_STARBOARD),
        (-45.0, 90.0, 1.0, Encounter.CROSSING_PORT),
        (-110.0, 45.0, 1.8, Encounter.CROSSING_PORT),
        (0.0, 0.0, 0.5, Encounter.OVERTAKING),
        (10.0, 320.0, 0.5, Encounter.OVERTAKING),
        (180.0, 0.0, 2.0, Encounter.OVERTAKEN),
        (120.0, 330.0, 2.0, Encounter.OVERTAKEN),
        (3.0, 90.0, 0.1, Encounter.STANDING),
    ],
)
def test_encounters(
    turned_deg: float, bearing_deg: float, course_deg: float, speed_mps: float, expected: Encounter
) -> None:
    """The boat at 1.2 m/s; whatever way north is."""
    turned = math.radians(turned_deg)
    there = other(bearing_deg + turned_deg, course_deg + turned_deg, speed_mps)
    assert encounter((0.0, 0.0), (1.2 * math.cos(turned), 1.2 * math.sin(turned)), there) is expected


@given(st.floats(-180, 180), st.floats(0.3, 5.0), st.floats(0.3, 5.0), st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_never_do_both_stand_on(
    course_deg: float, own_mps: float, other_mps: float, north_m: float, east_m: float
) -> None:
    """Seen from the other vessel, who stands on here gives way there: two vessels that would be within 15 m of each
    other after 60 s."""
    course = math.radians(course_deg)
    north_mps, east_mps = other_mps * math.cos(course), other_mps * math.sin(course)
    place = (60.0 * (own_mps - north_mps) + north_m, -60.0 * east_mps + east_m)
    assume(math.hypot(*place) > 30.0)
    there = Contact(1, "NORA", *place, north_mps, east_mps, 4.0, 0)
    here = Contact(2, "WE", 0.0, 0.0, own_mps, 0.0, 2.0, 0)
    met, back = encounter((0.0, 0.0), (own_mps, 0.0), there), encounter(place, (north_mps, east_mps), here)
    assert gives_way(met, 0) or gives_way(back, 0)
    assert Encounter.OVERTAKEN not in (met, back) or Encounter.OVERTAKING in (met, back)


def test_duties() -> None:
    duties = {met: gives_way(met, 0) for met in Encounter}
    assert [met for met, gives in duties.items() if not gives] == [Encounter.CROSSING_PORT, Encounter.OVERTAKEN]
    for status in (2, 3, 4, 7, 8):  # rule 18
        assert gives_way(Encounter.CROSSING_PORT, status) and not gives_way(Encounter.OVERTAKEN, status)
    assert sides(Encounter.HEAD_ON) == sides(Encounter.CROSSING_STARBOARD) == sides(Encounter.CROSSING_PORT) == (1,)
    assert set(sides(Encounter.OVERTAKING)) == {1, -1}
    assert keeps_astern(Encounter.CROSSING_STARBOARD, 0) and not keeps_astern(Encounter.HEAD_ON, 0)


speeds = st.floats(-5.0, 5.0)
places = st.floats(-300.0, 300.0)


@given(places, places, speeds, speeds, speeds, speeds)
def test_closest_approach(north_m: float, east_m: float, a: float, b: float, c: float, d: float) -> None:
    there = Contact(1, "NORA", north_m, east_m, c, d, 4.0, None)
    assume(math.hypot(c - a, d - b) > 0.05)
    distance_m, t_s = closest_approach((0.0, 0.0), (a, b), there)
    found = minimize_scalar(
        lambda t: math.hypot(north_m + (c - a) * t, east_m + (d - b) * t),
        bounds=(0.0, 20_000.0),
        method="bounded",
        options={"xatol": 1e-6},
    )
    assert distance_m <= found.fun + 1e-3 and t_s >= 0.0
    assert distance_m == pytest.approx(math.hypot(north_m + (c - a) * t_s, east_m + (d - b) * t_s))
