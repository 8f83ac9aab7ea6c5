"""The page of speed and growth, and its pictures."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from docs.generate.speed import further, growth, relative, speed_page, speed_trend


def commit(name: str, arithmetic: str, **speeds: float) -> dict[str, object]:
    return {"commit": name, "arithmetic": arithmetic, "speeds": speeds}


COMMITS = [
    commit("aaa", "interpreted", tick=2.0),
    commit("bbb", "interpreted", tick=3.0, follow=5.0),
    commit("bbb", "compiled", tick=6.0),
]
AXES = [
    {
        "name": "Links & all",
        "size_is": "links",
        "cost_is": "ms a tick",
        "points": [[0, 1.0, 0.5], [4, 1.2, 0.6], [16, 1.8, 0.9]],
        "commit": "bbb",
        "arithmetic": "interpreted",
    }
]

BOUNDS = """
text = "Measured so."
figure = [{ what = "start", before = "2 s", now = "1 s", aim = "0.5 s", bound = "imports" }]
shares = [{ of = "A tick:", columns = ["share"], rows = [["plant", "12 %"]] }]
"""


def test_speeds_are_multiples_of_the_oldest_commit_of_their_arithmetic() -> None:
    assert relative(COMMITS) == {
        ("tick", "interpreted"): [("aaa", 1.0), ("bbb", 1.5)],
        ("follow", "interpreted"): [("bbb", 1.0)],
        ("tick", "compiled"): [("bbb", 1.0)],
    }


@pytest.mark.parametrize(
    ("points", "each", "shape"),
    [
        ([(10, 1.0), (100, 1.01), (1000, 1.05)], 0.04 / 900, "flat"),
        ([(1, 1.0), (2, 2.0), (4, 4.0)], 1.0, "straight"),
        ([(1, 1.0), (2, 2.0), (4, 6.0)], 2.0, "steeper"),
        ([(1, 3.0), (2, 2.9), (4, 6.0)], 1.55, "steeper"),
    ],
)
def test_a_line_is_judged_by_its_last_stretch(points: list[tuple[float, float]], each: float, shape: str) -> None:
    assert further(points) == (pytest.approx(each), shape)


def test_the_page_is_whole_with_and_without_figures(tmp_path: Path) -> None:
    speeds, sizes = tmp_path / "speed.json", tmp_path / "growth.json"
    bounds = tmp_path / "bounds.toml"
    assert "|" not in speed_page(speeds, sizes, bounds)
    bare = [speed_trend(speeds), growth(sizes)]
    speeds.write_text(json.dumps({"commits": COMMITS}), encoding="utf-8")
    sizes.write_text(json.dumps({"axes": AXES}), encoding="utf-8")
    drawn = [speed_trend(speeds), growth(sizes)]
    for picture in (*bare, *drawn):
        assert "nan" not in picture
        ET.fromstring(picture)
    assert [picture.count("<polyline") for picture in drawn] == [3, 1]
    bounds.write_text(BOUNDS, encoding="utf-8")
    text = speed_page(speeds, sizes, bounds)
    assert "| start | 2 s | 1 s | 0.5 s | imports |" in text and "| plant | 12 % |" in text
    assert "aaa 1.00, bbb 1.50" in text and "| Links & all | links |" in text and "| straight |" in text
