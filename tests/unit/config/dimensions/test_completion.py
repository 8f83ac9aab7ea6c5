"""A vessel from dimensions: what is filled in, what hand-given keys keep, and what is said of what is missing."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from companion.config.dimensions import motors
from companion.config.dimensions.completion import figures_of
from companion.config.dimensions.derivation import top_speed_mps
from companion.config.dimensions.form import dimensions_of
from companion.config.dimensions.limits import largest
from companion.config.plausibility import judgements
from companion.config.vessel import ConfigError, VesselConfig, bundled, find, load, parse

CATAMARAN = """
name = "cat"
title = "A catamaran"
control_rate_hz = 10.0
[home]
lat_deg = 63.4
lon_deg = 10.4
[hull]
form = "catamaran"
length_m = 2.0
beam_m = 1.08
mass_kg = 80.0
hull_beam_m = 0.25
[[thruster]]
name = "port"
kind = "fixed"
x_m = -0.8
y_m = -0.4
motor = "T200"
voltage_v = 16.0
[[thruster]]
name = "starboard"
kind = "fixed"
x_m = -0.8
y_m = 0.4
motor = "T200"
voltage_v = 16.0
[[sensor]]
name = "gnss"
driver = "nmea0183"
antennas = 1
port = "serial:/dev/usv-gnss:115200"
[[actuator]]
name = "mcu"
driver = "microcontroller"
port = "serial:/dev/usv-mcu:115200"
thrusters = ["port", "starboard"]
"""


def vessel(text: str = CATAMARAN) -> VesselConfig:
    return parse(text, "cat.toml")


def test_a_large_boat_without_sideways_thrust_keeps_a_length_from_obstacles_since_it_drifts_as_it_turns() -> None:
    assert vessel(CATAMARAN.replace("length_m = 2.0", "length_m = 6.0")).parameters["CP_DIST"] == pytest.approx(6.0)
    assert vessel().parameters["CP_DIST"] == 3.0
    assert "CP_DIST" not in load(find("revolt")).parameters


def problems(text: str) -> tuple[str, ...]:
    with pytest.raises(ConfigError) as caught:
        parse(text, "cat.toml")
    return caught.value.problems


def test_dimensions_and_motors_are_enough_for_a_boat_and_its_simulation() -> None:
    boat = vessel()
    assert boat.hull.m11_kg > 80.0 and boat.hull.m22_kg > boat.hull.m11_kg
    assert min(boat.hull.damping.x_u, boat.hull.damping.y_vv, boat.hull.damping.n_r) > 0.0
    assert (boat.length_m, boat.beam_m) == (2.0, 1.08)
    assert boat.thrusters[0].max_n == pytest.approx(5.25 * 9.80665, abs=0.1)
    assert boat.limits.sway_n == 0.0 and boat.limits.surge_n == pytest.approx(0.9 * 2.0 * 51.5, rel=0.01)
    assert boat.limits.yaw_nm == pytest.approx(0.9 * 2.0 * 0.4 * 40.2, rel=0.01)
    assert boat.sitl is not None and boat.sitl.gnss == "sbas"
    assert boat.sitl.plants[boat.sitl.plant].hull == boat.hull
    assert 1.0 < top_speed_mps(boat.hull, boat.limits.surge_n) < 3.0
    assert boat.parameters["DP_WATCH_R"] >= boat.length_m


def test_a_key_given_by_hand_overrides_one_figure_alone() -> None:
    derived = vessel()
    by_hand = vessel(CATAMARAN.replace("mass_kg = 80.0", "mass_kg = 80.0\nm22_kg = 123.0"))
    assert by_hand.hull.m22_kg == 123.0 and by_hand.hull.m11_kg == derived.hull.m11_kg
    slow = vessel(CATAMARAN + "[parameters]\nWP_SPEED = 0.4\n")
    assert slow.parameters["WP_SPEED"] == 0.4
    assert slow.parameters["PATH_BW_YAW"] == derived.parameters["PATH_BW_YAW"]


def test_the_top_speed_sets_the_damping_ahead() -> None:
    boat = vessel(CATAMARAN.replace("mass_kg = 80.0", "mass_kg = 80.0\ntop_speed_mps = 1.9"))
    assert top_speed_mps(boat.hull, 2.0 * 51.5) == pytest.approx(1.9, rel=0.01)


def test_figures_stay_known_after_loading_with_their_uncertainty_and_source() -> None:
    boat = vessel()
    figures = {figure.key: figure for figure in figures_of(boat.hull, boat.thrusters)}
    assert figures["hull.m22_kg"].value == pytest.approx(boat.hull.m22_kg, rel=1e-3)
    assert all(figure.factor > 1.0 and figure.formula and figure.source for figure in figures.values())
    aboat = load(find("aboat"))
    assert figures_of(aboat.hull, aboat.thrusters) == ()


def test_one_missing_dimension_is_one_problem_with_its_meaning() -> None:
    found = problems(CATAMARAN.replace("mass_kg = 80.0\n", ""))
    assert len(found) == 1 and "hull.mass_kg: is missing: mass of the boat as it floats, in kg" in found[0]


def test_one_unknown_motor_is_one_problem_with_the_nearest() -> None:
    found = problems(CATAMARAN.replace('motor = "T200"', 'motor = "T220"', 1))
    assert len(found) == 1 and "did you mean 't200'" in found[0] and found[0].startswith("cat.toml:19:")


def test_a_hull_that_cannot_carry_its_mass_is_refused_with_the_draft_that_could() -> None:
    found = problems(CATAMARAN.replace("mass_kg = 80.0", "mass_kg = 80.0\ndraft_m = 0.05"))
    assert len(found) == 1 and "the draft is from 0.08 to 0.52 m" in found[0]


def test_a_missing_key_says_what_it_means_and_its_unit() -> None:
    found = problems(CATAMARAN.replace("lat_deg = 63.4\n", ""))
    assert found == ("cat.toml:5: home.lat_deg: is missing: latitude, in deg",)


@pytest.mark.parametrize("motor", list(motors.table().values()), ids=list(motors.table()))
def test_every_motor_has_rising_thrust_and_a_source(motor: motors.Motor) -> None:
    assert motors.rising(motor) and motor.source and motor.propeller_m > 0.0
    assert all(astern <= ahead for _, ahead, astern in motor.thrust)


def test_thrust_between_and_beyond_the_voltages_of_the_table() -> None:
    t200 = motors.find("Blue Robotics T200")
    assert t200 is not None and t200.at(None) == (65.7, 49.5)
    assert t200.at(14.0)[0] == pytest.approx(0.5 * (36.4 + 51.5))
    assert 51.5 < t200.at(18.0)[0] < t200.at(22.0)[0] and t200.at(10.0)[0] < 36.4
    trolling = motors.find("trolling 55 lb")
    assert trolling is not None and trolling.at(12.0)[0] == pytest.approx(244.7, abs=0.1)
    assert motors.find("paddle") is None


def test_thrust_by_power_and_propeller_is_near_that_of_a_known_motor() -> None:
    assert motors.disc_thrust_n(390.0, 0.076) == pytest.approx(51.5, rel=0.35)  # a T200 at 16 V
    assert motors.disc_thrust_n(1100.0, 0.29) == pytest.approx(311.0, rel=0.35)  # a Travel 1103


def test_a_limit_is_that_to_the_stronger_side() -> None:
    """ReVolt's tunnel gives 14 N to starboard and 6 N to port: turned round, the boat is as strong to the other side."""
    boat = load(find("revolt"))
    turned = [replace(t, max_n=-t.min_n, min_n=-t.max_n) for t in boat.thrusters]
    for axis in range(3):
        assert largest(turned, axis) == pytest.approx(largest(boat.thrusters, axis)), axis


def test_every_bundled_boat_has_limits_that_its_thrusters_can_give() -> None:
    for name in bundled():
        boat = load(find(name))
        if boat.thrusters[0].kind != "jet":
            assert boat.limits.surge_n <= 1.05 * largest(boat.thrusters, 0), name
            assert boat.limits.sway_n <= 1.25 * largest(boat.thrusters, 1) + 1e-6, name


def test_the_draft_follows_from_the_form_where_it_was_not_measured() -> None:
    raw = {"form": "barge", "length_m": 5.0, "beam_m": 2.8, "mass_kg": 1800.0}
    boat, found = dimensions_of(raw, {})
    assert not found and boat is not None and boat.block == pytest.approx(0.9)
    assert boat.draft_m == pytest.approx(1800.0 / 1025.0 / (5.0 * 2.8 * 0.9))
    assert boat.hull_speed_mps == pytest.approx(math.sqrt(9.81 * 5.0 / math.tau))


def test_the_data_of_motors_stand_beside_the_code() -> None:
    assert (Path(motors.__file__).parent / "motors.toml").is_file()


OUTBOARD = (
    CATAMARAN.replace('form = "catamaran"', 'form = "planing"')
    .replace("length_m = 2.0", "length_m = 6.0")
    .replace("beam_m = 1.08", "beam_m = 2.2")
    .replace("mass_kg = 80.0", "mass_kg = 1400.0")
    .replace("hull_beam_m = 0.25\n", "")
    .replace('motor = "T200"\nvoltage_v = 16.0', "max_n = 2000.0")
)


def test_a_planing_boat_reaches_the_top_speed_that_it_was_given() -> None:
    """Propellers with the disc of a trolling motor would lose all thrust before the hull planes."""
    boat = vessel(OUTBOARD.replace("mass_kg", "top_speed_mps = 15.0\nmass_kg"))
    assert top_speed_mps(boat.hull, 4000.0) == pytest.approx(15.0, rel=0.02)
    assert top_speed_mps(boat.hull, boat.limits.surge_n) > 12.0


def test_a_planing_boat_cruises_beyond_its_hump_and_not_near_its_top_speed() -> None:
    slow = vessel(OUTBOARD.replace("mass_kg", "top_speed_mps = 11.0\nmass_kg"))
    top_mps = top_speed_mps(slow.hull, slow.limits.surge_n)
    assert slow.parameters["WP_SPEED"] == pytest.approx(0.6 * top_mps, rel=0.01)
    scooter = vessel(OUTBOARD.replace("mass_kg", "top_speed_mps = 25.0\nmass_kg").replace("2000.0", "6000.0"))
    assert scooter.parameters["WP_SPEED"] == pytest.approx(1.5 * scooter.hull.resistance[3][0], rel=0.01)


def test_a_planing_boat_with_little_thrust_is_taken_at_its_word() -> None:
    boat = vessel(
        OUTBOARD.replace("mass_kg", "top_speed_mps = 15.0\nmass_kg").replace("max_n = 2000.0", "max_n = 900.0")
    )
    assert top_speed_mps(boat.hull, 1800.0) == pytest.approx(15.0, rel=0.02)


def test_a_planing_boat_that_does_not_get_over_its_hump_says_so() -> None:
    found = [str(judgement) for judgement in judgements(vessel(OUTBOARD))]
    assert any("does not plane" in text and "give its top_speed_mps" in text for text in found)


def test_the_fence_margin_covers_what_the_boat_does_in_hold() -> None:
    """Without sideways thrust it drifts in its watch circle, which a receiver's errors widen, and half a length beyond
    that while its bow comes round."""
    two = vessel().parameters
    assert two["DP_WATCH_R"] == 5.0 and two["FENCE_MARGIN"] == 6.0
    bow = '[[thruster]]\nname = "bow"\nkind = "fixed"\nx_m = 0.8\ny_m = 0.0\nazimuth_deg = 90.0\nmax_n = 60.0\n'
    three = CATAMARAN.replace("[[sensor]]", bow + "[[sensor]]", 1).replace('"starboard"]', '"starboard", "bow"]')
    assert vessel(three).parameters["FENCE_MARGIN"] == 2.0


OUTBOARD_ROW = """[[thruster]]
name = "NAME"
kind = "azimuth"
x_m = -0.9
y_m = Y
max_n = 100.0
azimuth_rate_dps = 60.0
azimuth_min_deg = -35.0
azimuth_max_deg = 35.0
"""


def outboards(*places_m: float, bow: bool = False) -> VesselConfig:
    """The catamaran with outboards at its stern, and a thruster across its bow."""
    rows = [OUTBOARD_ROW.replace("NAME", f"out{i}").replace("Y", str(y_m)) for i, y_m in enumerate(places_m)]
    names = [f"out{i}" for i in range(len(places_m))]
    if bow:
        rows.append(
            '[[thruster]]\nname = "bow"\nkind = "fixed"\nx_m = 0.8\ny_m = 0.0\nazimuth_deg = 90.0\nmax_n = 60.0\n'
        )
        names.append("bow")
    start, end = CATAMARAN.index("[[thruster]]"), CATAMARAN.index("[[sensor]]")
    text = CATAMARAN[:start] + "".join(rows) + CATAMARAN[end:]
    return vessel(text.replace('"port", "starboard"', ", ".join(f'"{name}"' for name in names)))


def test_an_outboard_turns_ahead_or_in_reverse_so_that_a_bow_thruster_does_not_make_it_push_sideways() -> None:
    assert outboards(0.0, bow=True).limits.sway_n == 0.0
    two = outboards(-0.3, 0.3, bow=True)
    assert two.limits.sway_n > 20.0, "one ahead, one in reverse"
