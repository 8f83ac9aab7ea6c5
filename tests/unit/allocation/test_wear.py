"""What the thrusters' wear counts."""

from __future__ import annotations

import math

import pytest

from companion.allocation.wear import Wear, WearCount
from companion.core.actuation import ActuatorCommand, ThrusterCommand

DT_S = 0.1


def counted(*throttles: float, armed: bool = True, azimuths_rad: tuple[float, ...] = ()) -> Wear:
    count = WearCount(["bow"], {})
    for k, throttle in enumerate(throttles):
        azimuth_rad = azimuths_rad[k] if azimuths_rad else None
        count.update(ActuatorCommand(k * DT_S, armed, (ThrusterCommand(0.0, throttle, azimuth_rad),)), DT_S)
    return count.by_name["bow"]


@pytest.mark.parametrize(
    ("throttles", "starts", "reversals"),
    [
        ((0.0, 0.0), 0, 0),
        ((0.5, 0.5, 0.0, 0.5), 2, 0),
        ((0.5, -0.5, 0.5), 1, 2),
        ((0.5, 0.0, -0.5), 2, 1),
        ((0.5, 0.01, -0.01, 0.5), 2, 0),
    ],
)
def test_starts_and_reversals(throttles: tuple[float, ...], starts: int, reversals: int) -> None:
    wear = counted(*throttles)
    assert (wear.starts, wear.reversals) == (starts, reversals)
    assert wear.thrust_s == pytest.approx(DT_S * sum(abs(one) > 0.02 for one in throttles))


def test_azimuth_travel_goes_the_short_way_past_astern_and_counts_to_and_fro() -> None:
    wear = counted(0.0, 0.0, 0.0, azimuths_rad=(math.radians(175.0), math.radians(-175.0), math.radians(175.0)))
    assert wear.azimuth_turns == pytest.approx(20.0 / 360.0)
    assert wear.starts == 0


def test_disarmed_it_stands_still() -> None:
    assert counted(0.5, -0.5, 0.5, armed=False) == Wear()


def test_it_goes_on_from_what_was_kept() -> None:
    count = WearCount(["bow", "stern"], {"stern": Wear(10.0, 3, 2, 1.5)})
    assert count.by_name == {"bow": Wear(), "stern": Wear(10.0, 3, 2, 1.5)}
    full = ThrusterCommand(10.0, 1.0, None)
    count.update(ActuatorCommand(0.0, True, (full, full)), DT_S)
    assert count.by_name["stern"] == Wear(10.0 + DT_S, 4, 2, 1.5)
