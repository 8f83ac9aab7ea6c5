"""The picture of Hold in waves, and the static balance that it is held against."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from companion.analysis.polar import wrench_against
from companion.config.vessel import find, load
from docs.generate.wave_balance import (
    FROM_BEAM,
    FROM_BOW,
    least_static_wind_mps,
    mean_drift,
    static_height_m,
    static_wind_mps,
)
from docs.generate.wave_curve import points, vessels, wave_curve


def row(boat: str, vessel: str, height: str, value: float) -> dict[str, object]:
    runs = [{"metrics": {"slow_rms_m": value + step, "thrust_percent": 10.0 * value}} for step in (-0.01, 0.01)]
    return {"label": f"{boat}, {height}", "runs": runs, "command": f"companion scenario run x --vessel {vessel}"}


ROWS = [
    row("ReVolt", "revolt", "0.2 m", 0.5),
    row("ReVolt", "revolt", "0.1 m", 0.1),
    row("ReVolt", "revolt", "0.1 m, no drift", 0.02),
    row("ÅBOAT", "aboat", "0.3 m", 0.2),
]


def test_rows_become_curves_with_drift_and_without() -> None:
    found = points(ROWS, "slow_rms_m")
    assert found[("ReVolt", True)] == [(0.1, pytest.approx(0.1)), (0.2, pytest.approx(0.5))]
    assert found[("ReVolt", False)] == [(0.1, pytest.approx(0.02))]
    assert vessels(ROWS) == {"ReVolt": "revolt", "ÅBOAT": "aboat"}


def test_it_is_whole_with_and_without_a_table(tmp_path: Path) -> None:
    file = tmp_path / "waves.json"
    bare = wave_curve(file)
    file.write_text(json.dumps({"rows": ROWS}), encoding="utf-8")
    drawn = wave_curve(file)
    for picture in (bare, drawn):
        assert "nan" not in picture
        ET.fromstring(picture)
    assert drawn.count("<polyline") == 4 and "mean drift up to 0.29 m" in drawn


def test_the_static_balance_is_where_the_drift_is_as_large_as_the_thrust() -> None:
    """ReVolt's limit sideways is what its thrusters give; bow on it meets far less drift."""
    vessel = load(find("revolt"))
    height_m = static_height_m("revolt", FROM_BEAM)
    drifts = [abs(mean_drift(vessel, f"{height_m:.4f}", FROM_BEAM, seed)[1]) for seed in range(4)]
    assert sum(drifts) / 4 == pytest.approx(vessel.limits.sway_n, rel=0.1)
    assert static_height_m("revolt", FROM_BOW) > 2.0 * height_m


def test_rough_water_balances_where_wind_and_waves_are_as_large_as_the_thrust() -> None:
    """With the waves that it raises, the wind that ReVolt balances is weaker than without; bow on it stands far more."""
    vessel = load(find("revolt"))
    beam_mps = static_wind_mps("revolt", FROM_BEAM)
    assert abs(wrench_against(vessel, beam_mps, FROM_BEAM).sway_n) < 0.8 * vessel.limits.sway_n
    assert abs(wrench_against(vessel, 2.0 * beam_mps, FROM_BEAM).sway_n) > vessel.limits.sway_n
    assert static_wind_mps("revolt", FROM_BOW) > 2.0 * beam_mps


def test_the_page_tells_the_balance_of_aboat() -> None:
    usual_mps, least_mps = static_wind_mps("aboat", FROM_BEAM), least_static_wind_mps("aboat", FROM_BEAM)
    page = (Path(__file__).parents[2] / "docs" / "inside" / "sea.md").read_text(encoding="utf-8")
    assert f"**ÅBOAT's limit** is {usual_mps:.1f} m/s" in page
    assert f"With wind areas 20 % larger than believed it is {least_mps:.1f} m/s" in page
