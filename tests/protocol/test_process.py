"""The process as a person meets it: starting, ending, mistakes on the command line, a neighbour on the same machine, a
power cut."""

from __future__ import annotations

import contextlib
import csv
import itertools
import json
import signal
import socket
import sys
from pathlib import Path

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from tests.copies import run_to_end as companion
from tests.protocol.driver import Driver
from tests.protocol.process import Companion, free_port
from tests.waiting import CAP_S, run_to_end, wait_until

pytestmark = pytest.mark.process


def heard(port_socket: socket.socket, kind: str) -> bool:
    codec = mavlink.MAVLink(None)
    codec.robust_parsing = True
    port_socket.settimeout(CAP_S)
    return any(m.get_type() == kind for _ in range(200) for m in codec.parse_buffer(port_socket.recv(65535)) or ())


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (
            ("run", "revlot", "--sitl"),
            "no vessel named 'revlot'; bundled: aboat, blueboat, cybership2, heron, otter, rescuerunner, revolt, sailbot, wamv16",
        ),
        (("run", "no/such.toml"), "no such file"),
        (("run", "revolt", "--sitl", "--home", "north"), "write LAT,LON,HEADING_DEG"),
        (("run", "revolt", "--sitl", "--home", "63,10,inf"), "no such place"),
        (("run", "revolt", "--sitl", "--speed", "0"), "above 0"),
        (("run", "revolt", "--wind", "3"), "--sitl"),
        (("run", "revolt", "--sitl", "--fault", "kraken@10"), "kraken"),
        (("run", "revolt", "--sitl", "--link", "carrier-pigeon:1"), "carrier-pigeon"),
        (("check", "revlot"), "no vessel named"),
        (("mission", "no.plan"), "no.plan"),
        (("scenario", "run", "kraken"), "there is hold, four_corner"),
        (("scenario", "run", "hold", "--set", "wind"), "KEY=VALUE"),
        (("scenario", "run", "hold", "--set", "moon=full"), "has no setting moon"),
    ],
)
def test_a_mistake_is_one_line_that_says_what_to_do(arguments: tuple[str, ...], remedy: str, tmp_path: Path) -> None:
    extra = ("--state", str(tmp_path / "state"), "--log", str(tmp_path / "log")) if arguments[0] == "run" else ()
    done = companion(*arguments, *extra)
    assert done.returncode == 2
    assert remedy in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr


def test_check_lists_every_error_with_its_line(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "companion" / "vessels" / "revolt.toml").read_text(encoding="utf-8")
    for right, wrong in (
        ("beam_m = 0.72", "beam_m = -1.0"),
        ('kind = "fixed"', 'kind = "paddle"'),
        ("surge_n = 50.0", "surge = 50.0"),
    ):
        text = text.replace(right, wrong, 1)
    text = text.replace('driver = "mtdata2"', 'driver = "mtdata9"').replace(
        "serial:/dev/usv-gnss", "seral:/dev/usv-gnss"
    )
    text = text.replace("[parameters]", "[parameters]\nPATH_BW_SURGE = 99.0\nPATH_BW_SURGEE = 1.0")
    file = tmp_path / "boat.toml"
    file.write_text(text, encoding="utf-8")
    done = companion("check", str(file))
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 2 and len(lines) == 7, done.stderr  # a misspelt key is one mistake, not two
    assert "limits.surge: unknown key; did you mean 'surge_n'?" in done.stderr
    assert all(line.startswith(f"{file}:") for line in lines)
    assert (
        "no driver 'mtdata9'; known: ais, crsf, mavlink_imu, mavlink_range, mtdata2, nmea0183, sbus, vectornav"
        in done.stderr
        and "seral:" in done.stderr
    )
    assert "parameters.PATH_BW_SURGE" in done.stderr and "allowed 0.05 to 3 rad/s" in done.stderr
    assert run_to_end([sys.executable, "-m", "companion", "check", "revolt"]).returncode == 0


def test_a_link_that_obeys_anybody_is_said(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "companion" / "vessels" / "revolt.toml").read_text(encoding="utf-8")
    file = tmp_path / "boat.toml"
    file.write_text(text.replace("tcpin:127.0.0.1:5760", "tcpin:0.0.0.0:5760", 1), encoding="utf-8")
    remedy = "listen on 127.0.0.1, or add signing=require\n"
    done = companion("check", str(file))
    assert done.returncode == 0
    assert done.stderr == f"warning: link tcpin:0.0.0.0:5760 obeys anybody in the network: {remedy}"
    link = f"tcpin:0.0.0.0:{free_port(socket.SOCK_STREAM)}"
    boat = Companion(tmp_path, speed=5.0, links=(link,))
    with boat:
        wait_until(lambda: boat.now_s > 0.5, "the first ticks")
        assert boat.stop() == (0, f"warning: link {link} obeys anybody in the network: {remedy}")
    assert f"Link {link} obeys anybody" in {row["text"] for row in boat.rows("events.csv")}


def test_a_port_in_use_is_said(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        link = f"tcpin:127.0.0.1:{taken.getsockname()[1]}"
        done = companion("run", "revolt", "--sitl", "--link", link, "--state", str(tmp_path), "--log", str(tmp_path))
    assert done.returncode == 2 and len(done.stderr.strip().splitlines()) == 1
    assert link in done.stderr and "in use" in done.stderr


def test_missing_devices_are_said_and_the_boat_keeps_waiting_for_them(tmp_path: Path) -> None:
    """Without --sitl on a machine that has none of the devices: it runs, refuses to arm, and says what to plug in."""
    port = free_port()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind(("127.0.0.1", port))
        arguments = (
            "run",
            "revolt",
            "--link",
            f"udpout:127.0.0.1:{port}",
            "--state",
            str(tmp_path / "s"),
            "--log",
            str(tmp_path / "l"),
        )
        done = run_to_end([sys.executable, "-m", "companion", *arguments, "--duration", "2"])
        assert done.returncode == 0, done.stderr
        assert heard(station, "HEARTBEAT")
    rows = list(csv.DictReader(next((tmp_path / "l").glob("*/ticks.csv")).read_text(encoding="utf-8").splitlines()))
    assert (
        float(rows[-1]["t_s"]) > 1.5
        and {row["gnss_ok"] for row in rows} == {"0"}
        and {row["armed"] for row in rows} == {"0"}
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_every_signal_that_ends_it_ends_it_in_order(tmp_path: Path, number: signal.Signals) -> None:
    boat = Companion(tmp_path, speed=5.0, anew=True)
    with boat:
        assert boat.process is not None
        wait_until(lambda: boat.now_s > 1.0, "the first ticks")
        boat.process.send_signal(number)
        assert boat.stop() == (0, "")


def test_a_usual_boat_runs_without_scipy(tmp_path: Path) -> None:
    """It took 50 of 135 MB, for the curve through three points."""
    boat = Companion(tmp_path, speed=5.0, anew=True)
    with boat:
        assert boat.process is not None
        wait_until(lambda: boat.now_s > 2.0, "the first ticks")
        assert "/scipy/" not in Path(f"/proc/{boat.process.pid}/maps").read_text()


def test_two_companions_side_by_side(tmp_path: Path) -> None:
    first, second = (Companion(tmp_path / name, speed=5.0, anew=True) for name in "ab")
    with (
        first,
        second,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as a,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as b,
    ):
        for listener, process in ((a, first), (b, second)):
            listener.bind(("127.0.0.1", process.udp_port))
            assert heard(listener, "GLOBAL_POSITION_INT")


def test_a_link_that_waits_for_the_network_is_no_mistake(tmp_path: Path) -> None:
    """The service did not try again: a boat whose network came up after the companion had no autopilot."""
    for link in ("tcpin:192.0.2.1:5760", "udpin:192.0.2.1:14550", "udpin:no.such.host.invalid:14550"):
        done = companion("run", "revolt", "--sitl", "--link", link, "--state", str(tmp_path), "--log", str(tmp_path))
        assert done.returncode == 3 and len(done.stderr.strip().splitlines()) == 1
        assert link in done.stderr


def test_one_state_folder_serves_one_companion(tmp_path: Path) -> None:
    with Companion(tmp_path) as running:
        done = companion(
            "run",
            "revolt",
            "--sitl",
            "--state",
            str(running.folder / "state"),
            "--log",
            str(tmp_path),
            "--link",
            "udpout:127.0.0.1:9",
        )
    assert done.returncode == 2 and len(done.stderr.strip().splitlines()) == 1
    assert "--state" in done.stderr


def test_a_log_is_valid_after_a_power_cut(tmp_path: Path) -> None:
    running = Companion(tmp_path, speed=20.0).start()
    running.sail(3.0)
    running.kill()
    folder = running.log_folder
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["vessel"] == "revolt" and manifest["parameters"]["MAV_SYS_ID"] == 1
    for name in ("ticks.csv", "truth.csv"):
        header, *rows = csv.reader((folder / name).read_text(encoding="utf-8").splitlines())
        assert len(rows) > 10 and {len(row) for row in rows[:-1]} == {len(header)}
        times_s = [float(row[0]) for row in rows[:-1]]
        steps = [b - a for a, b in itertools.pairwise(times_s)]
        assert max(steps) <= 0.1 + 1e-6, "ten rows a second, none missing"
    log = mavutil.mavlink_connection(str(folder / "telemetry.tlog"))
    kinds = set()
    while (message := log.recv_msg()) is not None:
        kinds.add(message.get_type())
    log.close()
    assert {"HEARTBEAT", "ATTITUDE", "GLOBAL_POSITION_INT"} <= kinds


def test_a_corrupt_state_file_is_set_aside(tmp_path: Path) -> None:
    with Companion(tmp_path):
        pass
    for file in (tmp_path / "state").glob("*.json"):
        file.write_bytes(b'{"half a')
    (tmp_path / "state" / "parameters.json").write_bytes(b"\x00\xff")
    again = Companion(tmp_path).start()
    code, errors = again.stop()
    assert code == 0 and "parameters.json: corrupt" in errors and "set aside" in errors, errors
    assert list((tmp_path / "state").glob("parameters.json.corrupt-*"))


def test_the_service_manager_is_told_that_it_is_ready_alive_and_stopping(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        manager.settimeout(CAP_S)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        monkeypatch.setenv("WATCHDOG_USEC", "1000000")
        driver = Driver()
        with Companion(tmp_path, driver=driver) as running:
            driver.step()
            first = manager.recv(4096).decode()
            driver.run(0.3)
            second = manager.recv(4096).decode()
            running.stop()
        last = [manager.recv(4096).decode()]
        manager.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while True:
                last.append(manager.recv(4096).decode())
    assert first.startswith("READY=1\nWATCHDOG=1\nSTATUS=Manual, disarmed")
    assert second == "WATCHDOG=1"
    assert last[-1] == "STOPPING=1"
