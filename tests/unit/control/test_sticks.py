"""Sticks to wrench and to thrusters."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.cli.new_file import LAYOUTS, file_text
from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig, bundled, find, load, parse
from companion.control.manual import stick_to_thrusters, stick_to_wrench
from companion.core.actuation import ThrusterCommand, Wrench
from companion.params.store import Parameters
from tests.unit.config.test_strangers_mistakes import ANSWERS
from tests.unit.control.simple_boat import REVOLT

PARAMETERS = Parameters()


def wrench_of(config: VesselConfig, commands: tuple[ThrusterCommand, ...]) -> tuple[float, float, float]:
    x = y = n = 0.0
    for t, command in zip(config.thrusters, commands, strict=True):
        azimuth = t.azimuth_rad if command.azimuth_rad is None else command.azimuth_rad
        c, s = math.cos(azimuth), math.sin(azimuth)
        x, y, n = x + c * command.force_n, y + s * command.force_n, n + (t.x_m * s - t.y_m * c) * command.force_n
    return x, y, n


def of_layout(layout: str) -> VesselConfig:
    """A boat of `companion new`."""
    answers = replace(ANSWERS, form="planing" if layout == "jet" else "monohull", hull_beam_m=None, layout=layout)
    return parse(file_text(answers), "boat.toml")


BOATS = {**{name: load(find(name)) for name in bundled()}, **{layout: of_layout(layout) for layout in LAYOUTS}}


def fixed(name: str, x_m: float, y_m: float, azimuth_deg: float) -> ThrusterConfig:
    return ThrusterConfig(name, "fixed", x_m, y_m, 20.0, -20.0, 20.0, 20.0, 50.0, math.radians(azimuth_deg))


def test_full_stick_is_the_limit_and_the_dead_band_is_dead() -> None:
    assert stick_to_wrench(1.0, -1.0, 1.0, REVOLT, PARAMETERS) == Wrench(
        50.0, -REVOLT.limits.sway_n, REVOLT.limits.yaw_nm
    )
    assert stick_to_wrench(0.05, -0.04, math.nan, REVOLT, PARAMETERS) == Wrench(0.0, 0.0, 0.0)
    assert stick_to_wrench(0.525, 0.0, 0.0, REVOLT, PARAMETERS).surge_n == pytest.approx(25.0, rel=1e-6)
    assert stick_to_wrench(9.0, 0.0, 0.0, REVOLT, PARAMETERS).surge_n == 50.0


def test_revolt_turns_its_stern_pods_by_45_degrees() -> None:
    port, starboard, bow = stick_to_thrusters(0.5, 0.0, 1.0, REVOLT, PARAMETERS)
    assert port.azimuth_rad == starboard.azimuth_rad == pytest.approx(math.radians(-45.0))
    assert port.throttle == starboard.throttle == pytest.approx(0.45 / 0.95)
    assert port.force_n == pytest.approx(27.0 * port.throttle**2)
    assert bow.throttle == 0.0 and bow.azimuth_rad is None


@pytest.mark.parametrize("surge", [0.6, -0.6])
@pytest.mark.parametrize("yaw", [0.8, -0.8])
def test_the_yaw_stick_turns_the_boat_the_same_way_ahead_and_astern(surge: float, yaw: float) -> None:
    x, _, n = wrench_of(REVOLT, stick_to_thrusters(surge, 0.0, yaw, REVOLT, PARAMETERS))
    assert x * surge > 0.0 and n * yaw > 0.0


def test_sway_drives_the_bow_thruster() -> None:
    _, _, bow = stick_to_thrusters(0.0, 1.0, 0.0, REVOLT, PARAMETERS)
    assert bow.throttle == 1.0 and bow.force_n == 14.0


def test_two_fixed_propellers_steer_by_difference() -> None:
    twin = replace(REVOLT, thrusters=(fixed("port", -1.0, -0.4, 0.0), fixed("starboard", -1.0, 0.4, 0.0)))
    port, starboard = stick_to_thrusters(0.0, 0.0, 0.5, twin, PARAMETERS)
    assert port.throttle > 0.0 > starboard.throttle
    assert wrench_of(twin, (port, starboard))[2] > 0.0


def test_side_thrusters_steer_where_nothing_else_does() -> None:
    boat = replace(
        REVOLT,
        thrusters=(fixed("main", -1.0, 0.0, 0.0), fixed("bow", 1.0, 0.0, 90.0), fixed("stern", -1.0, 0.0, -90.0)),
    )
    assert wrench_of(boat, stick_to_thrusters(0.0, 0.0, 0.5, boat, PARAMETERS))[2] > 0.0
    x, y, _ = wrench_of(boat, stick_to_thrusters(0.0, 0.5, 0.0, boat, PARAMETERS))
    assert x == pytest.approx(0.0, abs=1e-9) and y > 0.0


@pytest.mark.parametrize("name", BOATS)
def test_the_throttle_drives_every_boat_straight_ahead_and_the_yaw_stick_turns_it(name: str) -> None:
    boat = BOATS[name]
    x, y, n = wrench_of(boat, stick_to_thrusters(0.6, 0.0, 0.0, boat, PARAMETERS))
    assert x > 0.0 and abs(y) < 1e-6 * x and abs(n) < 1e-6 * x
    for yaw in (-0.5, 0.5):
        turned = wrench_of(boat, stick_to_thrusters(0.6, 0.0, yaw, boat, PARAMETERS))
        assert turned[0] > 0.0 and turned[2] * yaw > 0.0


def vectored(azimuth_deg: float) -> VesselConfig:
    """As of `companion new --layout vectored`, those at the stern mounted the other way round."""
    return replace(
        REVOLT,
        thrusters=tuple(
            fixed(f"{x}{y}", x * 0.6, y * 0.4, -x * y * azimuth_deg + (0.0 if x > 0 else 180.0))
            for x in (1, -1)
            for y in (1, -1)
        ),
    )


@pytest.mark.parametrize("azimuth_deg", [30.0, 45.0, 60.0])
@pytest.mark.parametrize("stick", [1.0, 0.4, -1.0])
def test_each_stick_moves_a_vectored_boat_its_own_way_alone(azimuth_deg: float, stick: float) -> None:
    """At 45° they counted as side thrusters: the throttle did nothing in Manual."""
    boat = vectored(azimuth_deg)
    for axis in range(3):
        sticks = [0.0, 0.0, 0.0]
        sticks[axis] = stick
        wrench = wrench_of(boat, stick_to_thrusters(*sticks, boat, PARAMETERS))
        assert wrench[axis] * stick > 0.0
        assert all(abs(force) < 1e-9 for k, force in enumerate(wrench) if k != axis)


def test_two_toed_in_propellers_steer_by_difference() -> None:
    """Without sideways thrust the sway stick does nothing: it would turn the boat."""
    boat = replace(
        REVOLT,
        thrusters=(fixed("port", -1.0, -0.4, 25.0), fixed("starboard", -1.0, 0.4, -25.0)),
        limits=replace(REVOLT.limits, sway_n=0.0),
    )
    x, y, n = wrench_of(boat, stick_to_thrusters(0.5, 0.0, 0.0, boat, PARAMETERS))
    assert x > 0.0 and y == pytest.approx(0.0, abs=1e-9) and n == pytest.approx(0.0, abs=1e-9)
    assert wrench_of(boat, stick_to_thrusters(0.0, 1.0, 0.0, boat, PARAMETERS)) == (0.0, 0.0, 0.0)


def test_no_command_exceeds_full_throttle() -> None:
    for surge in (-1.0, 0.3, 1.0):
        for yaw in (-1.0, 1.0):
            assert all(abs(c.throttle) <= 1.0 for c in stick_to_thrusters(surge, 1.0, yaw, REVOLT, PARAMETERS))


def test_a_jet_steers_by_its_nozzle_and_cannot_push_astern() -> None:
    vessel = load(find("rescuerunner"))
    (ahead,) = stick_to_thrusters(0.525, 0.0, 1.0, vessel, PARAMETERS)
    assert ahead.throttle == pytest.approx(0.5, rel=1e-6) and ahead.azimuth_rad == pytest.approx(math.radians(-24.0))
    assert wrench_of(vessel, (ahead,))[2] > 0.0, "yaw to starboard turns to starboard"
    (astern,) = stick_to_thrusters(-1.0, 0.0, 1.0, vessel, PARAMETERS)
    assert astern.throttle == 0.0 and astern.azimuth_rad == ahead.azimuth_rad
