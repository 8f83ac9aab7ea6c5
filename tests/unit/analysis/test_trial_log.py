"""The manoeuvres of a trial, their figures, and what is held out, from logs that are written here."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from companion.analysis.held_out import split
from companion.analysis.imo import figures
from companion.analysis.manoeuvre import Manoeuvre
from companion.analysis.trial_log import Ran, manoeuvres

EVENTS = """t_s,time_unix_ns,severity,name,text
1.0,0,INFO,trial_begins,"Trial: circle of 24 m, 17 min left"
2.0,0,INFO,trial_runs,"Trial: 1/16 motor check, 17 min left"
12.0,0,INFO,trial_ran,"Trial: 1/16 done"
20.0,0,INFO,trial_runs,"Trial: 2/16 surge +30% coast, 16 min left"
25.0,0,INFO,trial_ran,"Trial: 2/16 at the circle"
30.0,0,INFO,trial_runs,"Trial: 3/16 spin 35%, -0 min left"
"""


def test_manoeuvres_of_a_log(tmp_path: Path) -> None:
    assert manoeuvres(tmp_path) == ()
    (tmp_path / "events.csv").write_text(EVENTS, encoding="utf-8")
    assert manoeuvres(tmp_path) == (
        Ran("motor check", 2.0, 12.0, cut=False),
        Ran("surge +30% coast", 20.0, 25.0, cut=True),
    )


@pytest.mark.parametrize("end", [b"\0" * 300, b'31.0,0,INFO,other,"5 \xc2', b"3"])
def test_what_a_power_cut_left_of_a_row_is_no_manoeuvre(tmp_path: Path, end: bytes) -> None:
    (tmp_path / "events.csv").write_text(EVENTS, encoding="utf-8")
    whole = manoeuvres(tmp_path)
    (tmp_path / "events.csv").write_bytes(EVENTS.encode() + end)
    assert manoeuvres(tmp_path) == whole
    (tmp_path / "events.csv").write_bytes(b"time" + EVENTS.encode())
    assert manoeuvres(tmp_path) == ()


def write(folder: Path, rows: list[tuple[float, float, float, float, float]]) -> None:
    """`rows`: t, north, east, yaw, surge."""
    lines = ["t_s,north_m,east_m,yaw_rad,surge_mps,sway_mps"]
    lines += [f"{t},{n},{e},{math.remainder(yaw, math.tau)},{u},0" for t, n, e, yaw, u in rows]
    (folder / "ticks.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def by_name(folder: Path, ran: Ran, current: tuple[float, float] = (0.0, 0.0)) -> dict[str, float]:
    warnings: list[str] = []
    found = {figure.name: figure.value for figure in figures(folder, (ran,), 2.0, current, warnings)}
    assert warnings == []
    return found


def test_a_turning_circle_of_known_radius_in_a_current(tmp_path: Path) -> None:
    radius, rate, drift = 5.0, 0.2, 0.3
    rows = []
    for k in range(600):
        t = 0.1 * k
        yaw = rate * t
        rows.append((t, radius * math.sin(yaw) + drift * t, radius * (1.0 - math.cos(yaw)), yaw, radius * rate))
    write(tmp_path, rows)
    found = by_name(tmp_path, Ran("turning circle port", 0.0, 60.0, False), (drift, 0.0))
    assert found["turning circle port: advance"] == pytest.approx(radius, abs=0.5)
    assert found["turning circle port: transfer"] == pytest.approx(radius, abs=0.5)
    assert found["turning circle port: tactical diameter"] == pytest.approx(2.0 * radius, abs=0.2)


def test_a_turning_circle_counts_from_the_execute(tmp_path: Path) -> None:
    """They counted from 5 degrees of turn on, and in its direction: 8 % less advance, 13 % less transfer of an Otter."""
    rows, lines, north, east, yaw, rate = [], [], 0.0, 0.0, 0.7, 0.0
    for k in range(900):
        turns = k >= 300
        rate += (0.2 - rate) * 0.1 if turns else 0.0
        rows.append((0.1 * k, north, east, yaw, 1.0))
        lines.append(f"{9.0 if turns else 0.3 * (-1) ** k}")
        north, east, yaw = north + 0.1 * math.cos(yaw), east + 0.1 * math.sin(yaw), yaw + 0.1 * rate
    write(tmp_path, rows)
    table = (tmp_path / "ticks.csv").read_text(encoding="utf-8").splitlines()
    told = [f"{row},{moment}" for row, moment in zip(table, ["demanded_yaw_nm", *lines], strict=True)]
    (tmp_path / "ticks.csv").write_text("\n".join(told) + "\n", encoding="utf-8")
    found = by_name(tmp_path, Ran("turning circle port", 0.0, 90.0, False))
    first = next(k for k, row in enumerate(rows) if row[3] - 0.7 >= 0.5 * math.pi)
    ahead, aside = rows[first][1] - rows[300][1], rows[first][2] - rows[300][2]
    c, s = math.cos(0.7), math.sin(0.7)
    assert found["turning circle port: advance"] == pytest.approx(c * ahead + s * aside, abs=0.01)
    assert found["turning circle port: transfer"] == pytest.approx(c * aside - s * ahead, abs=0.01)


def test_overshoots_of_a_zig_zag(tmp_path: Path) -> None:
    turn = np.interp(np.arange(0.0, 60.0, 0.1), [0.0, 10.0, 30.0, 50.0, 60.0], [0.0, 14.0, -17.0, 12.0, 0.0])
    write(tmp_path, [(0.1 * k, 0.0, 0.0, 3.1 + math.radians(float(angle)), 1.0) for k, angle in enumerate(turn)])
    found = by_name(tmp_path, Ran("zig-zag 10/10", 0.0, 60.0, False))
    assert found["zig-zag 10/10: first overshoot"] == pytest.approx(4.0, abs=0.1)
    assert found["zig-zag 10/10: second overshoot"] == pytest.approx(7.0, abs=0.1)


def test_the_stopping_distance_is_from_full_speed_to_rest(tmp_path: Path) -> None:
    rows, north = [], 0.0
    for k in range(200):
        t = 0.1 * k
        speed = min(2.0, 0.4 * t) if t < 10.0 else max(0.0, 2.0 - 0.5 * (t - 10.0))
        rows.append((t, north, 0.0, 0.0, speed + (0.001 if t == 10.0 else 0.0)))
        north += 0.1 * speed
    write(tmp_path, rows)
    found = by_name(tmp_path, Ran("stopping", 0.0, 20.0, False))
    assert found["stopping distance"] == pytest.approx(4.0, abs=0.2)


def test_what_is_held_out_is_not_fitted() -> None:
    t_s = np.arange(0.0, 100.0, 0.1)
    zeros = np.zeros((len(t_s), 3))
    whole = Manoeuvre(t_s, t_s * 0.0, zeros, zeros, zeros, ((0, len(t_s)),), 0.1)
    fitted, held = split(whole, [Ran("zig-zag 20/20", 30.0, 55.0, False), Ran("drift", 60.0, 70.0, False)])
    assert fitted.stretches == ((0, 300), (550, 1000))
    assert held.stretches == ((300, 400), (400, 500))
    fitted, held = split(whole, [])
    assert fitted.stretches == ((0, 750),) and held.stretches == ((750, 850), (850, 950))


def test_manoeuvres_that_are_too_short_to_be_predicted_give_way_to_the_end_of_the_log() -> None:
    """As of a trial that the circle cut and an operator ended: its model was proposed without being judged."""
    t_s = np.arange(0.0, 100.0, 0.1)
    zeros = np.zeros((len(t_s), 3))
    whole = Manoeuvre(t_s, t_s * 0.0, zeros, zeros, zeros, ((0, len(t_s)),), 0.1)
    fitted, held = split(whole, [Ran("surge +60% coast", 30.0, 38.0, True)])
    assert fitted.stretches == ((0, 750),) and held.stretches == ((750, 850), (850, 950))
