"""What systemd is told, on a socket as systemd has one."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from companion.cli.leader import Reporting
from companion.io.service_manager import ServiceManager, service_manager
from tests.unit.record.ticks import tick


@pytest.fixture
def manager_socket(tmp_path: Path) -> Iterator[tuple[str, socket.socket]]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        listening.setblocking(False)
        yield str(tmp_path / "notify"), listening


def said(listening: socket.socket) -> list[str]:
    lines: list[str] = []
    while True:
        try:
            lines += listening.recv(4096).decode().split("\n")
        except BlockingIOError:
            return lines


def test_ready_comes_with_the_first_tick_and_stopping_at_the_end(manager_socket: tuple[str, socket.socket]) -> None:
    address, listening = manager_socket
    manager = ServiceManager(address, 2.0)
    assert said(listening) == []
    manager.record(tick(0.1))
    first = said(listening)
    assert first[:2] == ["READY=1", "WATCHDOG=1"]
    assert first[2] == "STATUS=Hold, armed, RTK_FIXED; not well: imu"
    manager.record(tick(0.2))
    assert said(listening) == []
    manager.close()
    assert said(listening) == ["STOPPING=1"]


def test_the_watchdog_hears_each_quarter_of_its_patience(manager_socket: tuple[str, socket.socket]) -> None:
    address, listening = manager_socket
    manager = ServiceManager(address, 2.0)
    kicks = 0
    for n in range(101):
        manager.record(tick(0.1 * n))
        kicks += said(listening).count("WATCHDOG=1")
    manager.close()
    assert 19 <= kicks <= 21


def test_a_leader_modules_status_line_is_its_sign_of_life(manager_socket: tuple[str, socket.socket]) -> None:
    address, listening = manager_socket
    shown: list[str] = []
    display = SimpleNamespace(show=lambda line, now_s: shown.append(line), fileno=lambda: None, typed=lambda: "m")
    manager = ServiceManager(address, 2.0)
    reporting = Reporting(display, manager)  # type: ignore[arg-type]
    reporting.show("fix, link 0", 0.2)
    assert said(listening) == ["READY=1", "WATCHDOG=1", "STATUS=fix, link 0"]
    reporting.show("fix, link 1", 0.8)
    assert said(listening) == ["WATCHDOG=1"] and shown == ["fix, link 0", "fix, link 1"]
    assert (reporting.fileno(), reporting.typed()) == (None, "m")
    manager.close()


def test_no_watchdog_asked_for_none_kicked(manager_socket: tuple[str, socket.socket]) -> None:
    address, listening = manager_socket
    manager = ServiceManager(address)
    lines: list[str] = []
    for n in range(50):
        manager.record(tick(0.1 * n))
        lines += said(listening)
    manager.close()
    assert lines[0] == "READY=1" and "WATCHDOG=1" not in lines


def test_an_abstract_socket(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind("\0" + str(tmp_path))
        listening.setblocking(False)
        manager = ServiceManager("@" + str(tmp_path))
        manager.record(tick(0.0))
        assert said(listening)[0] == "READY=1"
        manager.close()


def test_nobody_listening_harms_nothing(tmp_path: Path) -> None:
    manager = ServiceManager(str(tmp_path / "nobody"), 2.0)
    manager.record(tick(0.0))
    manager.close()


def test_the_environment_says_where_and_whose_watchdog(tmp_path: Path) -> None:
    address = str(tmp_path / "notify")
    assert service_manager({}) is None
    assert service_manager({"NOTIFY_SOCKET": "relative"}) is None
    ours = service_manager({"NOTIFY_SOCKET": address, "WATCHDOG_USEC": "2000000", "WATCHDOG_PID": "7"}, process=7)
    theirs = service_manager({"NOTIFY_SOCKET": address, "WATCHDOG_USEC": "2000000", "WATCHDOG_PID": "8"}, process=7)
    odd = service_manager({"NOTIFY_SOCKET": address, "WATCHDOG_USEC": "soon"}, process=7)
    for manager, kicks in ((ours, 4), (theirs, 0), (odd, 0)):
        assert manager is not None
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
            listening.bind(address)
            listening.setblocking(False)
            lines: list[str] = []
            for n in range(20):  # two seconds
                manager.record(tick(0.1 * n))
                lines += said(listening)
            assert lines.count("WATCHDOG=1") == kicks
            manager.close()
        Path(address).unlink()
