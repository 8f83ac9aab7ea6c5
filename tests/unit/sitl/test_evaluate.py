"""Figures of tracks whose answers are known by hand."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest

from companion.cli.main import main
from companion.config.vessel import HomeConfig, as_dict, find, load, with_home
from companion.core.geodesy import LocalFrame
from companion.mission import files
from sitl.evaluate.figures import hold, regular, route, route_metrics
from sitl.evaluate.table import table

BLUEBOAT = load(find("blueboat"))


def track(
    seconds: float, place: Callable[[float], tuple[float, float]], rate_hz: float = 20.0, share: float = 0.25
) -> list[dict[str, float]]:
    rows = []
    for i in range(round(seconds * rate_hz) + 1):
        north_m, east_m = place(i / rate_hz)
        row = {"t_s": i / rate_hz, "north_m": north_m, "east_m": east_m, "yaw_rad": 0.1}
        rows.append(row | {f"{thruster.name}_force_n": share * thruster.max_n for thruster in BLUEBOAT.thrusters})
    return rows


def values(figures: list[object]) -> dict[str, float]:
    return {figure.name: figure.value for figure in figures}  # type: ignore[attr-defined]


def test_a_circle_round_the_point_is_its_radius() -> None:
    found = values(hold(track(60.0, lambda t: (math.cos(t), math.sin(t))), BLUEBOAT, (0.0, 0.0), 0.0))  # type: ignore[arg-type]
    assert found["position, RMS"] == pytest.approx(1.0) and found["position, largest"] == pytest.approx(1.0)
    assert found["heading, RMS"] == pytest.approx(math.degrees(0.1))
    assert found["mean power"] == pytest.approx(100.0 * 0.25**1.5) and found["thrust variation"] == 0.0


@pytest.mark.parametrize("rate_hz", [10.0, 20.0, 100.0])
def test_the_rate_of_the_log_does_not_matter(rate_hz: float) -> None:
    rows = track(30.0, lambda t: (0.1 * t, 0.0), rate_hz)
    for row in rows:
        row["port_force_n"] = 35.0 * math.sin(row["t_s"])
    assert len(regular(rows)) == 301
    found = values(hold(rows, BLUEBOAT, None, None))  # type: ignore[arg-type]
    mean_slope = 2.0 / math.pi
    assert found["thrust variation"] == pytest.approx(100.0 * mean_slope / 2.0, rel=0.02)


def along(t: float) -> tuple[float, float]:
    """30 m north at 1 m/s, 0.2 m off the line, then 30 m east, 0.2 m off."""
    return (t, 0.2) if t <= 30.2 else (30.2, t - 30.0)


def test_a_route_beside_its_legs() -> None:
    found = values(route(track(70.0, along), BLUEBOAT, [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0)], 2.0))  # type: ignore[arg-type]
    assert found["cross-track on legs alone, RMS"] == pytest.approx(0.2, abs=0.01)
    assert found["worst miss of a waypoint passed"] == pytest.approx(0.2, abs=0.08)
    assert found["time"] == pytest.approx(57.6, abs=0.3)


def test_a_scenarios_metrics_are_the_figures_of_its_route() -> None:
    rows, waypoints = track(70.0, along), [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0)]
    found, figures = route_metrics(rows, BLUEBOAT, waypoints), values(route(rows, BLUEBOAT, waypoints, 2.0))  # type: ignore[arg-type]
    assert found["legs_rms_m"] == figures["cross-track on legs alone, RMS"] == pytest.approx(0.2, abs=0.01)
    assert found["route_miss_m"] == figures["worst miss of a waypoint passed"]
    assert found["route_time_s"] == figures["time"]
    assert route_metrics(rows, BLUEBOAT, [*waypoints, (60.0, 30.0)]) == {}, "never near the last waypoint"
    assert "legs_rms_m" not in route_metrics(rows, BLUEBOAT, [(0.0, 0.0), (4.0, 0.0)]), "all of it is corner"


def test_a_waypoint_that_is_not_reached_is_named() -> None:
    with pytest.raises(ValueError, match="waypoint 2 was not reached within 2 m"):
        route(track(40.0, along), BLUEBOAT, [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0)], 2.0)


def write(folder: Path, rows: list[dict[str, float]]) -> Path:
    folder.mkdir()
    lines = [",".join(rows[0]), *(",".join(f"{value:.5f}" for value in row.values()) for row in rows)]
    (folder / "truth.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def test_two_runs_become_one_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ours = write(tmp_path / "a", track(20.0, lambda t: (0.1, 0.0)))
    theirs = write(tmp_path / "b", track(20.0, lambda t: (0.0, 0.4)))
    assert main(["evaluate", "hold", "blueboat", f"ours={ours}", f"theirs={theirs}", "--point", "0,0"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "| figure | ours | theirs | theirs / ours |"
    assert "| position, RMS, m | 0.1 | 0.4 | 4.00 |" in lines


@pytest.mark.parametrize("elsewhere", [False, True], ids=["home of the file", "run with --home"])
def test_a_route_is_read_from_any_plan(tmp_path: Path, capsys: pytest.CaptureFixture[str], elsewhere: bool) -> None:
    home = HomeConfig(10.0, 20.0, 0.0) if elsewhere else BLUEBOAT.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    rows = ["QGC WPL 110", "0\t1\t0\t16\t0\t0\t0\t0\t{}\t{}\t0\t1".format(*frame.to_geodetic(0.0, 0.0))]
    for i, point in enumerate(((30.0, 0.0), (30.0, 30.0)), start=1):
        rows.append("{}\t0\t3\t16\t0\t0\t0\t0\t{}\t{}\t0\t1".format(i, *frame.to_geodetic(*point)))
    plan = tmp_path / "legs.waypoints"
    plan.write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert len(files.read(plan.name, plan.read_text(encoding="utf-8")).mission) >= 2
    ours = write(tmp_path / "a", track(70.0, along))
    if elsewhere:
        manifest = {"configuration": as_dict(with_home(BLUEBOAT, home)), "parameters": {}}
        (ours / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    assert main(["evaluate", "route", "blueboat", "--plan", str(plan), "--radius", "2", f"ours={ours}"]) == 0
    assert "| time, s |" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "remedy"),
    [
        (("hold", "blueboat", "ours"), "write LABEL=DIR"),
        (("hold", "blueboat", "ours=nowhere"), "cannot be read"),
        (("hold", "blueboat", "ours=.", "--point", "north"), "cannot be read"),
        (("route", "blueboat", "ours=nowhere", "--plan", "none.plan"), "cannot be read"),
    ],
)
def test_a_run_that_cannot_be_judged_is_said(
    words: tuple[str, ...], remedy: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["evaluate", *words]) == 2
    assert remedy in capsys.readouterr().err


@pytest.mark.parametrize("end", [b"70.5,1.2", b"70.5,1.2,-", b"\0" * 300])
def test_a_truth_that_was_cut_off_is_judged_as_far_as_it_goes(
    tmp_path: Path, end: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    run = write(tmp_path / "a", track(70.0, along))
    assert main(["evaluate", "hold", "blueboat", f"ours={run}"]) == 0
    whole = capsys.readouterr().out
    with (run / "truth.csv").open("ab") as file:
        file.write(end)
    assert main(["evaluate", "hold", "blueboat", f"ours={run}"]) == 0
    assert capsys.readouterr().out == whole


def test_a_point_without_numbers_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = write(tmp_path / "a", track(70.0, along))
    for point in ("nan,5", "5,inf", "5"):
        assert main(["evaluate", "hold", "blueboat", f"ours={run}", "--point", point]) == 2
        assert f"--point {point}: write NORTH_M,EAST_M" in capsys.readouterr().err


def test_two_runs_of_one_label_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = write(tmp_path / "a", track(70.0, along))
    assert main(["evaluate", "hold", "blueboat", f"ours={run}", f"ours={run}"]) == 2
    assert "two runs are called 'ours'" in capsys.readouterr().err


def test_a_figure_of_zero_has_no_ratio() -> None:
    figures = hold(track(5.0, lambda t: (0.0, 0.0), share=0.0), BLUEBOAT, (0.0, 0.0), None)
    assert all(text.endswith("– |") for text in list(table({"a": figures, "b": figures}))[2:])
