"""Charts of known obstacles, read from GeoJSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from companion.app import load_vessel
from companion.config.chart import ChartConfig, ChartError, ChartFeature, parse_chart, read_charts
from companion.config.vessel import ConfigError, find, load

SQUARE = {"type": "Polygon", "coordinates": [[[10.40, 63.44], [10.41, 63.44], [10.41, 63.45], [10.40, 63.44]]]}
POINT = {"type": "Point", "coordinates": [10.40, 63.44, -3.0]}
LINE = {"type": "LineString", "coordinates": [[10.40, 63.44], [10.41, 63.45]]}


def feature(geometry: Any = SQUARE, **properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def collection(*features: Any, **more: Any) -> bytes:
    return json.dumps({"type": "FeatureCollection", "features": list(features), **more}).encode()


def problems(content: bytes, kind: str | None = None) -> tuple[str, ...]:
    with pytest.raises(ChartError) as caught:
        parse_chart(content, "harbour.geojson", kind)
    return caught.value.problems


def only(row: Any, kind: str | None = None) -> ChartFeature:
    (found,) = parse_chart(collection(row), "harbour.geojson", kind)
    return found


@pytest.mark.parametrize(
    ("row", "kind", "radius_m", "depth_m"),
    [
        (feature(kind="land"), "land", 0.0, None),
        (feature(kind="depth", depth_m=2.5), "depth", 0.0, 2.5),
        (feature(POINT, kind="rock"), "rock", 2.0, None),
        (feature(POINT, kind="pile", radius_m=0.3), "pile", 0.3, None),
        (feature(LINE, kind="quay"), "quay", 0.5, None),
        (feature(OBJL=71), "land", 0.0, None),
        (feature(OBJL=42, DRVAL1=-0.5, DRVAL2=2.0), "depth", 0.0, -0.5),
        (feature(POINT, OBJL=153, VALSOU=1.8), "rock", 2.0, 1.8),
        (feature(POINT, OBJL=86, VALSOU=None), "obstruction", 2.0, None),
        (feature(LINE, OBJL=122), "quay", 0.5, None),
    ],
)
def test_features_are_read(row: Any, kind: str, radius_m: float, depth_m: float | None) -> None:
    found = only(row)
    assert (found.kind, found.radius_m, found.depth_m) == (kind, radius_m, depth_m)
    assert not found.geometry.has_z


def test_kind_of_the_chart_counts_for_features_without_one() -> None:
    assert only(feature(), "land").kind == "land"
    assert only(feature(POINT, kind="rock"), "land").kind == "rock"


def test_what_is_no_obstacle_is_left_out() -> None:
    rows = feature(POINT, OBJL=75), feature(None, OBJL=302)  # a light; the coverage of the chart
    assert parse_chart(collection(*rows), "harbour.geojson", None) == []


@pytest.mark.parametrize(
    ("kind", "depth_m", "least_m", "obstacle"),
    [
        ("land", None, 0.0, True),
        ("depth", 2.0, 0.0, False),
        ("depth", 2.0, 1.5, False),
        ("depth", 2.0, 2.5, True),
        ("depth", None, 0.0, False),
        ("depth", None, 1.0, True),
        ("depth", -0.5, 0.0, True),
        ("rock", None, 0.0, True),
        ("rock", 3.0, 0.0, True),
        ("rock", 3.0, 2.0, False),
        ("rock", 1.0, 2.0, True),
        ("pile", 9.0, 2.0, True),
    ],
)
def test_depth_decides_what_is_an_obstacle(kind: str, depth_m: float | None, least_m: float, obstacle: bool) -> None:
    properties = {"kind": kind} if depth_m is None else {"kind": kind, "depth_m": depth_m}
    assert only(feature(**properties)).is_obstacle(least_m) is obstacle


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"{", "not valid JSON"),
        (b"[]", "no FeatureCollection of GeoJSON; write it with ogr2ogr"),
        (b"[" * 100_000, "not valid JSON"),
        (
            collection(crs={"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25833"}}),
            "write it in WGS 84",
        ),
        (collection(feature(name="Skjer")), "feature 1 (Skjer): has no kind; give it a property 'kind'"),
        (collection(feature(kind="lnad")), "did you mean 'land'?"),
        (collection(feature(kind="depth", depth_m="2 m")), "depth_m is '2 m'; give a number"),
        (collection(feature(kind="rock", radius_m=-1.0)), "radius_m is -1; give 0 to 1000"),
        (collection(feature({"type": "Polygon", "coordinates": []}, kind="land")), "its geometry is empty"),
        (collection(feature({"type": "Blob"}, kind="land")), "its geometry cannot be read"),
        (
            collection(feature({"type": "Point", "coordinates": [570000.0, 7030000.0]}, kind="rock")),
            "outside longitude",
        ),
        (collection("rock"), "feature 1: is no Feature; remove it"),
    ],
)
def test_what_is_wrong_is_told_with_file_feature_and_remedy(content: bytes, says: str) -> None:
    (problem,) = problems(content)
    assert problem.startswith("harbour.geojson: ") and says in problem


def test_many_faults_are_cut_short() -> None:
    found = problems(collection(*(feature() for _ in range(30))))
    assert len(found) == 11 and "20 more features are wrong" in found[-1]


def test_size_is_bounded(tmp_path: Path) -> None:
    line = {"type": "LineString", "coordinates": [[10.0 + 1e-6 * i, 63.0] for i in range(20_001)]}
    (problem,) = problems(collection(feature(line, kind="quay")))
    assert "20001 corners, room for 20000" in problem and "-clipsrc" in problem
    large = tmp_path / "large.geojson"
    large.write_bytes(b" " * 20_000_001)
    with pytest.raises(ChartError, match="larger than 20 MB; cut it"):
        read_charts([ChartConfig(str(large))])


def boat_with_chart(folder: Path, rows: str) -> Path:
    text = find("otter").read_text(encoding="utf-8")
    file = folder / "boat.toml"
    file.write_text(f"{text}\n{rows}", encoding="utf-8")
    return file


def test_a_vessel_names_its_charts_from_its_own_folder(tmp_path: Path) -> None:
    (tmp_path / "land.geojson").write_bytes(collection(feature()))
    config = load(boat_with_chart(tmp_path, '[[chart]]\nfile = "land.geojson"\nkind = "land"\n'))
    assert config.charts == (ChartConfig(str(tmp_path / "land.geojson"), "land"),)
    assert [one.kind for one in read_charts(config.charts)] == ["land"]


def test_a_wrong_chart_is_told_with_its_place_in_the_vessels_file(tmp_path: Path) -> None:
    (tmp_path / "land.geojson").write_bytes(collection(feature(name="Skjer")))
    file = boat_with_chart(tmp_path, '[[chart]]\nfile = "land.geojson"\n\n[[chart]]\nfile = "gone.geojson"\n')
    with pytest.raises(ConfigError) as caught:
        load_vessel(str(file))
    first, second = caught.value.problems
    assert "boat.toml:" in first and "land.geojson: feature 1 (Skjer): has no kind" in first
    assert "gone.geojson: cannot be read: No such file" in second
