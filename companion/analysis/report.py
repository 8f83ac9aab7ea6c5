"""A log as one self-contained HTML file. This module reads the log's packets: links, and the mission and fence in
force."""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from companion.analysis.log_reader import LogError, read_table
from companion.analysis.mission_plot import fence_zones
from companion.analysis.report_data import Array, Recorded, read_log
from companion.analysis.report_page import html
from companion.analysis.report_sections import LinkSeries, Page, frame_of
from companion.analysis.svg_map import Chart
from companion.core.geodesy import LocalFrame
from companion.core.progress import Told, part, tell_nobody
from companion.io.mavlink.transfer.mission_codec import item_from_int, with_jump_moved
from companion.io.mavlink.wire.framer import Framer, UnknownMessage
from companion.mission.commands import PLACES, name_of
from companion.mission.plan import PlanItem, PlanKind
from companion.record.state_file import read_plan

_STAMP = struct.Struct(">Q")
_MOST_LINKS = 6
_OWN_FILES = ("ticks.csv", "truth.csv", "events.csv", "readings.csv", "pictures.csv", "geotags.csv", "replay.csv")
_BIN_S = 5.0
_STEP_S = 1.0  # of the computer's clock
_READ, _HEARD = 0.45, 0.75  # shares of the whole after which the ticks, and the packets, are read
_PACKETS_TOLD = 1000  # packets between two words about how many are read


def write_report(folder: Path, out: Path, told: Told = tell_nobody) -> Sequence[str]:
    """Write the page of the log in `folder` to `out`. Returns warnings about what could not be read.

    Raises LogError for a folder that is no log; OSError.
    """
    told("reading the log", 0.0)
    recorded = read_log(folder)
    packets = Packets(recorded, part(told, _READ, _HEARD))
    told("drawing", _HEARD)
    plans = packets.plans()
    page = Page(recorded, frame_of(recorded), _mission(recorded, plans), packets.rows(), packets.links())
    chart = _chart(plans, _frame(recorded, packets), _others(folder))
    out.write_text(html(page, chart), encoding="utf-8")
    return recorded.warnings


class _Clock:
    """The boat's time of packets, in the order of the .tlog. A computer that keeps no time while it is off learns it
    under way: each step of its clock begins a span of ticks with another difference to the boat's time."""

    def __init__(self, recorded: Recorded) -> None:
        unix_s, t_s = recorded.ticks["time_unix_ns"] * 1e-9, recorded.t_s
        steps = np.flatnonzero(np.abs(np.diff(unix_s - t_s)) > _STEP_S) + 1
        firsts = [0, *steps.tolist()]
        lasts = [*(first - 1 for first in firsts[1:]), len(t_s) - 1]
        self._spans = [(float(unix_s[a]), float(unix_s[b]), float(t_s[a])) for a, b in zip(firsts, lasts, strict=True)]
        self._at, self._last_s = 0, 0.0

    def boat_time_s(self, unix_s: float) -> float:
        """The boat's time of the next packet."""
        while self._at + 1 < len(self._spans) and (
            unix_s < self._last_s - _STEP_S or self._outside_s(self._at + 1, unix_s) < self._outside_s(self._at, unix_s)
        ):
            self._at, self._last_s = self._at + 1, 0.0
        self._last_s = unix_s
        begun_s, _, t_s = self._spans[self._at]
        return unix_s - begun_s + t_s

    def _outside_s(self, span: int, unix_s: float) -> float:
        begun_s, ended_s, _ = self._spans[span]
        return max(begun_s - unix_s, unix_s - ended_s, 0.0)


class Packets:
    """The .tlog of a run, read once: packets and gaps of each sender, and the plans that were accepted. `place`: (t_s,
    lat_deg, lon_deg) of this boat's first reported position."""

    def __init__(self, recorded: Recorded, told: Told = tell_nobody) -> None:
        self._folder = recorded.log.folder
        clock = _Clock(recorded)
        self._own = int(recorded.log.parameters.get("MAV_SYS_ID", 1))
        self._times: dict[tuple[int, int], list[float]] = defaultdict(list)
        self._missing: dict[tuple[int, int], list[tuple[float, int]]] = defaultdict(list)
        self._accepted: dict[PlanKind, tuple[PlanItem, ...]] = {}
        self._fresh = False  # a mission was accepted, and the boat has not said yet how many items it has
        self._end_s = float(recorded.t_s[-1])
        self.place: tuple[float, float, float] | None = None
        coming: dict[int, dict[int, PlanItem]] = defaultdict(dict)
        numbers: dict[tuple[int, int], int] = {}
        for unix_s, message in _messages(self._folder / "telemetry.tlog", told):
            who = message.get_srcSystem(), message.get_srcComponent()
            t_s = clock.boat_time_s(unix_s)
            self._times[who].append(t_s)
            if who[0] != self._own:  # our own packets are logged before each link numbers them
                gap = (message.get_seq() - numbers.get(who, message.get_seq() - 1) - 1) % 256
                numbers[who] = message.get_seq()
                if 0 < gap < 128:
                    self._missing[who].append((t_s, gap))
            self._take_plan(message, coming)
            if (
                self.place is None
                and who[0] == self._own
                and message.get_type() == "GLOBAL_POSITION_INT"
                and (message.lat, message.lon) != (0, 0)
            ):
                self.place = (t_s, message.lat * 1e-7, message.lon * 1e-7)

    def _take_plan(self, message: Any, coming: dict[int, dict[int, PlanItem]]) -> None:
        match message.get_type():
            case "MISSION_COUNT" if message.target_system == self._own:
                coming[message.mission_type] = {}
            case "MISSION_ITEM_INT" if message.target_system == self._own:
                coming[message.mission_type][message.seq] = item_from_int(message, message.seq)
            case "MISSION_ACK" if (
                message.get_srcSystem() == self._own and message.type == 0 and coming.get(message.mission_type)
            ):
                items = coming.pop(message.mission_type)
                if message.mission_type in tuple(PlanKind):
                    self._accepted[PlanKind(message.mission_type)] = tuple(items[seq] for seq in sorted(items))
                    self._fresh = self._fresh or message.mission_type == PlanKind.MISSION
            case "MISSION_CURRENT" if message.get_srcSystem() == self._own and self._fresh:
                self._fresh = False
                self._drop_home(message.total)

    def _drop_home(self, total: int) -> None:
        """A link of the ardupilot persona uploads home as item 0, which the boat's own list of `total` items lacks."""
        items = self._accepted[PlanKind.MISSION]
        if total == len(items) - 1:
            self._accepted[PlanKind.MISSION] = tuple(
                replace(with_jump_moved(item, -1), seq=item.seq - 1) for item in items[1:]
            )

    def plans(self) -> dict[PlanKind, tuple[PlanItem, ...]]:
        """The plans in force at the end: uploaded during the run, else those of its start."""
        return {kind: self._accepted.get(kind) or read_plan(self._folder / "state", kind) for kind in PlanKind}

    def rows(self) -> list[tuple[str, ...]]:
        """(sender, packets, missing, share missing) of each sender, as texts."""
        found: list[tuple[str, ...]] = []
        for who, times in sorted(self._times.items()):
            if who[0] == self._own:
                found.append((_named(who) + " (this boat)", str(len(times)), "", ""))
                continue
            missing = sum(gap for _, gap in self._missing[who])
            found.append(
                (_named(who), str(len(times)), str(missing), f"{100.0 * missing / (missing + len(times)):.1f} %")
            )
        return found

    def links(self) -> list[LinkSeries]:
        """Rates of the busiest senders other than this boat."""
        others = sorted((who for who in self._times if who[0] != self._own), key=lambda who: -len(self._times[who]))[
            :_MOST_LINKS
        ]
        edges = np.arange(0.0, max(self._end_s, _BIN_S) + _BIN_S, _BIN_S)
        series = []
        for who in others:
            packets, _ = np.histogram(self._times[who], edges)
            times, gaps = zip(*self._missing[who], strict=True) if self._missing[who] else ((), ())
            missing, _ = np.histogram(times, edges, weights=gaps if gaps else None)
            series.append(LinkSeries(_named(who), edges[:-1] + 0.5 * _BIN_S, packets / _BIN_S, missing / _BIN_S))
        return series


def _named(who: tuple[int, int]) -> str:
    return f"system {who[0]}, component {who[1]}"


def _messages(path: Path, told: Told) -> Iterator[tuple[float, Any]]:
    """(time, message) of a .tlog. Bytes that cannot be read are skipped; without a file there is nothing."""
    try:
        data = path.read_bytes()
    except OSError:
        return
    at, count = 0, 0
    while at + 8 + 8 <= len(data):
        if count % _PACKETS_TOLD == 0:
            told("reading the packets", at / len(data))
        count += 1
        marker = data[at + 8]
        if marker not in (0xFD, 0xFE):
            at += 1
            continue
        length = data[at + 9]
        size = 12 + length + (13 if data[at + 10] & 1 else 0) if marker == 0xFD else 8 + length
        packet = data[at + 8 : at + 8 + size]
        for message in Framer().feed(packet):
            if not isinstance(message, UnknownMessage):
                yield _STAMP.unpack_from(data, at)[0] * 1e-6, message
        at += 8 + size


def _frame(recorded: Recorded, packets: Packets) -> LocalFrame:
    """The frame of the track: around home, or, on a boat far from home, around its first fix.

    That fix follows from a position that the boat reported and its place on the track.
    """
    home = recorded.log.config.home
    if packets.place is None:
        return LocalFrame(home.lat_deg, home.lon_deg)
    t_s, lat_deg, lon_deg = packets.place
    north_m, east_m = (float(np.interp(t_s, recorded.t_s, recorded.ticks[name])) for name in ("north_m", "east_m"))
    return LocalFrame(*LocalFrame(lat_deg, lon_deg).to_geodetic(-north_m, -east_m))


def _others(folder: Path) -> list[tuple[str, Array]]:
    """In simulation: the true tracks of lead boats, and of other vessels of a scenario, north and east of home."""
    found = []
    for path in sorted((*folder.glob("*.csv"), *folder.glob("*/truth.csv"))):
        if path.parent == folder and path.name in _OWN_FILES:
            continue
        try:
            columns = read_table(path, ("t_s", "north_m", "east_m"), [])
        except (LogError, OSError):
            continue
        name = path.stem if path.parent == folder else path.parent.name
        if columns["t_s"]:
            found.append((name, np.array([columns["north_m"], columns["east_m"]]).T))
    return found


def _chart(
    plans: dict[PlanKind, tuple[PlanItem, ...]], frame: LocalFrame, others: Sequence[tuple[str, Array]] = ()
) -> Chart:
    places = [item for item in plans[PlanKind.MISSION] if item.command in PLACES]
    waypoints = [(item.number, *frame.to_ned(item.lat_deg, item.lon_deg)) for item in places]
    zones = [
        (tuple(zip(north, east, strict=True)), inside)
        for (east, north), inside in fence_zones(plans[PlanKind.FENCE], frame)
    ]
    return Chart(waypoints, zones, others)


def _mission(recorded: Recorded, plans: dict[PlanKind, tuple[PlanItem, ...]]) -> Sequence[tuple[str, ...]]:
    reached: dict[int, float] = {}
    for event in recorded.events:
        if event.name == "item_reached":
            digits = "".join(c if c.isdigit() else " " for c in event.text).split()
            if digits:
                reached.setdefault(int(digits[0]), event.t_s)
    rows = []
    for item in plans[PlanKind.MISSION]:
        place = f"{item.lat_deg:.6f}, {item.lon_deg:.6f}" if item.command in PLACES else ""
        rows.append(
            (
                str(item.number),
                name_of(item.command),
                place,
                f"{reached[item.number]:.1f}" if item.number in reached else "",
            )
        )
    return rows
