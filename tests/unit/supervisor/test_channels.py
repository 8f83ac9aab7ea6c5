"""Channels of the transmitter as its calibration gives them."""

from __future__ import annotations

import math

import pytest

from companion.core.readings import RcInput
from companion.params.store import Parameters
from companion.supervisor.channels import calibrated


def value(pulse_us: float, **parameters: float) -> float:
    """Of channel 2 at that pulse."""
    rc = RcInput(1.0, "rc", (0.0, (pulse_us - 1500.0) / 500.0), lost=False)
    out = calibrated(rc, Parameters({f"RC2_{name}": number for name, number in parameters.items()}))
    assert out is not None and out.channels[0] == 0.0
    return out.channels[1]


def test_by_default_a_channel_is_its_pulse() -> None:
    assert [value(us) for us in (800, 1000, 1250, 1500, 1750, 2000, 2200)] == pytest.approx(
        [-1.0, -1.0, -0.5, 0.0, 0.5, 1.0, 1.0]
    )


def test_ends_centre_and_dead_zone() -> None:
    worn = {"MIN": 1100.0, "TRIM": 1520.0, "MAX": 1900.0, "DZ": 20.0}
    pulses = (1000, 1100, 1300, 1500, 1520, 1540, 1720, 1900, 2000)
    assert [value(us, **worn) for us in pulses] == pytest.approx([-1.0, -1.0, -0.5, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0])
    assert value(1900, **worn, REV=-1.0) == -1.0 and value(1100, **worn, REV=-1.0) == 1.0


def test_a_throttle_as_qgroundcontrol_calibrates_it_gives_ahead_only() -> None:
    """It writes the low end as the trim."""
    low = {"MIN": 1000.0, "TRIM": 1000.0}
    assert [value(us, **low) for us in (990, 1000, 1500, 2000)] == pytest.approx([0.0, 0.0, 0.5, 1.0])


def test_nothing_to_calibrate() -> None:
    assert calibrated(None, Parameters()) is None
    rc = RcInput(1.0, "rc", (math.nan, *[0.3] * 9), lost=True)
    out = calibrated(rc, Parameters())
    assert out is not None and math.isnan(out.channels[0]) and out.channels[8:] == (0.3, 0.3) and out.lost
