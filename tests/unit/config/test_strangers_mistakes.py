"""Wrong lines that a person writes into a file of `companion new`: each is found at its place, once, with a remedy."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.cli.new_file import Answers, file_text
from companion.config.plausibility import judgements
from companion.config.vessel import ConfigError, find, load, parse

ANSWERS = Answers(
    "cat", "Cat", "catamaran", 1.6, 1.0, 55.0, None, 0.25, None, "twin", "60", None, 0.75,
    "microcontroller", "one", 63.4, 10.4,
)  # fmt: skip
TWIN = file_text(ANSWERS)
OUTBOARD = file_text(replace(ANSWERS, form="planing", layout="azimuth", hull_beam_m=None))
JET = file_text(replace(ANSWERS, form="planing", layout="jet", hull_beam_m=None))
RUDDER = file_text(replace(ANSWERS, form="monohull", layout="rudder", hull_beam_m=None))
PIXHAWK = file_text(replace(ANSWERS, board="pixhawk"))
PODS = file_text(replace(ANSWERS, form="monohull", layout="two-azimuths", hull_beam_m=None))


@pytest.mark.parametrize("text", [TWIN, OUTBOARD, JET, PODS, RUDDER, PIXHAWK])
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
        (TWIN, "mass_kg = 55", "mas_kg = 55", "hull.mas_kg", "did you mean 'mass_kg'?"),
        (TWIN, 'form = "catamaran"', "", "hull.form", "is missing: one of monohull"),
        (TWIN, "\nbeam_m = 1", "\n#", "hull.beam_m", "is missing: width over all, in m"),
        (TWIN, 'name = "cat"', 'name = "My cat"', "name", "should be small letters, digits and _"),
        (TWIN, "lat_deg = 63.400000", 'lat_deg = "63 N"', "home.lat_deg", "should be a number, without quotes"),
        (TWIN, "[[sensor]]", "[[sensors]]", "sensors", "did you mean 'sensor'?"),
        (TWIN, '["port", "starboard"]', '"port"', "actuator[1].thrusters", "should be a list in square brackets"),
        (
            TWIN,
            "y_m = -0.375",
            "y_m = 0.375",
            "thruster[1].y_m",
            "check the signs of all y_m, or is a thruster missing",
        ),
        (JET, "max_n = 60", 'motor = "T200"', "thruster[1].max_n", "is missing: pull of the jet at full throttle"),
        (TWIN, "[[actuator]]", "[actuator]", "actuator", "is a list of tables: each begins with [[actuator]]"),
        (TWIN, "max_n = 60", 'motor = "T200"\nvoltage_v = -16', "thruster[1].voltage_v", "a number above 0, in V"),
        (TWIN, "max_n = 60", 'motor = "T200"\nvoltage_v = "16"', "thruster[1].voltage_v", "a number above 0, in V"),
        (TWIN, "mass_kg = 55", "mass_kg = 55\nhull_spacing_m = 750", "hull.hull_spacing_m", "but beam_m is 1: check"),
        (
            PODS,
            "mass_kg = 55",
            "mass_kg = 55\n[hull.damping]\nn_r = -9.0\nn_rr = -20.0",
            "hull.damping.n_r",
            "the damping of yaw drives the boat on: positive is what resists",
        ),
        (PODS, "mass_kg = 55", "mass_kg = 55\n[hull.damping]\nx_u = -9.0\nx_uu = -9.0", "hull.damping.x_u", "positive"),
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
    ("text", "right", "wrong"),
    [
        (RUDDER, "mass_kg = 55", "mass_kg = -55"),
        (RUDDER, 'form = "monohull"', 'form = "kayak"'),
        (RUDDER, 'form = "monohull"', ""),
        (JET, "mass_kg = 55", "mass_kg = -55"),
        (JET, 'form = "planing"', 'form = "jet ski"'),
        (PIXHAWK, "[[actuator]]", "[[actuators]]"),
    ],
)
def test_what_only_follows_from_a_mistake_is_not_said(text: str, right: str, wrong: str) -> None:
    """A rudder and a jet follow from the hull: with its mass wrong, they were asked for as well."""
    assert right in text
    with pytest.raises(ConfigError) as caught:
        parse(text.replace(right, wrong, 1), "boat.toml")
    assert len(caught.value.problems) == 1, caught.value.problems


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("max_n = 60 ", "max_n = 6 ", "'starboard' opposite with 60 N: check both"),
        ("[[thruster]]", "[hull.damping]\nn_ur = -900.0\n[[thruster]]", "the damping of yaw drives the boat on"),
        ("[[thruster]]", "[hull.damping]\ny_uv = -900.0\n[[thruster]]", "the damping of sway drives the boat on"),
    ],
)
def test_a_weak_half_of_a_pair_and_damping_that_turns_its_sign_are_noted(old: str, new: str, said: str) -> None:
    assert old in TWIN
    notes = [str(found) for found in judgements(parse(TWIN.replace(old, new, 1), "boat.toml"))]
    assert any(said in note for note in notes), notes
    assert not any(said in str(found) for found in judgements(parse(TWIN, "boat.toml")))


def test_a_jet_that_hardly_turns_its_hull_is_noted() -> None:
    """A catamaran of 9 t came 100 m off a square with legs of 320 m, and was without fault by its file."""
    large = replace(ANSWERS, length_m=12.0, beam_m=4.5, mass_kg=9000.0, hull_beam_m=1.3, layout="jet", motor="16000")
    text = file_text(replace(large, top_speed_mps=9.26)) + "[hull.damping]\nn_ur = 41050.0\n"  # a keel to the stern
    notes = [str(found) for found in judgements(parse(text, "boat.toml"))]
    assert any("a turning circle of 286 m at 5.2 m/s" in note and "24 lengths" in note for note in notes), notes
    assert not any("by its nozzle" in str(found) for found in judgements(load(find("rescuerunner"))))


def test_damping_in_yaw_that_falls_with_the_rate_is_a_boat() -> None:
    """An identified model may have a small negative factor beside a positive one: the rate of its turn had no root."""
    parse(PODS.replace("mass_kg = 55", "mass_kg = 55\n[hull.damping]\nn_r = 15.0\nn_rr = -3.0"), "boat.toml")


@pytest.mark.parametrize(
    ("text", "right", "wrong", "said"),
    [
        (TWIN, "y_m = -0.375", "y_m = 0.2", "'port' has y_m = 0.2: y_m is positive to starboard"),
        (TWIN, "y_m = -0.375", "y_m = 0.2", "all thrusters lie on the same side"),
        (
            OUTBOARD,
            "deg = -35.0\nazimuth_max_deg = 35.0",
            "deg = -0.6\nazimuth_max_deg = 0.6",
            "0.6° at most, which looks",
        ),
        (OUTBOARD, "rate_dps = 60.0", "rate_dps = 1.05", "turns 1.05° in a second, which looks like radians"),
        (TWIN, 'kind = "fixed"', 'kind = "fixed"\nazimuth_deg = 0.785', "points 0.785° from ahead"),
        (TWIN, "antennas = 1", "antennas = 1\nx_m = 1.3", "'gnss' at x 1.3 m, y 0 m is outside the hull: check both"),
        (TWIN, "/dev/usv-gnss:115200", "/dev/ttyUSB0", "'gnss' at /dev/ttyUSB0: that number changes"),
        (TWIN, "z_m = -0.40", "z_m = -40", "'gnss' is 40 m above the middle of the boat: check it, in m"),
        (TWIN, "mass_kg = 55", "mass_kg = 55\ntop_speed_mps = 0.1", "0.06 times the hull speed: check it, in m/s"),
        (TWIN, "mass_kg = 55", "mass_kg = 55\nm11_kg = 40", "40 kg are less than mass_kg, 55 kg"),
        (TWIN, "mass_kg = 55", "mass_kg = 55\nm33_kgm2 = 2000", "a radius of 4.2 m, usual are 0.16 to 0.8 m"),
        (OUTBOARD, "mass_kg = 55", "mass_kg = 55\ntop_speed_mps = 28", "28 km/h are 7.8 m/s"),
        (OUTBOARD, "mass_kg = 55", "mass_kg = 55\nhull_beam_m = 0.2", "has no effect on one hull, of form planing"),
        (TWIN, 'driver = "nmea0183"', 'driver = "ais"', "no sensor gives a position"),
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


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("mass_kg = 55", "mass_kg = 55,5", "a number has a decimal point, not a comma"),
        ("mass_kg = 55", "mass_kg = 55 kg", "a number has no unit behind it"),
        ("mass_kg = 55", "mass_kg = 55\nmass_kg = 56", "'mass_kg' stands there twice"),
        ("mass_kg = 55", "mass_kg", "a line reads `key = value`"),
        ('name = "cat"', 'name = "cat', "a quote is not closed"),
        ('name = "cat"', "name = “cat”", "text stands in straight quotes"),
        ('name = "cat"', "name = «cat»", "text stands in straight quotes"),
        ("mass_kg = 55", "mass_kg = \u221255", "a minus sign U+2212: type the hyphen of the keyboard, -"),
        ("mass_kg = 55", "mass_kg =\u00a055", "a non-breaking space U+00A0: type a plain space"),
        ('name = "cat"', 'name\u00a0= "cat"', "a non-breaking space U+00A0: type a plain space"),
        ('name = "cat"', "name = cat", 'text stands in quotes, "like this"'),
        ("[[sensor]]", "[sensor]", "[sensor] above is one table: each row of a list begins with [[sensor]]"),
        (
            "[[thruster]]",
            "[hull]\n[[thruster]]",
            "[hull] stands there twice: join the two, or begin each with [[hull]]",
        ),
    ],
)
def test_a_line_that_is_no_toml_is_told_with_the_remedy(right: str, wrong: str, said: str) -> None:
    line = TWIN[: TWIN.index(right)].count("\n") + 1
    with pytest.raises(ConfigError) as caught:
        parse(TWIN.replace(right, wrong, 1), "boat.toml")
    (problem,) = caught.value.problems
    assert said in problem and int(problem.split(":")[1]) >= line


def test_an_outboard_beside_the_middle_is_a_boat_and_one_fixed_thruster_is_none() -> None:
    """One propeller that turns goes ahead by pointing past the middle of the boat."""
    beside = parse(OUTBOARD.replace("y_m = 0 ", "y_m = 0.25 ", 1), "boat.toml").limits
    middle = parse(OUTBOARD, "boat.toml").limits
    assert 0.8 * middle.surge_n < beside.surge_n < middle.surge_n and beside.sway_n == 0.0 < beside.yaw_nm
    fixed = OUTBOARD.replace('kind = "azimuth"', 'kind = "fixed"')
    with pytest.raises(ConfigError, match="nothing turns the boat"):
        parse(fixed, "boat.toml")


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
