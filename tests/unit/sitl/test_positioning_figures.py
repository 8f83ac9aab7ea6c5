"""The thesis's metrics on motions whose figures are known."""

from __future__ import annotations

import math

import pytest

from sitl.scenarios.positioning import PositioningLog, ThrusterFigures, energy, figures, iadc, iae

POD = ThrusterFigures("pod", 20.0, -1.0, 0.0)
FIXED = ThrusterFigures("bow", 10.0, 1.0, 0.0)


def sailed(count: int = 101) -> PositioningLog:
    """10 s: 0.3 m north and 0.4 m east off, 5° off across the turn; pod at half thrust, its throttle and azimuth
    ramping past 180°."""
    truth, ticks = [], []
    for k in range(count):
        t = 0.1 * k
        truth.append(
            {
                "t_s": t,
                "north_m": 1.3,
                "east_m": 2.4,
                "yaw_rad": math.radians(-178.0),
                "pod_force_n": -10.0,
                "bow_force_n": 0.0,
            }
        )
        ticks.append(
            {
                "t_s": t,
                "desired_north_m": 1.0,
                "desired_east_m": 2.0,
                "desired_yaw_rad": math.radians(177.0),
                "pod_throttle": 0.01 * k,
                "bow_throttle": 0.5 * (-1) ** k,
                "pod_azimuth_rad": math.remainder(math.radians(170.0 + 0.9 * k), math.tau),
                "bow_azimuth_rad": math.nan,
            }
        )
    return PositioningLog(truth, ticks)


def test_iae_is_the_normalised_error_over_time() -> None:
    assert iae(sailed())[-1] == pytest.approx(10.0 * math.hypot(0.5 / 5.0, 5.0 / 50.0), rel=1e-9)


def test_iadc_is_what_throttles_and_azimuths_travel() -> None:
    assert iadc(sailed(), [POD])[-1] == pytest.approx(1.0 + 1.0, rel=1e-9), "full throttle once, 90 degrees once"
    assert iadc(sailed(), [POD, FIXED])[-1] == pytest.approx(2.0 + 100.0, rel=1e-9)


def test_energy_is_in_seconds_of_full_power() -> None:
    assert energy(sailed(), [POD, FIXED])[-1] == pytest.approx(10.0 * 0.5**1.5 / 2.0, rel=1e-9)


def test_the_figures_take_the_largest_errors() -> None:
    found = figures(sailed(), [POD, FIXED])
    assert (found["north_max_m"], found["east_max_m"], found["heading_max_deg"]) == pytest.approx((0.3, 0.4, 5.0))
    assert found["position_rms_m"] == pytest.approx(0.5)
