"""Which thruster is which, from the motions of a motor check."""

from __future__ import annotations

import math

import pytest

from companion.config.vessel import find, load
from companion.modes.trial.wiring import Motion, expected_motions, faults

REVOLT = load(find("revolt"))
EXPECTED = expected_motions(REVOLT, [0.5, 0.5, 0.5], 2.4)
NOISE = 0.01


def turned(motion: Motion, degrees: float) -> Motion:
    """As a compass that reads `degrees` too much shows it."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return c * motion[0] + s * motion[1], c * motion[1] - s * motion[0], motion[2]


def reversed_(motion: Motion) -> Motion:
    return -motion[0], -motion[1], -motion[2]


def texts(observed: list[Motion | None]) -> list[str]:
    return [fault.text for fault in faults(REVOLT, EXPECTED, observed, NOISE)]


def test_the_expected_motion_is_that_of_the_thrusters_place() -> None:
    port, starboard, bow = EXPECTED
    assert port[0] == pytest.approx(0.5 * 25.0 * 2.4 / 263.93) and port[2] > 0.0 > starboard[2]
    assert bow[1] > 0.0 and bow[2] > 0.0 and abs(bow[0]) < 1e-9


def test_nothing_is_wrong() -> None:
    assert texts(list(EXPECTED)) == []
    assert texts([None, *EXPECTED[1:]]) == []


@pytest.mark.parametrize("index", range(3))
def test_a_reversed_thruster_is_named(index: int) -> None:
    observed: list[Motion | None] = [reversed_(m) if i == index else m for i, m in enumerate(EXPECTED)]
    assert texts(observed) == [f"{REVOLT.thrusters[index].name} reversed"]


def test_swapped_thrusters_are_named() -> None:
    port, starboard, bow = EXPECTED
    assert texts([starboard, port, bow]) == ["stern_port and stern_starboard swapped"]
    assert texts([bow, starboard, port]) == ["stern_port and bow swapped"]


def test_a_swapped_and_reversed_pair_is_named() -> None:
    port, starboard, bow = EXPECTED
    assert texts([reversed_(bow), starboard, port]) == ["stern_port and bow swapped", "bow reversed"]


@pytest.mark.parametrize("degrees", [90.0, 180.0, -90.0])
def test_a_turned_compass_is_named(degrees: float) -> None:
    assert texts([turned(m, degrees) for m in EXPECTED]) == [f"compass {degrees:+.0f} deg off"]


def test_a_thruster_at_the_other_end_is_named() -> None:
    port, starboard, bow = EXPECTED
    assert texts([port, starboard, (bow[0], bow[1], -bow[2])]) == ["bow at the other end"]


def test_a_silent_thruster_is_named() -> None:
    assert texts([EXPECTED[0], (0.0, 0.001, 0.0), EXPECTED[2]]) == ["stern_starboard does not push"]


def test_strength_does_not_matter_and_noise_is_forgiven() -> None:
    strong: list[Motion | None] = [(2.0 * x + 0.01, 2.0 * y - 0.01, 2.0 * n + 0.005) for x, y, n in EXPECTED]
    assert texts(strong) == []


def test_motions_that_were_measured_in_wind() -> None:
    """Of the simulated ReVolt in 6 m/s with gusts."""
    calm: list[Motion | None] = [(0.186, 0.001, -0.012), (0.2, 0.006, 0.001), (0.033, 0.057, 0.096)]
    assert texts(calm) == []
    assert texts([*calm[:2], (0.003, -0.01, -0.15)]) == ["bow reversed"]
    compass: list[Motion | None] = [(-0.018, -0.235, -0.012), (-0.087, -0.317, 0.001), (-0.047, -0.052, 0.099)]
    assert texts(compass) == ["compass +90 deg off"]


def test_yaw_that_drowns_in_gusts_does_not_count() -> None:
    """Of the simulated ReVolt in 6 m/s: the pods are 15 cm off the middle, and a gust turned the boat the other way."""
    gusty: list[Motion | None] = [(0.182, -0.01, -0.023), (0.208, -0.003, 0.033), (0.01, -0.018, 0.112)]
    assert texts(gusty) == ["stern_port and stern_starboard swapped"]
    assert faults(REVOLT, EXPECTED, gusty, NOISE, gust=0.02) == ()
