"""Station keeping out of a log: of a Trial's positioning, or of the longest time in Hold."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.analysis.keeping import kept, measured
from tests.unit.analysis.test_trial_identify import EVENTS


def written(folder: Path, events: str = "") -> Path:
    """0 to 200 s: a circle of 2 m around a point 10 m north; Hold from 50 s to 180 s, with a heading of ±0.1 rad."""
    rows = ["t_s,mode,armed,north_m,east_m,yaw_rad"]
    for k in range(2000):
        t_s = 0.1 * k
        mode = "Hold" if 50.0 <= t_s < 180.0 else "Manual"
        yaw = math.pi + (0.1 if k % 2 else -0.1)  # across the seam of ±π
        rows.append(
            f"{t_s:.1f},{mode},1,{10.0 + 2.0 * math.cos(t_s):.4f},{2.0 * math.sin(t_s):.4f},"
            f"{math.remainder(yaw, math.tau):.4f}"
        )
    (folder / "ticks.csv").write_text("\n".join([*rows, "200.0,Ho"]), encoding="utf-8")
    if events:
        (folder / "events.csv").write_text(events, encoding="utf-8")
    return folder


def test_the_longest_hold_counts_without_its_beginning(tmp_path: Path) -> None:
    found = measured(written(tmp_path), "after")
    assert found is not None and found.how == "after" and found.seconds == pytest.approx(100.0)
    assert found.rms_m == pytest.approx(2.0, abs=0.05) and found.within_m == pytest.approx(2.0, abs=0.1)
    assert found.heading_rms_rad == pytest.approx(0.1, abs=1e-3)


def test_of_a_trial_the_first_point_of_positioning_counts(tmp_path: Path) -> None:
    found = measured(written(tmp_path, EVENTS), "before")
    assert found is not None and found.seconds == pytest.approx(35.0)


def test_a_log_without_either_says_nothing(tmp_path: Path) -> None:
    (tmp_path / "ticks.csv").write_text("t_s,mode,armed,north_m,east_m,yaw_rad\n0.0,Hold,1,0,0,0\n")
    assert measured(tmp_path, "after") is None
    assert kept(tmp_path / "ticks.csv", "after", 5.0, 6.0) is None
