"""The heading of a boat without a compass, found by its motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame
from companion.core.readings import GroundVelocity, Heading, Imu, Reading
from companion.nav.estimator import Estimator
from companion.params.store import Parameters
from tests.unit.nav.boat_truth import Truth, Voyage, config_of, readings_of, sail

PUSHED = Voyage(speed_mps=0.0, to_and_fro_m=0.5, duration_s=45.0, seed=11)  # too slow for its course to tell anything
Alter = Callable[[Reading], Reading | None]


class Sailed:
    """What an estimator made of the voyage: a state every 0.1 s, and what it announced."""

    def __init__(self, voyage: Voyage, alter: Alter) -> None:
        config = config_of(voyage)
        self.truth: Truth = sail(voyage)
        self.states: list[NavState] = []
        self.said: list[tuple[TextKind, str]] = []
        estimator = Estimator(config, Parameters(), lambda t_s, kind, name, text: self.said.append((kind, text)))
        batch: list[Reading] = []
        frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
        for k, row in enumerate(readings_of(voyage, self.truth, frame)):
            batch += [reading for reading in map(alter, row) if reading is not None]
            if k % 10 == 0:
                self.states.append(estimator.update(batch, float(self.truth.t_s[k])))
                batch = []

    def error_rad(self, k: int) -> float:
        yaw = float(self.truth.attitude[10 * k, 2])
        return abs(math.remainder(self.states[k].yaw_rad - yaw, math.tau))

    @property
    def found(self) -> int | None:
        """The first state with a heading."""
        return next((k for k, state in enumerate(self.states) if state.heading_valid), None)


def no_heading(reading: Reading) -> Reading | None:
    return None if isinstance(reading, Heading) else reading


@pytest.mark.parametrize("yaw_rad", [0.0, 1.1, 3.0, -1.9])
def test_a_boat_that_is_pushed_to_and_fro_finds_its_heading(yaw_rad: float) -> None:
    boat = Sailed(replace(PUSHED, yaw_rad=yaw_rad), no_heading)
    found = boat.found
    assert found is not None and boat.states[found].t_s < 30.0
    for k in range(found, len(boat.states), 10):
        assert boat.states[k].heading_valid
        assert boat.error_rad(k) < 3.0 * boat.states[k].heading_accuracy_rad
    assert boat.error_rad(len(boat.states) - 1) < math.radians(5.0)
    assert (TextKind.ROUTINE, "Heading source: motion") in boat.said


def test_the_position_is_good_as_soon_as_the_heading_is_known() -> None:
    boat = Sailed(PUSHED, no_heading)
    assert boat.found is not None
    for k in range(boat.found + 5, len(boat.states), 10):
        place = boat.truth.position[10 * k]
        assert math.hypot(boat.states[k].north_m - place[0], boat.states[k].east_m - place[1]) < 0.15


def test_a_boat_that_lies_still_tells_nothing() -> None:
    """It rocks, but gains no way: every heading explains that."""
    assert Sailed(replace(PUSHED, to_and_fro_m=0.0), no_heading).found is None


def test_a_receiver_that_calls_slow_speeds_zero_tells_nothing() -> None:
    def standing(reading: Reading) -> Reading | None:
        if isinstance(reading, GroundVelocity):
            return replace(reading, north_mps=0.0, east_mps=0.0)
        return no_heading(reading)

    boat = Sailed(PUSHED, standing)
    assert boat.found is None


def test_no_search_beside_a_compass() -> None:
    boat = Sailed(replace(PUSHED, duration_s=20.0), lambda reading: reading)
    assert [text for _, text in boat.said if text.startswith("Heading source")] == ["Heading source: gnss"]


def test_a_compass_that_comes_later_takes_over() -> None:
    def late(reading: Reading) -> Reading | None:
        return None if isinstance(reading, Heading) and reading.t_s < 40.0 else reading

    boat = Sailed(PUSHED, late)
    assert [text for _, text in boat.said if text.startswith("Heading source")] == [
        "Heading source: motion",
        "Heading source: gnss",
    ]
    assert all(state.heading_valid for state in boat.states[400:])
    assert max(boat.error_rad(k) for k in range(450, len(boat.states))) < math.radians(1.0)


def test_a_gap_of_the_inertial_sensor_begins_the_search_anew() -> None:
    def broken(reading: Reading) -> Reading | None:
        return None if isinstance(reading, Imu) and 5.0 <= reading.t_s < 8.0 else no_heading(reading)

    boat = Sailed(PUSHED, broken)
    assert boat.found is not None and boat.states[boat.found].t_s > 8.0
    assert boat.error_rad(boat.found) < 3.0 * boat.states[boat.found].heading_accuracy_rad


def test_a_heading_that_is_lost_is_found_again() -> None:
    """The compass falls silent for good; then the gyro, too, for a while."""

    def silent(reading: Reading) -> Reading | None:
        if isinstance(reading, Imu):
            return None if 12.0 <= reading.t_s < 25.0 else reading
        return no_heading(reading) if reading.t_s > 10.0 else reading

    boat = Sailed(PUSHED, silent)
    lost = next(k for k, state in enumerate(boat.states) if k > 100 and not state.heading_valid)
    found = next(k for k, state in enumerate(boat.states) if k > lost and state.heading_valid)
    assert boat.states[found].t_s > 25.0
    for k in range(found, len(boat.states), 10):
        assert boat.states[k].heading_valid
        assert boat.error_rad(k) < 3.0 * boat.states[k].heading_accuracy_rad
