"""What `companion check` says of a boat that loads, but that hardly exists."""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import pytest

from companion.config.hull import DampingConfig
from companion.config.outputs import BatteryConfig
from companion.config.plausibility import DOCK_WITHIN_M, judgements
from companion.config.vessel import VesselConfig, bundled, find, load
from companion.params.store import Parameters

REVOLT = load(find("revolt"))


def moved(boat: VesselConfig) -> VesselConfig:
    return replace(boat, thrusters=(replace(boat.thrusters[0], x_m=-3.0), *boat.thrusters[1:]))


def with_pair(boat: VesselConfig) -> VesselConfig:
    """Two receivers 0.4 m apart, whose positions are to give the heading."""
    gnss = boat.sensors[0]
    return replace(
        boat, sensors=(*boat.sensors, replace(gnss, name="fore", x_m=gnss.x_m + 0.4, heading_with=gnss.name))
    )


def with_one_antenna(boat: VesselConfig) -> VesselConfig:
    """As the lines of `companion devices` leave a boat whose inertial sensor is its compass, without their comment."""
    return replace(boat, sensors=tuple(replace(row, antennas=1) for row in boat.sensors))


@pytest.mark.parametrize(
    ("change", "text", "means"),
    [
        (
            lambda b: replace(b, hull=replace(b.hull, damping=DampingConfig(y_v=1.0, n_r=1.0))),
            "no damping of surge",
            "Miss",
        ),
        (lambda b: replace(b, hull=replace(b.hull, m11_kg=0.257)), "thrust of 194.6 m/s²", "Hold"),
        (lambda b: replace(b, limits=replace(b.limits, surge_n=2.0)), "thrust of only 0.008", "stronger than the boat"),
        (
            lambda b: replace(b, hull=replace(b.hull, damping=replace(b.hull.damping, x_u=5.0))),
            "hull speed",
            "Missions",
        ),
        (lambda b: replace(b, limits=replace(b.limits, yaw_nm=3000.0)), "turning circle", "Follow"),
        (
            lambda b: replace(b, hull=replace(b.hull, m22_kg=5000.0), parameters={"WP_SPEED": 0.9}),
            "the hull leaves its course faster than the thrusters",
            "Missions, RTL and Follow: it weaves. Set WP_SPEED to 0.",
        ),
        (moved, "'stern_port' at x -3 m", "its lever is wrong"),
        (with_pair, "a baseline of 0.40 m: one sigma of 4.1°", "no better than a compass"),
        (lambda b: replace(b, limits=replace(b.limits, sway_n=0.0)), "no sideways thrust", "Dock: refused"),
        (lambda b: replace(b, battery=BatteryConfig(10000.0, 12.8, 11.2)), "10000 mAh are 10 Ah", "no failsafe of the"),
        (lambda b: replace(b, battery=BatteryConfig(80.0, 12.8, 11.2, 20.0)), "20 mΩ are 0.02 Ω", "counts as full"),
        (
            lambda b: replace(b, actuators=(replace(b.actuators[0], timeout_s=800.0),)),
            "'microcontroller' counts as lost after 800 s: check it, in s; 800 ms are 0.8 s",
            "its silence goes unnoticed",
        ),
        (with_one_antenna, "no sensor is said to give a heading", "found by motion"),
    ],
)
def test_each_finding_says_what_it_means(change: Callable[[VesselConfig], VesselConfig], text: str, means: str) -> None:
    assert judgements(REVOLT) == []
    found = [str(judgement) for judgement in judgements(change(REVOLT))]
    assert any(text in line and means in line for line in found), found


def test_usual_batteries_are_plausible() -> None:
    for battery in (
        BatteryConfig(80.0, 12.8, 11.2, 0.02),
        BatteryConfig(0.85, 8.4, 6.4, 0.2),
        BatteryConfig(600.0, 53.0, 44.0),
    ):
        assert judgements(replace(REVOLT, battery=battery)) == []


@pytest.mark.parametrize("name", bundled())
def test_a_bundled_boat_is_plausible_but_for_axes_that_it_does_not_have(name: str) -> None:
    boat = load(find(name))
    assert all(found.place == ("limits", "sway_n") for found in judgements(boat)), name


@pytest.mark.parametrize("name", ["DP_ECON", "DP_WEATHERVANE", "ALLOC_ECON"])
def test_economy_that_a_boat_cannot_have_is_named(name: str) -> None:
    for vessel, effect in (("revolt", True), ("otter", False)):
        boat = replace(load(find(vessel)), parameters={name: 1.0})
        found = [str(judgement) for judgement in judgements(boat) if judgement.place == ("parameters", name)]
        assert any("has no effect" in text for text in found) is not effect


@pytest.mark.parametrize(("antennas", "rtcm", "within_m", "said"), [
    (1, False, None, 1), (1, False, 0.5, 0), (1, True, None, 0), (2, False, None, 0),
])  # fmt: skip
def test_a_dock_needs_a_receiver_that_is_sure_enough(
    antennas: Literal[1, 2], rtcm: bool, within_m: float | None, said: int
) -> None:
    sensors = tuple(replace(row, antennas=antennas, rtcm=rtcm) for row in REVOLT.sensors)
    parameters = {**REVOLT.parameters, **({} if within_m is None else {"DOCK_POS_ACC": within_m})}
    boat = replace(REVOLT, sensors=sensors, parameters=parameters)
    assert sum("Dock asks for a position within" in str(found) for found in judgements(boat)) == said
    assert Parameters({})["DOCK_POS_ACC"] == pytest.approx(DOCK_WITHIN_M)
