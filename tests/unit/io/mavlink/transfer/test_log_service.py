"""Logs asked for by blocks of 90 bytes, as QGroundControl, MAVSDK and MAVProxy each do it."""

from __future__ import annotations

import os
import random
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.transfer.disk_files import LogStore
from companion.io.mavlink.transfer.log_service import BLOCK, LogService
from tests.forbidden import forbid
from tests.waiting import wait_until

SIZES = {"a": 90 * 20, "b": 1234, "c": 300_000}


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    draws = random.Random(3)
    for n, (name, size) in enumerate(SIZES.items()):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "manifest.json").write_bytes(b"{}")
        os.utime(folder / "manifest.json", (1_700_000_000 + 100 * n, 1_700_000_000 + 100 * n))
        (folder / "telemetry.tlog").write_bytes(b"not this one")
        (folder / "ticks.ulg").write_bytes(draws.randbytes(size))
    (tmp_path / "no_log").mkdir()
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "manifest.json").write_bytes(b"{}")
    return tmp_path


class Desk:
    def __init__(self, desk: Any, logs: Path | None) -> None:
        self.desk = desk
        self.service = LogService(desk.hub, desk.vessel, None if logs is None else LogStore(logs, "c"))
        desk.serve(self.service)
        self.now_s = 0.0
        self.who = "qgc"

    def tell(self, message: Any) -> list[Any]:
        self.desk.tell(message, self.desk.peer(self.who))
        return self.heard()

    def heard(self) -> list[Any]:
        return [message for _, message in self.desk.heard()]

    def until(self, kind: str, count: int) -> list[Any]:
        found: list[Any] = []

        def enough() -> bool:
            self.now_s += 0.05
            self.service.update(self.now_s)
            found.extend(m for m in self.heard() if m.get_type() == kind)
            return len(found) >= count

        wait_until(enough, f"{count} {kind}; the disk is read by a thread")
        return found

    def entries(self, start: int = 0, end: int = 0xFFFF, count: int = 3) -> list[Any]:
        first = self.tell(self.desk.messages.MAVLink_log_request_list_message(1, 1, start, end))
        return first + self.until("LOG_ENTRY", count - len(first)) if len(first) < count else first

    def data(self, number: int, offset: int, count: int, blocks: int) -> list[Any]:
        first = self.tell(self.desk.messages.MAVLink_log_request_data_message(1, 1, number, offset, count))
        return first + self.until("LOG_DATA", blocks - len(first)) if len(first) < blocks else first


@pytest.fixture
def station(desk: Desk, logs: Path) -> Any:
    made = Desk(desk, logs)
    yield made
    made.service.close()


def test_the_runs_are_listed_oldest_first(station: Desk) -> None:
    entries = station.entries()
    assert [(e.id, e.num_logs, e.last_log_num, e.size, e.time_utc) for e in entries] == [
        (n, 3, 2, size, 1_700_000_000 + 100 * n) for n, size in enumerate(SIZES.values())
    ]
    (only,) = station.entries(1, 1, count=1)
    assert only.id == 1


def test_a_folder_that_cannot_be_read_hides_no_others(
    station: Desk, logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """lost+found at the top of a medium belongs to root."""
    (logs / "lost+found").mkdir()
    forbid(logs / "lost+found", monkeypatch)
    assert len(station.entries()) == 3
    station.tell(station.desk.messages.MAVLink_log_erase_message(1, 1))
    wait_until(lambda: not (logs / "a").exists() and not (logs / "b").exists(), "earlier logs are erased")


def test_ardupilots_clients_count_from_one(station: Desk) -> None:
    station.who = "rover"
    assert [e.id for e in station.entries()] == [1, 2, 3]


def test_without_logs_one_empty_entry(desk: Desk) -> None:
    station = Desk(desk, None)
    (entry,) = station.tell(desk.messages.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF))
    assert (entry.id, entry.num_logs, entry.size) == (0, 0, 0)
    station.service.close()


def test_a_log_comes_in_windows_as_qgroundcontrol_asks(station: Desk, logs: Path) -> None:
    station.entries()
    expected = (logs / "c" / "ticks.ulg").read_bytes()
    got = b""
    while len(got) < len(expected):
        window = min(512 * BLOCK, len(expected) - len(got))
        blocks = station.data(2, len(got), 512 * BLOCK, -(-window // BLOCK))
        assert [block.ofs for block in blocks] == list(range(len(got), len(got) + window, BLOCK))
        got += b"".join(bytes(block.data)[: block.count] for block in blocks)
        assert all(block.count > 0 for block in blocks)
    assert got == expected


def test_all_at_once_ends_with_an_empty_block_where_the_last_is_full(station: Desk, logs: Path) -> None:
    station.entries()
    blocks = station.data(0, 0, 0xFFFFFFFF, 21)
    assert [block.count for block in blocks] == [BLOCK] * 20 + [0]
    assert b"".join(bytes(block.data)[: block.count] for block in blocks) == (logs / "a" / "ticks.ulg").read_bytes()
    blocks = station.data(1, 0, 0xFFFFFFFF, 14)
    assert blocks[-1].count == 1234 % BLOCK


def test_a_gap_is_sent_again_and_the_end_stops(station: Desk, logs: Path) -> None:
    station.entries()
    (block,) = station.data(1, 180, BLOCK, 1)
    assert bytes(block.data) == (logs / "b" / "ticks.ulg").read_bytes()[180:270]
    station.tell(station.desk.messages.MAVLink_log_request_data_message(1, 1, 2, 0, 0xFFFFFFFF))
    station.tell(station.desk.messages.MAVLink_log_request_end_message(1, 1))
    station.service.update(station.now_s + 0.1)
    assert station.heard() == []


def test_a_log_comes_without_a_list_before_it(station: Desk, logs: Path) -> None:
    """MAVProxy's `log download 1` asks once, also when the list is long ago or was never asked for."""
    number, size = 1, SIZES["b"]
    for _ in range(2):
        blocks = station.data(number, 0, 0xFFFFFFFF, size // BLOCK + 1)
        assert b"".join(bytes(b.data[: b.count]) for b in blocks) == (logs / "b" / "ticks.ulg").read_bytes()
        station.now_s += 100.0  # so long that the client is forgotten
        station.service.update(station.now_s)
        station.desk.now_s = station.now_s


def test_an_unknown_number_is_refused(station: Desk, logs: Path) -> None:
    station.entries()
    (said,) = station.tell(station.desk.messages.MAVLink_log_request_data_message(1, 1, 77, 0, 90))
    assert "Log 77 not found" in said.text


def test_a_log_that_is_gone_is_refused(station: Desk, logs: Path) -> None:
    station.entries()
    (logs / "b" / "ticks.ulg").unlink()
    station.tell(station.desk.messages.MAVLink_log_request_data_message(1, 1, 1, 0, 90))
    (said,) = station.until("STATUSTEXT", 1)
    assert "no longer there" in said.text


def test_erase_leaves_the_running_log_and_what_is_no_log(station: Desk, logs: Path) -> None:
    """QGroundControl asks for the list again at once."""
    (logs / "a" / "state").mkdir()
    (logs / "a" / "state" / "plan.json").write_bytes(b"{}")
    (logs / "elsewhere").symlink_to(logs / "b", target_is_directory=True)
    station.entries()
    assert station.tell(station.desk.messages.MAVLink_log_erase_message(1, 1)) == []
    (entry,) = station.entries(count=1)
    assert (entry.id, entry.num_logs, entry.size) == (0, 1, SIZES["c"])
    assert sorted(path.name for path in logs.iterdir()) == ["c", "elsewhere", "no_log"]
    assert station.desk.texts() == ["Logs erased: 3, 0 MB"]
    assert station.data(0, 0, 90, 1)[0].count == 90, "number 0 is another log now"


def test_a_download_under_way_ends_well(station: Desk, logs: Path) -> None:
    station.entries()
    station.data(1, 0, 90, 1)
    station.tell(station.desk.messages.MAVLink_log_erase_message(1, 1))
    wait_until(lambda: not (logs / "b").exists(), "erased")
    assert b"".join(bytes(m.data[: m.count]) for m in station.data(1, 90, 900, 10))[:900]


def test_an_armed_boat_keeps_its_logs(station: Desk, logs: Path) -> None:
    station.desk.supervisor.armed = True
    (said,) = station.tell(station.desk.messages.MAVLink_log_erase_message(1, 1))
    assert said.text == "Logs not erased: disarm first" and (logs / "a").exists()
