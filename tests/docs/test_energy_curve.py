"""The picture of accuracy against energy: a curve for each boat, from the measured table."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

from docs.generate.energy_curve import Point, curves, energy_curve


def row(label: str, rms_m: float, power: float) -> dict[str, object]:
    runs = [
        {"metrics": {"position_rms_m": rms_m + step, "power_percent": power, "variation_percent_ps": 0.5}}
        for step in (-0.01, 0.01)
    ]
    return {"label": label, "runs": runs}


ROWS = [
    row("A, wind 6 m/s, DP_ECON 0.5 m", 0.12, 2.0),
    row("A, wind 6 m/s, DP_ECON off", 0.06, 2.5),
    row("A, wind 4 m/s, heading free", 0.03, 0.2),
    row("B & C, DP_ECON 1 m", 0.2, 3.0),
]


def test_rows_of_a_circle_become_curves_in_its_order() -> None:
    found = curves(ROWS, "power_percent")
    assert list(found) == ["A, wind 6 m/s", "B & C"]
    assert found["A, wind 6 m/s"] == [Point(0.0, 0.06, 2.5), Point(0.5, 0.12, 2.0)]


def test_it_is_whole_with_and_without_a_table(tmp_path: Path) -> None:
    file = tmp_path / "endurance.json"
    bare = energy_curve(file)
    file.write_text(json.dumps({"rows": ROWS}), encoding="utf-8")
    drawn = energy_curve(file)
    for picture in (bare, drawn):
        assert "nan" not in picture
        ET.fromstring(picture)
    assert "ArduRover" in bare and "B &amp; C" in drawn
    assert drawn.count("<polyline") == 4
