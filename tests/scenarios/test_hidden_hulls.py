"""Boats that differ from their file by up to half, in wind and current: see `hidden_hulls`.

The normal suite sails the motor check of three of them, right and with mistakes of wiring. `make scenarios` sails all
twenty through everything.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from companion.config.vessel import VesselConfig
from companion.modes.trial.expectation import expected
from sitl.hidden_hull import HiddenHull, hidden_hull
from tests.scenarios.hidden_hulls import Weather, sail_seed, sail_trial

STRONG = Weather("6", 0.4)


def with_mistake(boat: HiddenHull, mistake: str) -> VesselConfig:
    """The boat with its first thruster turned round, its first two swapped, its compass turned by 90°, or its
    rudder turned by the wrong side of its servo."""
    real = boat.real
    first, *rest = real.thrusters
    if mistake == "reversed":
        return replace(real, thrusters=(replace(first, azimuth_rad=first.azimuth_rad + math.pi), *rest))
    if mistake == "rudder":
        assert first.rudder is not None
        turned = replace(first.rudder, lift_scale=-first.rudder.lift_scale)
        return replace(real, thrusters=(replace(first, rudder=turned), *rest))
    if mistake == "swapped":
        second, *others = rest
        return replace(
            real,
            thrusters=(
                replace(first, x_m=second.x_m, y_m=second.y_m),
                replace(second, x_m=first.x_m, y_m=first.y_m),
                *others,
            ),
        )
    sensors = [replace(sensor, heading_offset_rad=sensor.heading_offset_rad - math.pi / 2) for sensor in real.sensors]
    return replace(real, sensors=tuple(sensors))


@pytest.mark.parametrize(
    ("seed", "mistake", "said"),
    [
        (1, "swapped", "Trial: port and starboard swapped"),
        (5, "reversed", "Trial: port reversed"),
        (13, "compass", "Trial: compass +90 deg off"),
        (3, "rudder", "Trial: rudder of propeller reversed"),
        (8, "rudder", "Trial: rudder of propeller reversed"),
        (20, "rudder", "Trial: rudder of port reversed"),
    ],
)
def test_a_mistake_of_wiring_is_named_in_the_first_minute(seed: int, mistake: str, said: str, tmp_path: Path) -> None:
    boat = hidden_hull(seed)
    sailed = sail_trial(boat, with_mistake(boat, mistake), tmp_path, 60.0)
    assert said in sailed.texts and sailed.seconds < 60.0
    assert "Trial: no thrust: correct the file or the wires" in sailed.texts


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(20))
def test_a_hidden_hull_sails_as_typed_and_better_after_a_trial(
    seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Hold, a square and RTL work at once. The trial ends by itself, in time and near its circle. What it found, accepted
    by command, keeps control, too, and predicts better than what was typed."""
    found = sail_seed(seed, tmp_path)
    with capsys.disabled():
        print(f"\n{found.line}")
    assert found.typed is not None and found.trial is not None and found.after is not None
    assert not found.typed.lost
    assert found.trial.mode == "Hold" and found.trial.seconds <= expected(found.boat.known).budget_s
    assert found.lengths <= 1.0
    assert "Trial: accepted; reboot to use the new model" in found.trial.texts
    assert found.identified is not None and found.identified.prediction is not None
    assert found.identified.prediction.ratio < 1.0
    assert not found.after.lost


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(20))
def test_a_trial_stays_in_its_circle_in_strong_wind_and_current(seed: int, tmp_path: Path) -> None:
    """6 m/s of wind and a current of 40 % of the top speed."""
    found = sail_seed(seed, tmp_path, ("trial",), STRONG)
    assert found.lengths <= 1.0
