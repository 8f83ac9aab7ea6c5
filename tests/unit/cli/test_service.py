"""The systemd service: what is written, and that systemd itself finds nothing wrong with it."""

from __future__ import annotations

import configparser
import shutil
import subprocess
from pathlib import Path

import pytest

from companion.app import load_vessel
from companion.cli import service
from companion.cli.main import main
from companion.cli.service import UNIT, UsbDevice, closed_to_others, rules, unit, users
from companion.leader_module.app import load_leader
from companion.leader_module.config import find_leader
from tests.waiting import CAP_S


def parsed(text: str) -> configparser.ConfigParser:
    parser = configparser.ConfigParser(interpolation=None, strict=True)
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read_string(text)
    return parser


def test_the_unit_runs_the_vessel_with_a_watchdog_and_keeps_to_its_own_user() -> None:
    read = parsed(unit("revolt", ["udpout:10.0.0.2:14550"], 4000, "/opt/usv/bin/python"))
    run = read["Service"]
    assert run["ExecStart"] == (
        "/opt/usv/bin/python -m companion run revolt --state /var/lib/usv-companion/state --log /var/log/usv-companion "
        "--log-limit 4000 --realtime --link udpout:10.0.0.2:14550"
    )
    assert (run["Type"], run["User"], run["SupplementaryGroups"], run["Restart"]) == (
        "notify",
        "usv",
        "dialout",
        "always",
    )
    assert float(run["WatchdogSec"]) > 1.0 and run["RestartPreventExitStatus"] == "2"
    assert run["ProtectHome"] == "yes"
    assert read["Install"]["WantedBy"] == "multi-user.target"


def test_the_unit_of_a_leader_module_runs_it_with_its_gamepad() -> None:
    read = parsed(
        unit("viknes", ["serial:/dev/usv-radio:57600"], 500, "/opt/usv/bin/python", (), load_leader("viknes"))
    )
    run = read["Service"]
    assert run["ExecStart"] == (
        "/opt/usv/bin/python -m companion leader viknes --state /var/lib/usv-companion/state "
        "--log /var/log/usv-companion --log-limit 500 --link serial:/dev/usv-radio:57600"
    )
    assert (run["Type"], run["SupplementaryGroups"]) == ("notify", "dialout input") and float(run["WatchdogSec"]) > 1.0
    assert "leader module viknes" in read["Unit"]["Description"]


def test_a_leader_module_is_installed_from_its_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """There was no form for it: people wrote units of their own, without watchdog and without names of adapters."""
    own = tmp_path / "lead.toml"
    own.write_text(find_leader("viknes").read_text(encoding="utf-8"), encoding="utf-8")
    root = tmp_path / "root"
    assert main(["service", "install", str(own), "--leader", "--root", str(root)]) == 0
    assert f"companion leader {own} " in (root / service._UNIT_FILE).read_text()
    named = (root / service._RULES_FILE).read_text()
    assert all(f"# /dev/{name}: " in named for name in ("usv-gnss", "usv-imu", "usv-radio"))
    assert main(["service", "install", str(own), "--root", str(root)]) == 2
    assert "companion leader" in capsys.readouterr().err, "a module's file is none of a vessel"


def test_an_installation_in_a_home_is_read_from_there() -> None:
    assert parsed(unit("revolt", [], 4000, "/home/pi/usv/.venv/bin/python"))["Service"]["ProtectHome"] == "read-only"


def test_an_interpreter_in_a_home_behind_a_link_is_read_from_there() -> None:
    text = unit("revolt", [], 4000, "/opt/usv/bin/python", [Path("/root/.local/share/uv/python/bin/python3.12")])
    assert parsed(text)["Service"]["ProtectHome"] == "read-only"


def test_a_home_that_the_service_may_not_enter_is_said(tmp_path: Path) -> None:
    """As homes are on Debian: the service ended with 203/EXEC each second."""
    home, file = tmp_path / "home", tmp_path / "home" / "usv" / "boat.toml"
    file.parent.mkdir(parents=True)
    file.touch(0o644)

    def said() -> list[str]:
        return [line for line in closed_to_others([file, file, home / "no such file"]) if line.startswith(str(home))]

    home.chmod(0o755)
    assert said() == []
    home.chmod(0o700)
    assert said() == [f"{home}: user usv may not enter it, and the service needs to: chmod o+x {home}"]
    home.chmod(0o701)
    file.chmod(0o600)
    assert said() == [f"{file}: user usv may not read it, and the service needs to: chmod o+r {file}"]


def test_odd_paths_are_quoted_for_systemd() -> None:
    command = parsed(unit("/srv/my boats/50% $HOME.toml", [], 1, "/usr/bin/python3"))["Service"]["ExecStart"]
    assert '"/srv/my boats/50%% $$HOME.toml"' in command


@pytest.mark.skipif(
    shutil.which("systemd-analyze") is None,
    reason="systemd-analyze is not installed; the keys are checked by the tests above",
)
def test_systemd_finds_no_fault_with_the_unit(tmp_path: Path) -> None:
    file = tmp_path / UNIT
    file.write_text(unit("revolt", [], 4000, "/bin/sh"), encoding="utf-8")
    done = subprocess.run(
        ["systemd-analyze", "verify", str(file)], capture_output=True, text=True, check=False, timeout=CAP_S
    )
    if "Failed to" in done.stderr and "bus" in done.stderr:
        pytest.skip(f"systemd-analyze cannot work here: {done.stderr.strip()}")
    assert done.returncode == 0 and UNIT not in done.stderr, done.stderr


def test_rules_name_what_is_known_and_ask_for_what_is_not() -> None:
    text = rules(
        load_vessel("revolt"),
        {"usv-gnss": UsbDevice(0x1546, 0x01A9, "A1"), "usv-radio": UsbDevice(0x0403, 0x6001, None)},
    )
    gnss, imu, mcu, radio = text.splitlines()[1:]
    assert 'ATTRS{idVendor}=="1546"' in gnss and 'ATTRS{serial}=="A1"' in gnss and 'SYMLINK+="usv-gnss"' in gnss
    assert imu.startswith("# /dev/usv-imu") and mcu.startswith("# /dev/usv-mcu")
    assert "serial}" not in radio and 'ATTRS{idProduct}=="6001"' in radio


def test_a_second_installation_keeps_the_names_given_by_the_first() -> None:
    vessel = load_vessel("revolt")
    first = rules(vessel, {"usv-gnss": UsbDevice(0x1546, 0x01A9, "A1"), "usv-mcu": UsbDevice(0x2341, 0x0042, "B1")})
    gnss, imu, mcu = rules(
        vessel, {"usv-imu": UsbDevice(0x2639, 0x0300, "C1"), "usv-mcu": UsbDevice(0x2341, 0x0042, "B2")}, first
    ).splitlines()[1:]
    assert 'SYMLINK+="usv-gnss"' in gnss and '"A1"' in gnss
    assert 'SYMLINK+="usv-imu"' in imu and '"B2"' in mcu


def test_where_systemd_does_not_run_all_is_taken_away_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A container with systemd's tools, where none of them can do anything."""
    files = tuple(tmp_path / file.name for file in service._FILES)
    monkeypatch.setattr(service, "_BOOTED", tmp_path / "no such folder")
    monkeypatch.setattr(service, "_FILES", files)
    monkeypatch.setattr(service, "_UNIT_FILE", files[0])
    for file in files:
        file.write_text("", encoding="utf-8")
    assert main(["service", "remove"]) == 0
    assert not any(tmp_path.iterdir())
    with pytest.raises(service.ServiceError, match="does not run systemd"):
        service._activate(start=True)


def test_the_user_may_open_serial_ports() -> None:
    assert "m usv dialout" in users().splitlines()


def test_install_status_and_remove_leave_nothing_behind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["service", "install", "aboat", "--root", str(tmp_path)]) == 0
    files = sorted(path for path in tmp_path.rglob("*") if path.is_file())
    assert len(files) == 3
    capsys.readouterr()
    assert main(["service", "status", "--root", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines() == [f"there: {tmp_path / file}" for file in service._FILES]
    assert main(["service", "remove", "--root", str(tmp_path)]) == 0
    assert not any(path.is_file() for path in tmp_path.rglob("*"))
    assert main(["service", "remove", "--root", str(tmp_path)]) == 0


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (["revlot"], "no vessel named"),
        (["revolt", "--link", "pigeon:1"], "pigeon"),
        (["revolt", "--link", "udpout:10.0.0.2:14550?dialect=px5"], "px5"),
        (["revolt", "--link", "can:can0"], "CAN"),
        (["revolt", "--device", "usv-gnss"], "NAME=PATH"),
        (["revolt", "--device", "usv-gnss=/dev/null"], "no USB serial device"),
        (["revolt", "--log-limit", "0"], "at least 1 MB"),
    ],
)
def test_a_mistake_installs_nothing(
    arguments: list[str], remedy: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["service", "install", *arguments, "--root", str(tmp_path)]) == 2
    assert remedy in capsys.readouterr().err
    assert not any(tmp_path.iterdir())


def test_without_the_rights_the_remedy_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(self: Path, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "write_text", refuse)
    assert main(["service", "install", "revolt", "--root", str(tmp_path)]) == 2
    assert "sudo" in capsys.readouterr().err


def test_what_systemd_refuses_is_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service.shutil, "which", lambda name: "/bin/false")
    with pytest.raises(service.ServiceError, match="exit code 1"):
        service._systemd("false")
    monkeypatch.setattr(service.shutil, "which", lambda name: None)
    with pytest.raises(service.ServiceError, match="does not run systemd"):
        service._systemd("systemctl")
