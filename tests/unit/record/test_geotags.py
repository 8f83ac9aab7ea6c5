"""geotags.csv: a row a picture, readable at any moment."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest

from companion.core.payload import Shot
from companion.record.geotags import COLUMNS
from companion.record.recorder import LogFolder
from tests.unit.record.ticks import tick

SHOT = Shot(5.0, 1, "below", 3, 4, 63.4401234, 10.4, 2.0, 0.01, -0.02, -math.pi / 2.0, 0.8, 0.05, 0.01)


def test_a_row_a_picture_in_degrees(tmp_path: Path) -> None:
    log = LogFolder(tmp_path, ["port"], [], {}, cameras=True)
    unknown = replace(SHOT, number=4, lat_deg=math.nan, lon_deg=math.nan, position_accuracy_m=math.inf)
    log.record(replace(tick(5.0), shots=(SHOT, unknown)))
    log.record(tick(5.1))
    with (tmp_path / "geotags.csv").open(encoding="utf-8") as rows:  # while it is written
        first, second = csv.DictReader(rows)
    assert tuple(first) == COLUMNS
    assert (first["camera"], first["image"], first["lat_deg"], first["heading_deg"]) == (
        "below",
        "3",
        "63.440123400",
        "270.000",
    )
    assert float(first["pitch_deg"]) == pytest.approx(math.degrees(-0.02), abs=1e-3)
    assert (second["lat_deg"], second["position_accuracy_m"], second["speed_mps"]) == ("", "", "0.800")
    log.close()


def test_a_boat_without_cameras_has_no_such_file(tmp_path: Path) -> None:
    LogFolder(tmp_path, ["port"], [], {}).close()
    assert not (tmp_path / "geotags.csv").exists()
