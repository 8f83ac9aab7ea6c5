"""A vessel's file: every error at once, each with its line."""

import math
from pathlib import Path

import pytest

from companion.config import vessel as config
from companion.config.vessel import ConfigError


def revolt_text() -> str:
    return config.find("revolt").read_text(encoding="utf-8")


def test_the_bundled_revolt_is_as_in_the_thesis() -> None:
    vessel = config.load(config.find("revolt"))
    assert (vessel.home.lat_deg, vessel.home.lon_deg, vessel.home.yaw_rad) == (63.4389, 10.3990, 0.0)
    bow = vessel.thrusters[2]
    assert (bow.max_n, bow.min_n, bow.azimuth_rad) == (14.0, -6.1, pytest.approx(math.pi / 2))
    assert bow.ahead_n == pytest.approx(1.518e-3 * 100**2)
    assert vessel.thrusters[0].azimuth_rate_radps == pytest.approx(math.radians(150.0))
    assert vessel.sitl is not None and set(vessel.sitl.plants) == {"as_sailed", "sea_trial", "thesis", "slender"}


def test_the_bundled_aboat_needs_180_n_for_1_4_mps_and_lasts_two_hours() -> None:
    vessel = config.load(config.find("aboat"))
    damping = vessel.hull.damping
    assert 1.4 * (damping.x_u + damping.x_uu * 1.4) == pytest.approx(180.0, rel=0.01)
    assert [t.x_m for t in vessel.thrusters] == [1.6, -1.6] and all(
        (t.max_n, t.min_n) == (240.0, -180.0) for t in vessel.thrusters
    )
    simulation = vessel.sitl
    assert simulation is not None and set(simulation.plants) == {"as_rigged", "light", "laden", "slender"}
    power_w = simulation.hotel_power_w + simulation.full_power_w * (0.5 * 180.0 / 240.0) ** 1.5
    assert 2.0 < simulation.battery_wh / power_w < 4.0
    masses = {name: plant.hull.m11_kg / 1.05 for name, plant in simulation.plants.items()}
    assert masses == pytest.approx(
        {"as_rigged": 160.0, "slender": 160.0, "light": 34.0 + 34.0, "laden": 34.0 + 295.0}, rel=0.001
    )


def test_five_errors_are_listed_at_once_each_with_its_line() -> None:
    text = revolt_text()
    for right, wrong in (
        ("lat_deg = 63.4389", "lat_deg = 95.0"),
        ("surge_n = 50.0", "surge_m = 50.0"),
        ('kind = "fixed"', 'kind = "paddle"'),
        ("x_m = 1.15", 'x_m = "a metre"'),
    ):
        assert right in text
        text = text.replace(right, wrong, 1)
    with pytest.raises(ConfigError) as caught:
        config.parse(text, "boat.toml")
    problems = caught.value.problems
    assert len(problems) == 4  # that surge_n is missing is only the consequence of its being misspelt
    lines = text.splitlines()
    for problem, fragment in (
        (problems[0], "lat_deg = 95.0"),
        (problems[1], "surge_m = 50.0"),
        (problems[2], 'kind = "paddle"'),
        (problems[3], 'x_m = "a metre"'),
    ):
        number = int(problem.split(":")[1])
        assert fragment in lines[number - 1], problem
    assert "thruster[3].kind" in problems[2] and "'azimuth', 'fixed', 'jet', 'rudder' or 'sail'" in problems[2]
    assert "unknown key; did you mean 'surge_n'?" in problems[1]


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('"bow"]', '"bo"]', "no thruster named 'bo'"),
        ('name = "imu"', 'name = "gnss"', "'gnss' is used twice"),
        (
            'name = "microcontroller"',
            'name = "imu"',
            r"actuator\[1\].name: 'imu' is a sensor's name too: give the bridge another",
        ),
        ("control_rate_hz = 10.0", "control_rate_hz = 3.0", "control_rate_hz: should be greater than or equal to 4"),
        ('plant = "as_sailed"', 'plant = "dry"', "no plant named 'dry'"),
        ("m23_kgm = 7.0", "m23_kgm = 70000.0", "not positive definite"),
        ("thruster_x_m = [-1.12, -1.12, 1.12]", "thruster_x_m = [1.0]", "needs 3 values"),
        ("[sitl.plants.slender]", '[sitl.plants.slender]\nequations = "otter_2024"', "the companion's own equations"),
        ("n_rr = 300.0\n[sitl.plants.slender.lift]", "n_ur = 9.0\n[sitl.plants.slender.lift]", "twice"),
        ('law = "clarke"', 'law = "lewis"', "clarke"),
        ("azimuth_rate_dps = 150.0", "azimuth_rate_dps = 0.0", "rate above 0"),
        ("travel_s = 5.0", "", r"thruster\[3\].travel_s: a retractable thruster needs the time"),
        ("retractable = true ", "retractable = false", "travel_s: only for a retractable thruster"),
        ("length_m = 3.0", "length_m = nan", "finite"),
        ("length_m = 3.0", "length_m = ", "not valid TOML"),
    ],
)
def test_what_no_single_field_can_know(right: str, wrong: str, message: str) -> None:
    text = revolt_text()
    assert right in text
    with pytest.raises(ConfigError, match=message):
        config.parse(text.replace(right, wrong, 1), "boat.toml")


def test_an_m32_of_zero_is_no_m32_left_out() -> None:
    """M22 M33 > M23 M32 holds for any M23 then."""
    text = revolt_text().replace("m23_kgm = 7.0", "m23_kgm = 70000.0", 1)
    hull = config.parse(text.replace("m32_kgm = 7.03", "m32_kgm = 0.0", 1), "boat.toml").hull
    assert (hull.m23_kgm, hull.yaw_coupling_kgm) == (70000.0, 0.0)


def test_unknown_vessel_says_which_there_are(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no vessel named 'revlot'; bundled: .*revolt"):
        config.find("revlot")
    with pytest.raises(ConfigError, match="no such file"):
        config.find(str(tmp_path / "boat.toml"))
    binary = tmp_path / "boat.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match=r"boat\.toml: not text in UTF-8"):
        config.load(binary)
    with pytest.raises(ConfigError, match="a folder; give the TOML file in it"):
        config.find(str(tmp_path))


def test_a_misspelt_file_is_guessed_from_those_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my_boat.toml").write_text("")
    with pytest.raises(ConfigError, match=r"no such file; did you mean '.*/my_boat\.toml'\?"):
        config.find(str(tmp_path / "my_bot.toml"))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError, match=r"no vessel named 'my_boat'.*; did you mean 'my_boat\.toml'\?"):
        config.find("my_boat")


def test_a_file_saved_by_an_editor_of_windows_is_read(tmp_path: Path) -> None:
    """It begins with a mark of three bytes, and its lines end in two."""
    boat = tmp_path / "boat.toml"
    boat.write_bytes(b"\xef\xbb\xbf" + revolt_text().replace("\n", "\r\n").encode())
    assert config.load(boat) == config.load(config.find("revolt"))


def test_a_wrong_belief_leaves_the_plants_true() -> None:
    vessel = config.load(config.find("revolt"))
    believed = config.with_model_error(vessel, 0.5)
    assert believed.hull.m22_kg == pytest.approx(1.5 * vessel.hull.m22_kg)
    assert believed.hull.damping.y_vv == pytest.approx(1.5 * vessel.hull.damping.y_vv)
    assert believed.sitl == vessel.sitl


def test_cybership_is_as_published() -> None:
    """Skjetne, Smogeli and Fossen 2004; the controller's model is the plant's."""
    vessel = config.load(config.find("cybership2"))
    assert (vessel.hull.m11_kg, vessel.hull.m22_kg, vessel.hull.m33_kgm2) == (25.8, 33.8, 2.76)
    assert vessel.sitl is not None and vessel.sitl.plants["basin"].hull == vessel.hull
    full = [thruster.max_n for thruster in vessel.thrusters]
    assert full[0] + full[1] == vessel.limits.surge_n == 8.0 and vessel.limits.yaw_nm == 2.0
    assert vessel.limits.sway_n > 2.0 * full[2], "bow and stern push aside together"
    assert vessel.parameters["DPT_KD_YAW"] == 25.0


def test_forbidden_sectors_are_read_and_checked() -> None:
    text = revolt_text()
    sectors = text.replace(
        "manual_azimuth_deg = 45.0", "manual_azimuth_deg = 45.0\nforbidden_deg = [[60, 120], [150, -150]]", 1
    )
    assert config.parse(sectors, "x").thrusters[0].forbidden_rad[0] == pytest.approx(
        (math.radians(60.0), math.radians(120.0))
    )
    at_rest = sectors.replace("[[60, 120]", "[[-10, 10]")
    with pytest.raises(ConfigError, match=r"forbidden_deg.*at rest lies in a forbidden sector"):
        config.parse(at_rest, "x")
    fixed = text.replace("azimuth_rate_dps = 25.0", "azimuth_rate_dps = 25.0\nforbidden_deg = [[-60, 60]]", 1)
    with pytest.raises(ConfigError, match="a fixed thruster has no sectors"):
        config.parse(fixed, "x")


def test_servos_and_relays_are_read_and_checked() -> None:
    driven = 'thrusters = ["stern_port", "stern_starboard", "bow"]\nservos = ["winch"]\nrelays = ["pump"]'
    text = revolt_text().replace('thrusters = ["stern_port", "stern_starboard", "bow"]', driven, 1)
    servo, relay = '[[servo]]\nname = "winch"\nrest_us = 1500\n', '[[relay]]\nname = "pump"\nwhile_disarmed = true\n'
    boat = config.parse(f"{text}\n{servo}{relay}", "x")
    assert (boat.servos[0].rest_us, boat.servos[0].max_us, boat.relays[0].while_disarmed) == (1500.0, 2000.0, True)
    for wrong, problem in (
        (servo + relay + '[[relay]]\nname = "lamp"\n', "relay: 'lamp' is driven by no bridge"),
        (servo, "actuator.1.relays: no relay named 'pump'"),
        (servo.replace("1500", "2100") + relay, "servo.1.rest_us: should be within min_us and max_us, 1000 to 2000"),
        (servo + "max_us = 900\n" + relay, "servo.1.max_us: should be above min_us, 1000"),
    ):
        with pytest.raises(ConfigError) as caught:
            config.parse(f"{text}\n{wrong}", "x")
        assert any(problem in line.replace("[", ".").replace("]", "") for line in caught.value.problems), (
            caught.value.problems
        )


def test_a_magnetometer_matrix_without_an_inverse_is_told_with_its_line() -> None:
    text = config.find("revolt").read_text(encoding="utf-8")
    text = text.replace(
        'name = "imu"\n', 'name = "imu"\nmag_matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]\n'
    )
    with pytest.raises(ConfigError) as caught:
        config.parse(text, "boat.toml")
    line = text.splitlines().index("mag_matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]") + 1
    assert len(caught.value.problems) == 1 and caught.value.problems[0].startswith(
        f"boat.toml:{line}: sensor[2].mag_matrix: has no inverse"
    )


def test_a_receiver_has_errors_for_each_kind_of_fix() -> None:
    text = config.find("revolt").read_text(encoding="utf-8")
    told = text.replace("z_m = -0.2\n", "z_m = -0.2\nrtk_fixed = { noise_m = 0.005, wander_m = 0.01 }\n", 1)
    gnss = config.parse(told, "boat.toml").sensors[0]
    assert gnss.rtk_fixed is not None and (gnss.rtk_fixed.noise_m, gnss.rtk_fixed.wander_m) == (0.005, 0.01)
    assert gnss.rtk_fixed.wander_s is None and gnss.rtk_float is None
    with pytest.raises(ConfigError, match="rtk_fixed"):
        config.parse(told.replace("noise_m = 0.005", "noise_m = -1.0"), "boat.toml")


@pytest.mark.parametrize(
    ("with_", "x_m", "problem"),
    [
        ("spare", 1.0, "sensor[3].heading_with: 'spare' is no other sensor"),
        ("fore", 1.0, "sensor[3].heading_with: 'fore' is no other sensor"),
        ("gnss", -0.81, "sensor[3].heading_with: 'gnss' has its antenna at the same x_m, y_m"),
    ],
)
def test_a_pair_of_receivers_that_gives_no_heading_is_told(with_: str, x_m: float, problem: str) -> None:
    text = config.find("revolt").read_text(encoding="utf-8")
    row = f'\n[[sensor]]\nname = "fore"\ndriver = "nmea0183"\nport = "serial:/dev/a"\nx_m = {x_m}\nheading_with = "{with_}"\n'
    with pytest.raises(ConfigError) as caught:
        config.parse(text + row, "boat.toml")
    assert any(problem in line for line in caught.value.problems), caught.value.problems


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('kind = "jet"', 'kind = "fixed"', r"thruster\[1\].jet: only for a thruster of kind 'jet'"),
        (
            "[thruster.jet]\ndensity_area_kgpm = 5.125\nidle_mps = 6.0\nspan_mps = 27.0\nexponent = 1.32\nintake_share = 0.9",
            "",
            "needs its table",
        ),
        ("ahead_n = 5582.0", "ahead_n = 4000.0", r"ahead_n: the jet's own curve gives 5581 N"),
        ("min_n = 0.0 ", "min_n = -100.0 ", "reverse bucket is not steered"),
        ("azimuth_min_deg = -24.0", "", "a nozzle needs stops"),
        ("y_m = 0.0", "y_m = 0.1", "in the middle of the boat"),
        ("x_m = -1.6", "x_m = 1.6", "at the stern"),
        ("dead_band = 0.02", "dead_band = 0.0", "dead_band: should be above 0"),
        ("azimuth_rate_dps = 70.0", "azimuth_rate_dps = 0.0", "kind 'jet' needs a rate above 0"),
        ("sway_n = 0.0", "sway_n = 50.0", "cannot push itself sideways"),
        ("[4.0, 600.0]", "[1.0, 600.0]", "hull.resistance: needs two pairs"),
        ("[[0.0, 0.0]", "[[0.0, 5.0]", "rising speeds"),
    ],
)
def test_what_must_be_true_of_a_jet_and_of_a_planing_hull(right: str, wrong: str, message: str) -> None:
    text = config.find("rescuerunner").read_text(encoding="utf-8")
    assert right in text
    with pytest.raises(ConfigError, match=message):
        config.parse(text.replace(right, wrong, 1), "boat.toml")


def test_a_jet_is_alone() -> None:
    """Two jets are told how to be one."""
    text = config.find("rescuerunner").read_text(encoding="utf-8")
    second = text[text.index("[[thruster]]") : text.index("[[sensor]]")].replace('"jet"\nkind', '"spare"\nkind')
    with pytest.raises(ConfigError, match=r"must be the only thruster.*max_n the sum, y_m = 0"):
        config.parse(
            text.replace("[[sensor]]", f"{second}[[sensor]]", 1).replace('["jet"]', '["jet", "spare"]'), "boat.toml"
        )


def test_a_wrong_belief_reaches_the_resistance_too() -> None:
    vessel = config.load(config.find("rescuerunner"))
    assert config.with_model_error(vessel, 0.5).hull.drag_n(8.0) == pytest.approx(1.5 * vessel.hull.drag_n(8.0))
