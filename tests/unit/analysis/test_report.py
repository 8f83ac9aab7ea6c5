"""The report of a log: whole, self-contained, and right where it can be checked by hand."""

from __future__ import annotations

import csv
import json
import re
import shutil
import struct
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest

from companion.analysis.log_reader import LogError
from companion.analysis.report import Packets, _chart, _frame, write_report
from companion.analysis.report_data import read_log
from companion.analysis.report_facts import Level, distance_m, errors_by_mode, verdicts
from companion.analysis.svg_chart import Frame, Series, chart, clock, nice_steps, stretches, thinned
from companion.analysis.svg_map import _Labels
from companion.analysis.table_page import write_table
from companion.cli.main import main
from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import frame, pack
from companion.mission.plan import PlanKind
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.rig import Conditions
from tests.browser import Browser, needs_browser

POINTS = [(0.0, 8.0), (8.0, 8.0)]


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short mission with a fence, uploaded under way."""
    folder = tmp_path_factory.mktemp("report") / "log"
    rig = LockstepRig(Conditions("revolt", seed=4), folder)
    station = GroundStation(rig)
    frame = LocalFrame(rig.config.home.lat_deg, rig.config.home.lon_deg)
    station.ready()
    station.upload([Item(16, *frame.to_geodetic(*point)) for point in POINTS])
    corners = ((-40.0, -40.0), (40.0, -40.0), (40.0, 40.0), (-40.0, 40.0))
    station.upload([Item(5001, *frame.to_geodetic(*corner), params=(4.0, 0.0, 0.0, 0.0)) for corner in corners], kind=1)
    station.set_mode(0x04040000)
    station.arm()
    station.wait("both reached", lambda: len(set(station.reached)) == 2, 120.0)
    rig.close()
    return folder


class Outline(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.headings: list[str] = []
        self.cells: list[str] = []
        self.svgs = 0
        self._in = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._in = tag
        self.svgs += tag == "svg"
        for name, value in attrs:
            assert name not in ("src",) and not (name == "href" and (value or "").startswith("http")), (
                tag,
                name,
                value,
            )

    def handle_data(self, data: str) -> None:
        if self._in in ("h1", "h2"):
            self.headings.append(data.strip())
        elif self._in in ("td", "th"):
            self.cells.append(data)


def test_the_page_is_whole_and_needs_nothing_else(sailed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(sailed)]) == 0
    text = (sailed / "report.html").read_text(encoding="utf-8")
    outline = Outline()
    outline.feed(text)
    wanted = [
        "Modes and failsafes",
        "Errors and speeds",
        "Thrusters",
        "Estimator and devices",
        "GNSS",
        "Wind and current",
        "Battery",
        "Links",
        "Mission",
        "Events",
        "Settings that differ from the default",
    ]
    assert [heading for heading in outline.headings if heading in wanted] == wanted
    assert outline.svgs > 30 and len(text) < 4_000_000 and "rad<" not in text and "rad/s" not in text
    assert "http" not in text.replace("http://www.w3.org", "")
    assert "revolt" in outline.cells and any(
        re.fullmatch(r"Manual \d+ s, Mission [\d:]+ (s|min)(, Hold \d+ s)?", cell) for cell in outline.cells
    )
    assert outline.cells.count("NAV_WAYPOINT") == 2
    assert any("Mission item 1 reached" in cell for cell in outline.cells)
    rows = re.findall(
        r"<tr><td>(\d+)</td><td>NAV_WAYPOINT</td><td>[^<]*</td><td>([\d.]+)</td>", re.sub(" class='n'", "", text)
    )
    assert [number for number, _ in rows] == ["1", "2"], "each with the time when it was reached"


def test_a_mission_with_home_as_item_0_has_the_same_numbers(sailed: Path, tmp_path: Path) -> None:
    """As a client uploads it on a link of the ardupilot persona: home, then the boat's own items."""
    folder = shutil.copytree(sailed, tmp_path / "log")
    said = [(255, mavlink.MAVLink_mission_count_message(1, 1, 3, 0))]
    for seq in range(3):
        item = mavlink.MAVLink_mission_item_int_message(
            1, 1, seq, 3, 16, 0, 1, 0.0, 0.0, 0.0, 0.0, 634_400_000 + seq, 104_000_000, 0.0, 0
        )
        said.append((255, item))
    said.append((1, mavlink.MAVLink_mission_ack_message(255, 190, 0, 0)))
    said.append((1, mavlink.MAVLink_mission_current_message(0, 2, 2, 2, 0, 0, 0)))
    stamp = (folder / "telemetry.tlog").read_bytes()[:8]
    packets = [stamp + frame(pack(message), seq, system, 1) for seq, (system, message) in enumerate(said)]
    (folder / "telemetry.tlog").write_bytes(b"".join(packets))
    mission = Packets(read_log(folder)).plans()[PlanKind.MISSION]
    assert [(item.number, item.x) for item in mission] == [(1, 634_400_001), (2, 634_400_002)]


def test_the_mission_and_the_fence_stand_where_they_were_uploaded(sailed: Path) -> None:
    recorded = read_log(sailed)
    packets = Packets(recorded)
    plans = packets.plans()
    assert [len(plans[kind]) for kind in PlanKind] == [2, 4, 0]
    chart = _chart(plans, _frame(recorded, packets))
    for (_, north_m, east_m), point in zip(chart.waypoints, POINTS, strict=True):
        assert (north_m, east_m) == pytest.approx(point, abs=0.05)
    ((outline, inside),) = chart.zones
    assert inside and max(max(map(abs, corner)) for corner in outline) == pytest.approx(40.0, abs=0.05)


def test_what_the_page_says_of_the_run_is_what_the_log_says(sailed: Path) -> None:
    recorded = read_log(sailed)
    assert recorded.truth is not None
    off = np.hypot(
        recorded.ticks["north_m"] - np.interp(recorded.t_s, recorded.truth["t_s"], recorded.truth["north_m"]), 0.0
    )
    assert np.nanmax(off[recorded.ticks["position_valid"] > 0]) < 0.2
    (station,) = [row for row in Packets(recorded).rows() if row[0].startswith("system 255")]
    assert int(station[1]) > 20 and station[2] == "0"


def test_the_way_is_that_of_the_armed_boat_without_the_noise_of_its_positions(sailed: Path) -> None:
    """As the last lines of `companion run` tell it, so that a run has one distance."""
    recorded = read_log(sailed)
    truth = recorded.truth
    assert truth is not None
    armed_s = recorded.t_s[recorded.ticks["armed"] > 0.0]
    under_way = (truth["t_s"] >= armed_s[0]) & (truth["t_s"] <= armed_s[-1])
    way = np.hypot(np.diff(truth["north_m"][under_way]), np.diff(truth["east_m"][under_way]))
    assert distance_m(recorded) == pytest.approx(float(np.sum(way)), rel=0.03)
    moored = dict(recorded.ticks) | {"armed": np.zeros_like(recorded.t_s)}
    assert distance_m(replace(recorded, ticks=moored)) == 0.0


def test_lost_packets_are_counted_by_their_numbers(sailed: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(sailed, copy)
    data = (sailed / "telemetry.tlog").read_bytes()
    kept, at, dropped, seen = bytearray(), 0, 0, 0
    while at < len(data):
        size = 8 + 12 + data[at + 9]
        assert struct.unpack_from(">Q", data, at)[0] > 0 and data[at + 8] == 0xFD
        seen += data[at + 13] == 255
        if data[at + 13] == 255 and seen > 3 and seen % 5 == 0:
            dropped += 1
        else:
            kept += data[at : at + size]
        at += size
    (copy / "telemetry.tlog").write_bytes(kept)
    (station,) = [row for row in Packets(read_log(copy)).rows() if row[0].startswith("system 255")]
    assert dropped > 3 and int(station[2]) in (dropped, dropped - 1)  # the very last one leaves no gap


@pytest.mark.parametrize(("after", "by_s"), [(1, 3.2e7), (40, 3.2e7), (40, -6.0), (40, -3.2e7), (40, 7.0)])
def test_a_clock_that_steps_moves_neither_links_nor_waypoints(
    sailed: Path, tmp_path: Path, after: int, by_s: float
) -> None:
    """As of a computer without a battery for its clock, which learns the time under way."""
    copy = shutil.copytree(sailed, tmp_path / "copy")
    head, *rows = [row.split(",") for row in (copy / "ticks.csv").read_text(encoding="utf-8").splitlines()]
    at = head.index("time_unix_ns")
    before_us = int(rows[after][at]) // 1000
    for row in rows[after:]:
        row[at] = str(int(row[at]) + round(by_s * 1e9))
    (copy / "ticks.csv").write_text("".join(",".join(row) + "\n" for row in [head, *rows]), encoding="utf-8")
    data, place = bytearray((copy / "telemetry.tlog").read_bytes()), 0
    while place < len(data):
        (stamp_us,) = struct.unpack_from(">Q", data, place)
        if stamp_us >= before_us:
            struct.pack_into(">Q", data, place, stamp_us + round(by_s * 1e6))
        place += 8 + 12 + data[place + 9]
    (copy / "telemetry.tlog").write_bytes(data)
    was, now = (Packets(read_log(folder)) for folder in (sailed, copy))
    assert now.place == pytest.approx(was.place, abs=0.2)
    for then, link in zip(was.links(), now.links(), strict=True):
        assert np.abs(link.packets - then.packets).sum() <= 0.05 * then.packets.sum()
    write_report(copy, tmp_path / "page.html")
    begun = datetime(2026, 6, 1, 12, tzinfo=UTC) + timedelta(seconds=by_s)
    assert f"<td>begun</td><td>{begun:%Y-%m-%d %H:%M:%S} UTC</td>" in (tmp_path / "page.html").read_text("utf-8")


def test_a_log_cut_off_is_reported_with_a_word(
    sailed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "cut"
    shutil.copytree(sailed, copy)
    for name in ("ticks.csv", "telemetry.tlog", "events.csv"):
        data = (copy / name).read_bytes()
        (copy / name).write_bytes(data[: len(data) // 2 + 3])
    assert main(["report", str(copy), "--out", str(tmp_path / "cut.html")]) == 0
    assert "incomplete line omitted" in capsys.readouterr().err
    assert (tmp_path / "cut.html").stat().st_size > 100_000


@pytest.mark.parametrize("left", [0, 5, 8, -1, -40, -5000])
def test_a_log_that_a_power_cut_ended_between_two_rows_is_not_complete(
    sailed: Path, tmp_path: Path, left: int, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = shutil.copytree(sailed, tmp_path / "cut")
    assert log_verdict(copy) == (Level.GOOD, "complete")
    (copy / "log.mcap").write_bytes((copy / "log.mcap").read_bytes()[:left])
    assert log_verdict(copy) == (Level.BAD, "log.mcap: has no end: the log was cut off, or is still written")
    assert main(["report", str(copy)]) == 0
    assert "warning: log.mcap: has no end" in capsys.readouterr().err
    (copy / "log.mcap").unlink()
    assert log_verdict(copy) == (Level.GOOD, "complete"), "as of versions before it"


def log_verdict(folder: Path) -> tuple[Level, str]:
    (line,) = [line for line in verdicts(read_log(folder), []) if line.subject == "log"]
    return line.level, line.text


def test_what_is_no_log_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert "no log folder" in said and "newest" not in said
    inner = tmp_path / "boat-20261126-120000"
    inner.mkdir()
    (inner / "manifest.json").write_text("{}")
    assert main(["report", str(tmp_path)]) == 2
    assert f"the newest log in it is {inner}" in capsys.readouterr().err


def test_stretches() -> None:
    t = np.arange(6.0)
    assert stretches(t, np.array([1, 1, 0, 0, 1, 1])) == [(0.0, 2.0, 1), (2.0, 4.0, 0), (4.0, 5.0, 1)]


def test_the_verdicts_are_what_the_log_says(sailed: Path, tmp_path: Path) -> None:
    lines = {line.subject: line for line in verdicts(read_log(sailed), Packets(read_log(sailed)).rows())}
    assert lines["failsafes"].level is Level.GOOD and lines["log"].text == "complete"
    assert lines["links"].level is Level.GOOD and lines["lateness"].level is Level.GOOD
    errors = {(row.mode, row.kind): row.values for row in errors_by_mode(read_log(sailed))}
    ticks = read_log(sailed).ticks
    here = (ticks["armed"] > 0) & np.isfinite(ticks["cross_track_error_m"])
    assert np.max(errors["Mission", "across the track"]) == np.max(np.abs(ticks["cross_track_error_m"][here]))
    ill = shutil.copytree(sailed, tmp_path / "ill")
    rows = (ill / "ticks.csv").read_text(encoding="utf-8").splitlines()
    names = rows[0].split(",")
    cells = [row.split(",") for row in rows[1:]]
    for row in cells[40:60]:
        row[names.index("failsafes")] = "gnss_lost;leak"
        row[names.index("bow_condition")] = "failed"
    kept = [",".join(row) for n, row in enumerate(cells) if n not in (70, 71, 72)]
    (ill / "ticks.csv").write_text("\n".join([rows[0], *kept]) + "\n", encoding="utf-8")
    lines = {line.subject: line for line in verdicts(read_log(ill), [("system 255", "90", "10", "10.0 %")])}
    assert lines["failsafes"].text == "gnss lost 2 s, leak 2 s" and lines["failsafes"].level is Level.BAD
    assert lines["thrusters"].text == "bow failed" and "1 of" in lines["lateness"].text
    assert lines["links"].text == "system 255: 10 missing (10.0 %)"


def test_a_simulated_time_that_waited_for_the_computer_was_not_in_time(sailed: Path, tmp_path: Path) -> None:
    """In green it said: every tick in time; load 95 % of the time under 329 %."""
    log = shutil.copytree(sailed, tmp_path / "fast")
    rows = [row.split(",") for row in (log / "ticks.csv").read_text(encoding="utf-8").splitlines()]
    for row in rows[1:]:
        row[rows[0].index("load")] = "3.290"
    (log / "ticks.csv").write_text("".join(",".join(row) + "\n" for row in rows), encoding="utf-8")
    (line,) = (one for one in verdicts(read_log(log), []) if one.subject == "lateness")
    assert line.level is Level.NOTE and "3.3 times too slow for `--speed`" in line.text


def test_the_checks_of_a_scenario_and_its_picture_stand_on_top(sailed: Path, tmp_path: Path) -> None:
    log = shutil.copytree(sailed, tmp_path / "log")
    checks = [
        {"name": "near <it>", "value": 0.5, "limit": 1.0, "unit": "m", "at_least": False, "ok": True},
        {"name": "steady", "value": 3.0, "limit": 1.0, "unit": "deg", "at_least": False, "ok": False},
    ]
    result = {"scenario": "x", "settings": {"wind": "2"}, "error": None, "metrics": {"a_m": 1.0}, "checks": checks}
    (log / "result.json").write_text(json.dumps(result), encoding="utf-8")
    (log / "picture.png").write_bytes(b"\x89PNG")
    write_report(log, log / "report.html")
    text = (log / "report.html").read_text(encoding="utf-8")
    assert "near &lt;it&gt;" in text and text.count("FAILS") == 1 and "1 of 2 checks fail: steady" in text
    assert "data:image/png;base64," in text and text.index("FAILS") < text.index("data:image/png") < text.index(
        "Battery"
    )


def test_an_older_log_without_the_later_columns_has_its_track(sailed: Path, tmp_path: Path) -> None:
    log = shutil.copytree(sailed, tmp_path / "log")
    rows = [row.split(",") for row in (log / "ticks.csv").read_text(encoding="utf-8").splitlines()]
    later = {"lat_deg", "lon_deg", "fix", "satellites", "battery_v", "wind_speed_mps"}
    keep = [n for n, name in enumerate(rows[0]) if name not in later]
    (log / "ticks.csv").write_text("".join(",".join(row[n] for n in keep) + "\n" for row in rows), encoding="utf-8")
    recorded, now = read_log(log), read_log(sailed)
    valid = now.ticks["position_valid"] > 0
    assert recorded.ticks["lat_deg"][valid] == pytest.approx(now.ticks["lat_deg"][valid], abs=2e-8)
    write_report(log, log / "report.html")
    assert "Voltage, V: not in this log" in (log / "report.html").read_text(encoding="utf-8")


def test_a_boat_that_knew_nothing_has_a_page(sailed: Path, tmp_path: Path) -> None:
    """It ended in an error of the chart's size, or said that the load was "nan %"."""
    folder = tmp_path / "log"
    shutil.copytree(sailed, folder)
    ticks = folder / "ticks.csv"
    header, *rows = csv.reader(ticks.read_text().splitlines())
    known = ("t_s", "time_unix_ns", "mode", "armed", "position_valid")
    lines = [",".join(cell if name in known else "" for name, cell in zip(header, row, strict=True)) for row in rows]
    ticks.write_text("\n".join([",".join(header), *lines, ""]))
    write_report(folder, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for text in ("No valid position", "load not known"):
        assert text in page
    told = page.partition("<script>")[0]
    assert not re.search(r"\bnan\b", told), re.findall(r".{40}\bnan\b.{20}", told)


def test_a_row_without_time_and_a_result_that_is_none_cost_no_page(sailed: Path, tmp_path: Path) -> None:
    """An empty cell raised "cannot convert float NaN to integer", and `[1]` "has no attribute 'get'"."""
    folder = tmp_path / "log"
    shutil.copytree(sailed, folder)
    (folder / "result.json").write_text("[1]")
    lines = (folder / "ticks.csv").read_text().split("\n")
    cells = lines[50].split(",")
    cells[lines[0].split(",").index("t_s")] = ""
    lines[50] = ",".join(cells)
    (folder / "ticks.csv").write_text("\n".join(lines))
    assert "ticks.csv:51: row omitted: no time" in write_report(folder, tmp_path / "page.html")
    recorded = read_log(folder)
    assert recorded.result is None and len(recorded.t_s) == len(lines) - 3


def test_the_words_of_a_row_are_its_own_whichever_rows_are_omitted(sailed: Path, tmp_path: Path) -> None:
    """Modes and failsafes came one row too early after each row that was omitted."""
    folder = shutil.copytree(sailed, tmp_path / "log")
    lines = (folder / "ticks.csv").read_text().split("\n")
    names = lines[0].split(",")
    for number, name in ((20, "t_s"), (30, "surge_mps"), (40, "load")):
        cells = lines[number].split(",")
        cells[names.index(name)] = "" if name == "t_s" else "?"
        lines[number] = ",".join(cells)
    (folder / "ticks.csv").write_text("\n".join(lines))
    recorded, before = read_log(folder), read_log(sailed)
    kept = [n for n in range(len(before.t_s)) if n not in (19, 29, 39)]
    assert list(recorded.t_s) == list(before.t_s[kept])
    for name, words in before.words.items():
        assert recorded.words[name] == [words[n] for n in kept], name


@pytest.mark.parametrize("result", [{"checks": [1]}, {"checks": 1}, {"checks": [{"name": "a"}]}, {"metrics": [1]}, [1]])
def test_a_result_that_is_damaged_costs_no_page(sailed: Path, tmp_path: Path, result: object) -> None:
    """It ended in a TypeError."""
    folder = shutil.copytree(sailed, tmp_path / "runs" / "log")
    (folder / "result.json").write_text(json.dumps(result))
    write_report(folder, tmp_path / "page.html")
    assert read_log(folder).result is None
    with pytest.raises(LogError, match="neither a log nor"):
        write_table(tmp_path / "runs", tmp_path / "table.html")


def test_waypoints_have_the_plans_numbers_and_no_label_covers_another() -> None:
    labels = _Labels(0.1, [])
    texts = [labels.place(str(n), 0.0, 0.0, "number") for n in range(6)]
    assert sum("hidden" not in text for text in texts) == 4, "one on each side"
    for n, a in enumerate(labels.taken):
        assert all(a[2] < b[0] or a[0] > b[2] or a[3] < b[1] or a[1] > b[3] for b in labels.taken[n + 1 :])


def test_a_long_series_keeps_its_peaks_and_gaps() -> None:
    t = np.arange(100_000.0)
    values = np.sin(t / 1000.0)
    values[54_321], values[70_000:71_000] = 9.0, np.nan
    when, shown = thinned(t, values)
    assert len(when) < 2000 and np.nanmax(shown) == 9.0 and when[np.nanargmax(shown)] == 54_321.0
    assert np.isnan(shown).any() and np.all(np.diff(when) >= 0.0)


FRAME = Frame(0.0, 600.0)
TIMES = np.linspace(0.0, 600.0, 7)


def test_directions_around_north_are_one_line() -> None:
    page = chart(
        FRAME, "Heading, °", [Series("heading", TIMES, np.array([350, 355, 0, 5, 10, 20, 30.0]))], compass=True
    )
    (path,) = re.findall(r"<path [^>]*data-turn='360'[^>]* d='([^']*)'", page)
    drawn = [-float(point.split(",")[1]) for point in re.split("[ML]", path)[1:]]
    assert drawn == pytest.approx([-10.0, -5.0, 0.0, 5.0, 10.0, 20.0, 30.0])
    assert re.findall(r"text-anchor='end'>(\d+)</text>", page) == ["0", "20"]


def test_the_last_time_stands_inside_the_chart() -> None:
    page = chart(FRAME, "Load, %", [Series("load", TIMES, np.zeros(7))])
    assert "text-anchor='end'>10:00<" in page and "text-anchor='middle'>9:00<" in page
    assert "-0.5" not in page, "a load is not negative"


LAID_OUT = """
const texts = [...document.querySelectorAll("svg text")].filter((t) => !t.classList.contains("hidden") && t.textContent.trim());
const boxes = texts.map((t) => [t.closest("svg.chart, svg.track"), t.getBoundingClientRect(), t.textContent]);
const faults = [];
boxes.forEach(([svg, a, one], n) => {
  const frame = svg.getBoundingClientRect();
  if (a.left < frame.left - 2 || a.right > frame.right + 2) faults.push(`${one} is cut off`);
  for (const [other, b, two] of boxes.slice(n + 1)) {
    if (other === svg && a.left + 1 < b.right && b.left + 1 < a.right && a.top + 2.5 < b.bottom - 2.5 && b.top + 2.5 < a.bottom - 2.5) faults.push(`${one} lies over ${two}`);
  }
});
if (document.documentElement.scrollWidth > innerWidth + 1) faults.push(`${document.documentElement.scrollWidth} px wide`);
for (const cell of document.querySelectorAll("td, th")) {
  const word = Math.max(...cell.textContent.split(/\\s+/).map((w) => w.length)), size = parseFloat(getComputedStyle(cell).fontSize);
  if (cell.clientWidth < 0.4 * size * word) faults.push(`${cell.textContent}: torn apart`);
}
if (/\\brad(\\/s|ians)?\\b/.test(document.body.innerText)) faults.push("radians");
return faults;
"""


@needs_browser
def test_no_text_lies_over_another_on_a_screen_and_on_a_phone(sailed: Path, tmp_path: Path) -> None:
    write_report(sailed, tmp_path / "report.html")
    browser = Browser(tmp_path)
    for width, height in ((1280, 800), (390, 844)):
        browser.resize(width, height)
        browser.open(f"file://{tmp_path}/report.html")
        assert browser.run(LAID_OUT) == [], width
    browser.driver.quit()


def test_ticks_of_an_axis() -> None:
    assert nice_steps(-0.3, 1.1, 4) == pytest.approx([0.0, 0.5, 1.0]) and nice_steps(0.0, 0.0, 4)
    assert [clock(t) for t in (0.0, 59.4, 125.0, 3725.0, -5.0)] == ["0", "59", "2:05", "1:02:05", "−5"]


def test_a_folder_of_runs_is_one_page(sailed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two groups of runs, one of which fails; each dot leads to its run's report."""
    for group, seed, value in (("calm", 0, 1.0), ("calm", 1, 3.0), ("wind 3 m per s", 0, 9.0)):
        run = shutil.copytree(sailed, tmp_path / group / f"seed{seed}", ignore=shutil.ignore_patterns("report.html"))
        check = {"name": "near", "value": value, "limit": 5.0, "unit": "m", "at_least": False, "ok": value < 5.0}
        result = {"scenario": "x", "seed": seed, "ok": value < 5.0, "metrics": {"off_m": value}, "checks": [check]}
        (run / "result.json").write_text(json.dumps(result), encoding="utf-8")
    assert main(["report", str(tmp_path)]) == 0
    assert "3 runs" in capsys.readouterr().out
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "2 of 2" in text and "0 of 1" in text and "near fails in 1" in text and text.count("<circle") == 3
    targets = set(re.findall(r"href='([^']+)'", text))
    assert len(targets) == 3 and all((tmp_path / unquote(target)).stat().st_size > 100_000 for target in targets)
