"""Samples of the strips."""

from __future__ import annotations

import math

import pytest

from companion.console.strips import sample, series_of
from companion.record.feed_schema import TickEncoder
from tests.unit.record.ticks import tick


def test_a_sample_has_a_value_for_every_series() -> None:
    message = TickEncoder(("port", "bow"), ("gnss", "imu")).message(tick(3.0), 1, 0)
    message["more"]["judged"] = [{"sense": "position", "age_s": 0.1, "square": 4.0, "limit": 16.0, "accepted": True}]
    names = [series.name for series in series_of(("port", "bow"))]
    values = dict(zip(names, sample(message, ("port", "bow")), strict=True))
    assert values["position error"] == pytest.approx(0.5)
    assert values["heading error"] == pytest.approx(0.0, abs=1e-9)
    assert values["port"] == 60.0 and values["bow"] == -50.0
    assert values["position"] == 0.5  # half way to its gate
    assert values["heading"] is None and values["voltage"] is None
    assert values["silent"] == 1.0


def test_a_heading_error_goes_the_short_way() -> None:
    message = TickEncoder(("port", "bow"), ("gnss", "imu")).message(tick(3.0), 1, 0)
    message["row"] |= {"yaw_rad": math.radians(179.0), "desired_yaw_rad": math.radians(-179.0)}
    assert sample(message, ("port", "bow"))[2] == pytest.approx(-2.0)
