"""Counting of charge, against the simulated battery, which keeps energy, and against an integral in closed form."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.outputs import BatteryConfig
from companion.core.readings import Battery
from companion.nav.charge import ChargeCounter
from sitl.battery import BatteryModel

LEAD = BatteryConfig(capacity_ah=75.0, full_v=12.8, empty_v=11.2, resistance_ohm=0.02)


def reading(
    t_s: float, current_a: float | None, voltage_v: float = 12.0, remaining: float | None = None, source: str = "board"
) -> Battery:
    return Battery(t_s, source, voltage_v, current_a, remaining)


def test_the_charge_of_the_simulated_battery_is_tracked_from_half_to_nearly_empty() -> None:
    """900 Wh at 12 V are 75 Ah; the model draws power, so amperes weigh a little more at the end."""
    model, counter = BatteryModel(900.0, used=0.5), ChargeCounter(LEAD)
    for t_s in range(0, 3900, 2):
        power_w = 400.0 + 300.0 * math.sin(t_s / 60.0)
        model.step(power_w, 2.0)
        counted = counter.update(reading(float(t_s), model.current_a, model.voltage_v)).remaining
        assert counted == pytest.approx(model.remaining, abs=0.02)
    assert model.remaining < 0.05


def test_a_ramp_of_current_is_integrated_exactly_however_it_is_sampled() -> None:
    for times in (range(0, 3601, 10), (0, 7, 1800, 3599, 3600)):
        counter, share = ChargeCounter(LEAD), None
        for t_s in times:
            share = counter.update(reading(float(t_s), 30.0 * t_s / 3600.0, voltage_v=12.8)).remaining
        assert share == pytest.approx(1.0 - 15.0 / 75.0, abs=1e-9)


def test_the_first_share_follows_from_the_voltage_at_rest() -> None:
    assert ChargeCounter(LEAD).update(reading(0.0, 20.0, voltage_v=11.6)).remaining == pytest.approx(0.5)
    assert ChargeCounter(LEAD).update(reading(0.0, 0.0, voltage_v=14.4)).remaining == 1.0
    assert ChargeCounter(LEAD).update(reading(0.0, 0.0, voltage_v=9.0)).remaining == 0.0


def test_charging_raises_it_to_full_and_no_further() -> None:
    counter = ChargeCounter(LEAD)
    for hour in range(4):
        share = counter.update(reading(3600.0 * hour, -30.0, voltage_v=12.6)).remaining
    assert share == 1.0
    assert counter.update(reading(4 * 3600.0, 30.0)).remaining == 1.0  # half an hour in, half an hour out
    assert counter.update(reading(4 * 3600.0 + 1800.0, 30.0)).remaining == pytest.approx(0.8)


def test_readings_with_a_charge_or_without_a_current_stay_as_they_are() -> None:
    counter = ChargeCounter(LEAD)
    for battery in (reading(0.0, 5.0, remaining=0.3), reading(1.0, None), reading(2.0, math.nan)):
        assert counter.update(battery) is battery
    assert ChargeCounter(None).update(reading(0.0, 5.0)).remaining is None


def test_sources_are_counted_separately_and_time_going_back_discharges_nothing() -> None:
    counter = ChargeCounter(replace(LEAD, resistance_ohm=0.0))
    counter.update(reading(0.0, 75.0, 12.8))
    counter.update(reading(0.0, 0.0, 12.0, source="other"))
    assert counter.update(reading(360.0, 75.0)).remaining == pytest.approx(0.9)
    assert counter.update(reading(100.0, 75.0)).remaining == pytest.approx(0.9)
    assert counter.update(reading(360.0, 0.0, source="other")).remaining == pytest.approx(0.5)
