"""What a vessel's file may say of a sail."""

from __future__ import annotations

import math

import pytest

from companion.config.vessel import ConfigError, find, load, parse, with_model_error

TEXT = find("sailbot").read_text(encoding="utf-8")
BOAT = load(find("sailbot"))


def test_the_sheet_lets_the_boom_out() -> None:
    sail = BOAT.thrusters[0].sail
    assert sail is not None
    assert math.degrees(sail.boom_rad(0.0)) == pytest.approx(85.0)
    assert math.degrees(sail.boom_rad(1.0)) == pytest.approx(5.0)
    assert sail.sheet(sail.boom_rad(0.3)) == pytest.approx(0.3)
    assert (sail.sheet(math.pi), sail.sheet(0.0)) == (0.0, 1.0)


def with_motor(text: str = TEXT) -> str:
    """The file of the boat with a motor beside its sail, driven by the same board."""
    motor = """[[thruster]]
name = "motor"
kind = "fixed"
x_m = -0.6
y_m = 0.0
max_n = 6.0
min_n = -3.0
ahead_n = 6.0
astern_n = 3.0
force_rate_nps = 20.0

[[sensor]]"""
    return text.replace("[[sensor]]", motor, 1).replace('thrusters = ["rig"]', 'thrusters = ["rig", "motor"]')


def wing(text: str = TEXT) -> str:
    """The file of the boat with a wing in the place of its sail."""
    return text.replace("aspect = 2.5", "aspect = 5.0\nattack_max_deg = 14.0").replace("min_n = 0.0", "min_n = -8.0")


def test_a_wing_turns_to_both_sides_and_pushes_no_boat_astern() -> None:
    thruster = parse(wing(), "boat.toml").thrusters[0]
    assert thruster.sail is not None
    assert thruster.sail.attack_max_rad == pytest.approx(math.radians(14.0))
    assert not thruster.pushes_astern


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("min_n = -8.0", "min_n = 0.0", "min_n: should be -8, the negative of max_n: a wing turns to either side"),
        ("attack_max_deg = 14.0", "attack_max_deg = 16.0", "attack_max_deg: .*less than or equal to 15"),
    ],
)
def test_what_a_wing_cannot_be_is_told(old: str, new: str, problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        parse(wing().replace(old, new), "boat.toml")


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("min_n = 0.0", "min_n = -1.0", "min_n: should be 0: a sail does not drive a boat astern"),
        ("sway_n = 0.0", "sway_n = 1.0", "sway_n: a sail cannot push a boat sideways"),
        ("x_m = -0.653", "x_m = 0.653", "rudder.x_m: a rudder is at the stern"),
        ("azimuth_max_deg = 40.0", "azimuth_max_deg = 70.0", "its rudder needs stops either side"),
        ("azimuth_rate_dps", "retractable = true\ntravel_s = 1.0\nazimuth_rate_dps", "retractable: not for a sail"),
        ('kind = "sail"', 'kind = "azimuth"', "sail: only for a thruster of kind 'sail'"),
    ],
)
def test_what_cannot_be_is_told_with_its_place(old: str, new: str, problem: str) -> None:
    assert TEXT.count(old) == 1
    with pytest.raises(ConfigError, match=problem):
        parse(TEXT.replace(old, new), "boat.toml")


def test_a_sail_needs_its_table_and_a_rudder() -> None:
    begin, end = TEXT.index("[thruster.rudder]"), TEXT.index("[[sensor]]")
    with pytest.raises(ConfigError, match=r"a sail needs its table \[thruster.rudder\]"):
        parse(TEXT[:begin] + TEXT[end:], "boat.toml")


def test_motors_may_be_beside_a_sail() -> None:
    rig, motor = parse(with_motor(), "boat.toml").thrusters
    assert (rig.kind, motor.kind) == ("sail", "fixed")


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('kind = "fixed"', 'kind = "fixed"\nazimuth_deg = 90.0', "azimuth_deg: a motor beside a sail pushes ahead"),
        ("y_m = 0.0\nmax_n = 6.0", "y_m = 0.3\nmax_n = 6.0", "y_m: a motor beside a sail is on the middle line"),
        ('kind = "fixed"', 'kind = "azimuth"\nazimuth_rate_dps = 60', "kind: a motor beside a sail should be 'fixed'"),
    ],
)
def test_what_a_motor_beside_a_sail_cannot_be_is_told(old: str, new: str, problem: str) -> None:
    assert with_motor().count(old) == 1
    with pytest.raises(ConfigError, match=problem):
        parse(with_motor().replace(old, new), "boat.toml")


def test_the_sail_comes_first() -> None:
    begin, middle, end = (
        with_motor().index(word) for word in ("[[thruster]]", '[[thruster]]\nname = "motor"', "[[sensor]]")
    )
    text = with_motor()
    with pytest.raises(ConfigError, match="a sail must be the first thruster"):
        parse(text[:begin] + text[middle:end] + text[begin:middle] + text[end:], "boat.toml")


def test_a_wrong_model_has_a_wrong_sail() -> None:
    sail = with_model_error(BOAT, 0.2).thrusters[0].sail
    assert sail is not None
    assert sail.force_scale == pytest.approx(1.2)
