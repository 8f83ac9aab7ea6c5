"""A water jet by its pull and the boat."""

import math

import pytest

from companion.config.dimensions.derivation import top_speed_mps
from companion.config.vessel import ConfigError, VesselConfig, find, load, parse
from companion.guidance.bend_speed import steady_turn_radps

SCOOTER = """
name = "scooter"
title = "A scooter with a jet"
control_rate_hz = 20.0
[home]
lat_deg = 57.6
lon_deg = 11.5
[hull]
form = "planing"
length_m = 3.3
beam_m = 1.5
mass_kg = 450.0
top_speed_mps = 20.6
[[thruster]]
name = "jet"
kind = "jet"
x_m = -1.6
y_m = 0.0
max_n = 5582.0
[[sensor]]
name = "gnss"
driver = "nmea0183"
antennas = 1
port = "serial:/dev/usv-gnss:115200"
[[actuator]]
name = "mcu"
driver = "microcontroller"
port = "serial:/dev/usv-mcu:115200"
thrusters = ["jet"]
"""
BY_HAND = "[hull]\nm11_kg = 450.0\nm22_kg = 550.0\nm33_kgm2 = 700.0\n"


def boat(text: str = SCOOTER) -> VesselConfig:
    return parse(text, "scooter.toml")


def test_rescuerunners_jet_follows_from_its_pull_and_top_speed() -> None:
    made, measured = boat(), load(find("rescuerunner"))
    jet, known = made.thrusters[0].jet, measured.thrusters[0].jet
    assert jet is not None and known is not None
    assert jet.density_area_kgpm == pytest.approx(known.density_area_kgpm, rel=0.02)
    assert jet.bollard_n(1.0) == pytest.approx(made.thrusters[0].ahead_n, rel=1e-3)
    assert jet.full_n(20.6) == pytest.approx(known.full_n(20.6), rel=0.05)
    assert made.limits.yaw_nm == pytest.approx(measured.limits.yaw_nm, rel=0.02)
    assert made.parameters["JET_STEER_N"] == pytest.approx(391.0, rel=0.01)
    assert made.limits.sway_n == 0.0 and made.thrusters[0].min_n == 0.0 and made.thrusters[0].dead_band > 0.0


def test_a_jet_keeps_further_from_obstacles_which_it_cannot_brake_for() -> None:
    assert boat().parameters["CP_DIST"] == pytest.approx(1.4 * 3.3)
    assert boat(SCOOTER.replace("length_m = 3.3", "length_m = 2.0")).parameters["CP_DIST"] == 3.0
    assert load(find("rescuerunner")).parameters["CP_DIST"] == pytest.approx(1.4 * 3.6, abs=0.1)


def test_a_planing_scooter_turns_as_tightly_as_rescuerunner() -> None:
    """Steady turn at 8.2 m/s with the nozzle at its stop: a radius of 9 m by RescueRunner's file."""

    def radius_m(config: VesselConfig) -> float:
        damping, ahead_mps, turn = config.hull.damping, 8.2, 0.0
        moment_nm = config.hull.drag_n(ahead_mps) * math.sin(math.radians(24.0)) * -config.thrusters[0].x_m
        for _ in range(200):
            turn += 0.1 * (moment_nm / (damping.n_r + damping.n_ur * ahead_mps + damping.n_rr * turn) - turn)
        return ahead_mps / turn

    known = radius_m(load(find("rescuerunner")))
    assert 8.0 < known < 11.0
    assert 0.6 * known < radius_m(boat()) < 1.6 * known


@pytest.mark.parametrize(
    ("old", "new"), [('form = "planing"', 'form = "monohull"'), ("max_n = 5582.0", "max_n = 300.0")]
)
def test_a_boat_that_does_not_plane_keeps_its_damping_in_yaw(old: str, new: str) -> None:
    text = SCOOTER.replace("top_speed_mps = 20.6\n", "")
    fast, slow = parse(text, "fast.toml"), parse(text.replace(old, new), "slow.toml")
    assert slow.hull.damping.n_ur > 3.0 * fast.hull.damping.n_ur


CAT = 'form = "catamaran"\nhull_beam_m = 1.3\nlength_m = 12.0\nbeam_m = 4.5\nmass_kg = 9000.0\ntop_speed_mps = 9.26'
RIB = 'form = "inflatable"\nlength_m = 6.0\nbeam_m = 2.4\nmass_kg = 1100.0\ntop_speed_mps = 10.3'


@pytest.mark.parametrize(("hull", "x_m", "pull_n", "lengths"), [(CAT, -5.4, 16000.0, 10.0), (RIB, -2.7, 4000.0, 4.5)])
def test_a_jet_in_a_transom_turns_its_hull(hull: str, x_m: float, pull_n: float, lengths: float) -> None:
    """A catamaran of 9 t turned in 24 lengths at cruise and came 100 m off a square's legs of 320 m."""
    head, tail = SCOOTER.split("form = ")[0], SCOOTER.split("top_speed_mps = 20.6")[1]
    text = head + hull + tail.replace("-1.6", str(x_m)).replace("5582.0", str(pull_n))
    made, cruise_mps = parse(text, "jet.toml"), parse(text, "jet.toml").parameters["WP_SPEED"]
    turn_radps = steady_turn_radps(made.hull, cruise_mps, made.limits.yaw_nm)
    assert 2.0 * cruise_mps / turn_radps < lengths * made.length_m


def test_full_throttle_gives_the_top_speed_that_was_measured() -> None:
    made = boat()
    jet = made.thrusters[0].jet
    assert jet is not None and jet.full_n(20.6) == pytest.approx(made.hull.drag_n(20.6), rel=0.01)
    assert top_speed_mps(made.hull, made.limits.surge_n) == pytest.approx(20.6, rel=0.01)


@pytest.mark.parametrize("pull_n", [2500.0, 5582.0])
def test_a_jet_whose_top_speed_is_unknown_is_fitted_to_the_hull(pull_n: float) -> None:
    made = boat(SCOOTER.replace("top_speed_mps = 20.6\n", "").replace("5582.0", str(pull_n)))
    jet, top_mps = made.thrusters[0].jet, top_speed_mps(made.hull, made.limits.surge_n)
    assert jet is not None and 8.0 < top_mps < 26.0
    assert jet.full_n(top_mps) == pytest.approx(made.hull.drag_n(top_mps), rel=0.05)


def test_the_thrust_of_the_limits_lifts_the_hull_over_its_hump() -> None:
    made = boat(SCOOTER.replace("top_speed_mps = 20.6\n", "").replace("5582.0", "1450.0"))
    hump_n = made.hull.resistance[3][1]
    assert made.hull.resistance[4][1] < hump_n < made.limits.surge_n <= made.thrusters[0].max_n


def test_a_nozzle_that_was_measured_sets_the_speed_of_the_jet() -> None:
    jet = (
        boat(SCOOTER.replace("[[sensor]]", "[thruster.jet]\ndensity_area_kgpm = 8.05\n[[sensor]]", 1)).thrusters[0].jet
    )
    assert jet is not None and jet.density_area_kgpm == 8.05
    assert jet.idle_mps + jet.span_mps == pytest.approx((5582.0 / 8.05) ** 0.5, rel=1e-3)


@pytest.mark.parametrize("form", ["planing", "monohull"])
def test_hull_and_measured_nozzle_meet_at_the_top_speed(form: str) -> None:
    text = SCOOTER.replace("[[sensor]]", "[thruster.jet]\ndensity_area_kgpm = 8.05\n[[sensor]]", 1)
    made = boat(text.replace("top_speed_mps = 20.6\n", "").replace("planing", form))
    jet, top_mps = made.thrusters[0].jet, top_speed_mps(made.hull, made.limits.surge_n)
    assert jet is not None and jet.full_n(top_mps) == pytest.approx(made.limits.surge_n, rel=0.01)


def test_keys_given_by_hand_stay() -> None:
    own = "max_n = 5000.0\nahead_n = 5582.0\nazimuth_min_deg = -20.0\nazimuth_max_deg = 20.0\nazimuth_rate_dps = 70.0"
    jet = boat(SCOOTER.replace("max_n = 5582.0", own)).thrusters[0]
    assert (jet.max_n, jet.ahead_n) == (5000.0, 5582.0)
    assert jet.azimuth_max_rad == pytest.approx(0.349, abs=1e-3) and jet.azimuth_rate_radps > 1.2


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("max_n = 5582.0\n", "", "thruster[1].max_n: is missing: pull of the jet at full throttle"),
        ("max_n = 5582.0\n", "max_n = -4.0\n", "thruster[1].max_n: is missing: pull of the jet at full throttle"),
        (SCOOTER[SCOOTER.index("[hull]") : SCOOTER.index("[[thruster]]")], BY_HAND, "a jet needs its table"),
    ],
)
def test_what_is_missing_is_one_problem(right: str, wrong: str, message: str) -> None:
    text = "length_m = 3.3\nbeam_m = 1.5\n" + SCOOTER
    with pytest.raises(ConfigError) as caught:
        boat(text.replace(right, wrong))
    found = [problem for problem in caught.value.problems if "thruster" in problem]
    assert len(found) == 1 and message in found[0], found
