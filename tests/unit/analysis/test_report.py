"""The report of a log: whole, self-contained, and right where it can be checked by hand."""

from __future__ import annotations

import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from companion.analysis.report import Packets, _chart, _frame
from companion.analysis.report_data import read_log
from companion.analysis.report_plots import _stretches
from companion.cli.main import main
from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import frame, pack
from companion.mission.plan import PlanKind
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.rig import Conditions

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
        "Track",
        "Errors and speeds",
        "Wrench, demanded and achieved",
        "Thrusters",
        "Estimator and devices",
        "Links",
        "Mission",
        "Events",
    ]
    assert [heading for heading in outline.headings if heading in wanted] == wanted
    assert outline.svgs == 6 and "<script" not in text and len(text) < 4_000_000
    assert "revolt" in outline.cells and any(
        re.fullmatch(r"Manual \d+ s, Mission \d+ s(, Hold \d+ s)?", cell) for cell in outline.cells
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


def test_lost_packets_are_counted_by_their_numbers(sailed: Path, tmp_path: Path) -> None:
    import shutil
    import struct

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


def test_a_log_cut_off_is_reported_with_a_word(
    sailed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import shutil

    copy = tmp_path / "cut"
    shutil.copytree(sailed, copy)
    for name in ("ticks.csv", "telemetry.tlog", "events.csv"):
        data = (copy / name).read_bytes()
        (copy / name).write_bytes(data[: len(data) // 2 + 3])
    assert main(["report", str(copy), "--out", str(tmp_path / "cut.html")]) == 0
    assert "incomplete line omitted" in capsys.readouterr().err
    assert (tmp_path / "cut.html").stat().st_size > 100_000


def test_what_is_no_log_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(tmp_path)]) == 2
    assert "no log folder" in capsys.readouterr().err


def test_stretches() -> None:
    t = np.arange(6.0)
    assert _stretches(t, np.array([1, 1, 0, 0, 1, 1]) > 0) == [(0.0, 2.0, True), (2.0, 4.0, False), (4.0, 5.0, True)]
