"""A trial's log becomes an overlay and a report: on the hull of `test_identify`, whose heading reads too much here."""

from __future__ import annotations

import math
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from companion.analysis import trial_identify
from companion.analysis.keeping import measured
from companion.analysis.log_reader import Log, open_log
from companion.analysis.trial_checks import DEAD_BAND
from companion.analysis.trial_identify import TrialIdentification, identify_trial
from companion.analysis.trial_report import write_report
from companion.cli.main import main
from companion.config.vessel import find, load
from tests.unit.analysis.test_identify import TRUE, lively, sailed

pytestmark = pytest.mark.sweep  # a fit takes some seconds; its parts have their own tests
HEADING_ERROR = 0.12
ANTENNA_M = 0.3  # further ahead than the file says
EVENTS = """t_s,time_unix_ns,severity,name,text
1.0,0,INFO,trial_runs,"Trial: 1/3 surge +60% coast, 17 min left"
31.0,0,INFO,trial_ran,"Trial: 1/3 done"
32.0,0,INFO,trial_runs,"Trial: 2/3 stopping, 16 min left"
70.0,0,INFO,trial_ran,"Trial: 2/3 at the circle"
71.0,0,INFO,trial_runs,"Trial: 3/3 positioning, 1 min left"
118.0,0,INFO,trial_ran,"Trial: 3/3 done"
"""


def misread(folder: Path) -> None:
    """The log as a heading that reads too much and an antenna that is elsewhere write it; with the columns of a place."""
    lines = (folder / "ticks.csv").read_text(encoding="utf-8").splitlines()
    names = lines[0].split(",")
    yaw, u, v, r = (names.index(name) for name in ("yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps"))
    c, s = math.cos(HEADING_ERROR), math.sin(HEADING_ERROR)
    rows = [lines[0] + ",north_m,east_m"]
    for line in lines[1:]:
        cells = line.split(",")
        true_u, true_v = float(cells[u]), float(cells[v]) + ANTENNA_M * float(cells[r])
        cells[yaw] = f"{math.remainder(float(cells[yaw]) + HEADING_ERROR, math.tau):.5f}"
        cells[u], cells[v] = f"{c * true_u + s * true_v:.4f}", f"{c * true_v - s * true_u:.4f}"
        rows.append(",".join([*cells, "0.0", "0.0"]))
    (folder / "ticks.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    (folder / "events.csv").write_text(EVENTS, encoding="utf-8")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    folder = tmp_path_factory.mktemp("trial")
    sailed(folder, lively(120))
    misread(folder)
    return open_log(folder)


@pytest.fixture(scope="module")
def found(log: Log) -> TrialIdentification:
    return identify_trial(log)


def test_the_hull_and_the_error_of_the_heading_are_found(found: TrialIdentification) -> None:
    hull = found.fit.hull
    assert (hull.m11_kg, hull.m22_kg, hull.m33_kgm2) == pytest.approx((240.0, 330.0, 300.0), rel=0.08)
    assert hull.damping.x_u == pytest.approx(TRUE.damping.x_u, rel=0.3)
    assert found.heading is not None and found.heading.counts
    assert found.heading.error_rad == pytest.approx(HEADING_ERROR, abs=0.02)


def test_what_the_log_says_beside_the_hull_comes_with_an_interval(found: TrialIdentification) -> None:
    checks = {check.name: check for check in found.checks}
    heading = checks["heading: reads too much by"]
    assert heading.differs and heading.value == pytest.approx(math.degrees(HEADING_ERROR), abs=1.2)
    assert found.values["antenna_ahead_m"] == pytest.approx(ANTENNA_M, abs=0.05)
    assert found.values["antenna_starboard_m"] == pytest.approx(0.0, abs=0.05)
    assert checks[DEAD_BAND].told or checks[DEAD_BAND].would
    assert all(check.text in found.text for check in found.checks)


def test_what_was_held_out_is_predicted_better(found: TrialIdentification) -> None:
    assert found.prediction is not None and found.better
    assert found.prediction.ratio < 0.75  # of the rest, most is the noise of the velocities
    assert found.prediction.axes_after[2] < 0.5 * found.prediction.axes_before[2]
    assert "of it)" in found.text and "phase margin" in found.text


def test_the_overlay_counts_once_it_is_accepted(found: TrialIdentification, tmp_path: Path) -> None:
    boat = tmp_path / "boat.toml"
    shutil.copyfile(find("revolt"), boat)
    before = load(boat)
    overlay = tmp_path / "boat.trial-2026-11-22.toml"
    overlay.write_text(found.overlay, encoding="utf-8")
    assert load(boat) == before
    assert main(["trial", "accept", str(overlay)]) == 0
    now = load(boat)
    assert now.hull.m11_kg == pytest.approx(found.fit.hull.m11_kg, rel=1e-3)
    assert now.thrusters[0].x_m == pytest.approx(found.fit.thrusters[0].x_m, rel=1e-2)
    assert now.sensors[0].heading_offset_rad == pytest.approx(-HEADING_ERROR, abs=0.02)
    assert now.parameters["DP_BW_YAW"] == next(d.value for d in found.designs if d.name == "DP_BW_YAW")


def test_the_report_is_one_page(found: TrialIdentification, tmp_path: Path) -> None:
    before = measured(found.log.folder, "before, measured")
    assert before is not None
    write_report(found, tmp_path / "trial.html", [before])
    page = (tmp_path / "trial.html").read_text(encoding="utf-8")
    for said in ("stopping distance", "95 % interval", "gain margin", "accepted = false", "RMS from the mean place"):
        assert said in page
    assert "src=" not in page and page.count("<svg") >= 1


def test_bandwidths_are_designed_for_the_thrust_that_was_found(
    log: Log, found: TrialIdentification, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The limits go into the overlay scaled, and the bandwidths were those of the limits before."""
    estimates = tuple(
        replace(one, value=0.25 * one.value) if one.name.startswith("scale") else one for one in found.fit.estimates
    )
    thrusters = tuple(replace(one, max_n=0.25 * one.max_n, min_n=0.25 * one.min_n) for one in found.fit.thrusters)
    weak = replace(found.fit, estimates=estimates, thrusters=thrusters)
    monkeypatch.setattr(trial_identify, "fit", lambda *_, **__: weak)
    monkeypatch.setattr(trial_identify, "prediction", lambda *_: found.prediction)
    before, now = ({d.name: d for d in one.designs} for one in (found, identify_trial(log)))
    assert now["DP_BW_SWAY"].limit == "thrust"
    assert now["DP_BW_SWAY"].value == pytest.approx(0.5 * before["DP_BW_SWAY"].value, rel=0.03)
    monkeypatch.setattr(trial_identify, "prediction", lambda *_: None)
    unjudged = identify_trial(log)
    assert not unjudged.better and "[hull]" not in unjudged.overlay
    assert any("too short to judge" in warning for warning in unjudged.warnings)
