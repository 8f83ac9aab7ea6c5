"""Wrong lines that a person writes into a file of `companion new`: each is found at its place, once, with a remedy."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.cli.new_file import Answers, file_text
from companion.config.plausibility import judgements
from companion.config.vessel import ConfigError, parse

ANSWERS = Answers(
    "cat", "Cat", "catamaran", 1.6, 1.0, 55.0, None, 0.25, None, "twin", "60", None, 0.75,
    "microcontroller", "one", 63.4, 10.4,
)  # fmt: skip
TWIN = file_text(ANSWERS)
OUTBOARD = file_text(replace(ANSWERS, form="planing", layout="azimuth", hull_beam_m=None))
JET = file_text(replace(ANSWERS, form="planing", layout="jet", hull_beam_m=None))
PODS = file_text(replace(ANSWERS, form="monohull", layout="two-azimuths", hull_beam_m=None))


@pytest.mark.parametrize("text", [TWIN, OUTBOARD, JET, PODS])
def test_the_files_themselves_are_right(text: str) -> None:
    parse(text, "boat.toml")


@pytest.mark.parametrize(
    ("text", "right", "wrong", "place", "remedy"),
    [
        (TWIN, "length_m = 1.6", "length_m = 160", "hull.length_m", "160 m long and 1 m wide: check both, in m"),
        (TWIN, "mass_kg = 55", "mass_kg = 55000", "hull.mass_kg", "float 134 m deep: check it, in kg, and length"),
        (TWIN, "mass_kg = 55", "mass_kg = 0.001", "hull.mass_kg", "float less than 0.001 m deep: check it"),
        (
            TWIN,
            "mass_kg = 55",
            "mass_kg = 55\ndraft_m = 20",
            "hull.draft_m",
            "20 m deep and 1.6 m long: check both, in m",
        ),
        (
            JET,
            "max_n = 60",
            "max_n = 60\n[thruster.jet]\ndensity_area_kgpm = 8e6",
            "thruster[1].jet",
            "larger than the hull",
        ),
        (TWIN, "mass_kg = 55", "mass_kg = 0", "hull.mass_kg", "should be a number above 0, not 0"),
        (TWIN, "max_n = 60", 'max_n = "55 lb"', "thruster[1].max_n", "in N, not '55 lb'; 55 lb are 245 N"),
        (OUTBOARD, "max_n = 60", "max_n = -60", "thruster[1].max_n", "should be greater than 0"),
        (TWIN, "/dev/usv-imu", "/dev/usv-gnss", "sensor[2].port", "speaks NMEA 0183, not mtdata2: give each its own"),
        (TWIN, "tcpin:127.0.0.1:5760", "udpout:127.0.0.1:14550", "links", "stands there twice"),
        (TWIN, ', "starboard"]', "]", "thruster", "driven by no bridge: add it to the list of an [[actuator]]"),
        (PODS, "azimuth_min_deg = -90.0", "", "thruster[1].azimuth_max_deg", "give both stops"),
        (OUTBOARD, "min_deg = -35.0", "min_deg = 40.0", "thruster[1].azimuth_max_deg", "exchange the stops"),
        (JET, "max_n = 60", 'motor = "T200"', "thruster[1].max_n", "is missing: pull of the jet at full throttle"),
    ],
)
def test_each_mistake_is_said_once(text: str, right: str, wrong: str, place: str, remedy: str) -> None:
    assert right in text
    with pytest.raises(ConfigError) as caught:
        parse(text.replace(right, wrong, 1), "boat.toml")
    found = [problem for problem in caught.value.problems if f" {place}:" in problem]
    assert len(found) == 1 and remedy in found[0], caught.value.problems
    assert not any("at least 1 item" in problem for problem in caught.value.problems)
    others = [problem for problem in caught.value.problems if "ahead_n: should be" in problem]
    assert not others, "what follows from the mistake is not said"


@pytest.mark.parametrize(
    ("text", "right", "wrong", "said"),
    [
        (TWIN, "y_m = -0.375", "y_m = 0.375", "'port' has y_m = 0.375: y_m is positive to starboard"),
        (TWIN, "y_m = -0.375", "y_m = 0.375", "all thrusters lie on the same side"),
        (PODS, "x_m = 0.64", "x_m = -0.64", "'bow' has x_m = -0.64: x_m is positive ahead"),
        (TWIN, "length_m = 1.6", "length_m = 0.7", "1 m wide and 0.7 m long: length is fore and aft"),
        (TWIN, "mass_kg = 55", "mass_kg = 55\ntop_speed_mps = 20", "check it, in m/s; 20 km/h are 5.6 m/s"),
        (TWIN, "max_n = 60", 'motor = "T200"\nvoltage_v = 160', "160 V at a motor whose thrust is known up to 20 V"),
        (
            TWIN,
            'kind = "fixed"',
            'kind = "fixed"\nazimuth_deg = 1.5708',
            "points 1.571° from ahead, which looks like rad",
        ),
    ],
)
def test_a_wrong_sign_or_unit_that_still_loads_is_noted(text: str, right: str, wrong: str, said: str) -> None:
    assert right in text
    notes = [str(found) for found in judgements(parse(text.replace(right, wrong, 1), "boat.toml"))]
    assert any(said in note for note in notes), notes
    assert not any(said in str(found) for found in judgements(parse(text, "boat.toml")))


@pytest.mark.parametrize("layout", ["twin", "rudder", "two-azimuths"])
def test_a_very_large_or_fast_boat_has_parameters_that_it_may_have(layout: str) -> None:
    large = replace(ANSWERS, form="monohull", length_m=120.0, beam_m=20.0, mass_kg=9e6, hull_beam_m=None, motor="3e5")
    parse(file_text(replace(large, layout=layout)), "boat.toml")
    fast = replace(ANSWERS, form="planing", hull_beam_m=None, mass_kg=200.0, motor="9000", top_speed_mps=40.0)
    parse(file_text(replace(fast, layout=layout)), "boat.toml")


def test_a_boat_without_way_astern_has_a_circle_in_which_it_can_drift_and_turn() -> None:
    """It coasts on after each way back: a circle of 1.5 lengths is left and entered all the time."""
    one_way = OUTBOARD.replace("max_n = 60", "max_n = 60\nmin_n = 0.0")
    of = {name: parse(text, "boat.toml").parameters["DP_WATCH_R"] for name, text in (("x", one_way), ("y", OUTBOARD))}
    assert of["x"] - of["y"] == pytest.approx(4.5 * 1.6)
    assert parse(one_way, "boat.toml").parameters["FENCE_MARGIN"] == pytest.approx(of["x"] + 2.0 * 1.6)


def test_a_small_light_boat_does_not_cruise_far_beyond_its_hull_speed() -> None:
    """Strong motors on 1 m: 2.4 m/s by its thrust. At 1.9 times its hull speed it came 2 m off the legs of a square."""
    small = replace(ANSWERS, length_m=1.0, beam_m=0.6, mass_kg=14.0, hull_beam_m=0.14, spread_m=0.46, motor="T200")
    assert parse(file_text(small), "boat.toml").parameters["WP_SPEED"] == pytest.approx(1.2 * 1.25, rel=0.01)
