"""`companion service install | status | remove`: the companion, or a leader module, as a systemd service on a boat's
computer."""

from __future__ import annotations

import argparse
import os
import re
import shutil
import stat
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import companion
from companion.app import load_vessel
from companion.cli.common import UsageError, print_warnings
from companion.cli.realtime import CONTROL
from companion.config.vessel import VesselConfig, find
from companion.io.mavlink.wire.links import judge_url
from companion.io.transport.urls import parse_url
from companion.leader_module.app import load_leader
from companion.leader_module.config import LeaderConfig, find_leader

UNIT = "usv-companion.service"
_USER = "usv"
_UNIT_FILE = Path("etc/systemd/system") / UNIT
_USER_FILE = Path("etc/sysusers.d/usv-companion.conf")
_RULES_FILE = Path("etc/udev/rules.d/99-usv-companion.rules")
_FILES = (_UNIT_FILE, _USER_FILE, _RULES_FILE)
_BOOTED = Path("/run/systemd/system")  # exists while systemd runs the computer (sd_booted(3))
_NO_SYSTEMD = "this computer does not run systemd"
_WRITTEN = "The files are written; start `companion run` by other means"
_PRIORITY = f"""\
# before all other programs, as far as `--realtime` asks for it: the program raises its own threads
Nice=-10
LimitRTPRIO={CONTROL}
LimitMEMLOCK=infinity
CPUWeight=1000
IOWeight=1000
# when memory runs out, others go first
OOMScoreAdjust=-900
MemoryMin=200M
LimitNOFILE=4096
"""
_STATE, _LOGS = "/var/lib/usv-companion", "/var/log/usv-companion"
STATE_FOLDER = Path(_STATE) / "state"


class ServiceError(UsageError):
    """Why the service cannot be installed or removed, and what to do."""


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    service = commands.add_parser("service", help="have systemd run a vessel, or a leader module, with its computer")
    verbs = service.add_subparsers(required=True, metavar="install | status | remove")
    install = verbs.add_parser("install", help="write the unit, its user and the names of its devices, and start it")
    install.add_argument("vessel", metavar="VESSEL", help="or with --leader the CONFIG of a leader module")
    install.add_argument("--leader", action="store_true", help="run `companion leader`, the module on a lead boat")
    install.add_argument("--link", action="append", default=[], metavar="URL", help="replaces the links of the file")
    install.add_argument(
        "--log-limit", type=int, default=4000, metavar="MB", help="delete the oldest logs beyond it (default 4000)"
    )
    install.add_argument(
        "--device",
        action="append",
        default=[],
        metavar="NAME=PATH",
        help="give the USB device that is now PATH the fixed name /dev/NAME",
    )
    install.add_argument("--no-start", action="store_true", help="install only; it starts with the next boot")
    status = verbs.add_parser("status", help="what is installed, and whether it runs")
    remove = verbs.add_parser("remove", help="stop it and delete what was installed; logs and parameters stay")
    for verb, command in ((install, _install), (status, _status), (remove, _remove)):
        verb.add_argument(
            "--root",
            type=Path,
            default=Path("/"),
            metavar="DIR",
            help="another root, for the image of a memory card; nothing is started there",
        )
        verb.set_defaults(command=command)


@dataclass(frozen=True, slots=True)
class UsbDevice:
    """What identifies a USB serial adapter: vendor, product and, if it has one, serial number."""

    vendor_id: int
    product_id: int
    serial: str | None


def _command(vessel: str, links: list[str], log_limit_mb: int, python: str, leader: bool) -> str:
    places = ["--state", f"{_STATE}/state", "--log", _LOGS, "--log-limit", str(log_limit_mb)]
    program = ["leader", vessel, *places] if leader else ["run", vessel, *places, "--realtime"]
    parts = [python, "-m", "companion", *program]
    for link in links:
        parts += ["--link", link]
    return " ".join(map(_quoted, parts))


def unit(
    vessel: str,
    links: list[str],
    log_limit_mb: int,
    python: str,
    reads: Sequence[Path] = (),
    leader: LeaderConfig | None = None,
) -> str:
    """Text of the systemd unit. `vessel`: a bundled name or an absolute path; `python`: the interpreter to run;
    `reads`: what else it needs, without symbolic links. `leader`: `vessel` is that leader module."""
    command = _command(vessel, links, log_limit_mb, python, leader is not None)
    what = f"USV companion, autopilot of {vessel}" if leader is None else f"USV companion, leader module {vessel}"
    groups = "dialout" if leader is None or leader.joystick is None else "dialout input"
    places = (python, vessel, *map(str, reads))
    home = "read-only" if any(place.startswith(("/home/", "/root/")) for place in places) else "yes"
    return f"""[Unit]
Description={what}
After=network.target
StartLimitIntervalSec=0

[Service]
Type=notify
NotifyAccess=main
ExecStart={command}
User={_USER}
SupplementaryGroups={groups}
StateDirectory=usv-companion
LogsDirectory=usv-companion
WorkingDirectory={_STATE}
Environment=PYTHONUNBUFFERED=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
# every tick resets this watchdog; the thruster boards have watchdogs of their own that trip much earlier
WatchdogSec=3
TimeoutStartSec=60
Restart=always
RestartSec=1
# restarting does not correct a mistake in the vessel's file; a network that comes up late ends it with 3
RestartPreventExitStatus=2
KillSignal=SIGTERM
TimeoutStopSec=10
{_PRIORITY}NoNewPrivileges=yes
ProtectSystem=strict
ProtectHome={home}
PrivateTmp=yes
ProtectKernelTunables=yes
ProtectKernelModules=yes
ProtectControlGroups=yes
RestrictSUIDSGID=yes
LockPersonality=yes
RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK AF_CAN

[Install]
WantedBy=multi-user.target
"""


def closed_to_others(files: Sequence[Path]) -> list[str]:
    """A line for each folder on the way to `files` that other users may not enter, and for each file that they may not
    read: homes are often so."""
    found: dict[Path, str] = {}
    for file in files:
        for folder in reversed(file.parents):
            if not _mode(folder) & stat.S_IXOTH:
                found[folder] = f"{folder}: user {_USER} may not enter it, and the service needs to: chmod o+x {folder}"
        if not _mode(file) & stat.S_IROTH:
            found[file] = f"{file}: user {_USER} may not read it, and the service needs to: chmod o+r {file}"
    return list(found.values())


def _mode(path: Path) -> int:
    """What may be done with it; all where it is not there."""
    try:
        return path.stat().st_mode
    except OSError:
        return 0o777


def users() -> str:
    """Text for systemd-sysusers: a separate user that may open serial ports."""
    return f'u {_USER} - "USV companion" {_STATE}\nm {_USER} dialout\n'


def rules(config: VesselConfig | LeaderConfig, devices: dict[str, UsbDevice], before: str = "") -> str:
    """Text of the udev rules: a fixed name for each device in `devices`, a comment for each other name in the
    vessel's file. `before`: the rules of an earlier installation; its rules for other names are kept."""
    lines = ["# Fixed names of the boat's serial devices. ModemManager ignores them."]
    kept = {
        found[1]: line for line in before.splitlines() if (found := re.search(r'^SUBSYSTEM.*SYMLINK\+="([^"]+)"', line))
    }
    for name in sorted({*devices, *_names(config), *kept}):
        device = devices.get(name)
        if device is None and name in kept:
            lines.append(kept[name])
            continue
        if device is None:
            lines.append(
                f"# /dev/{name}: plug it in, find it with `companion devices`, "
                f"then install again with --device {name}=/dev/serial/by-id/…"
            )
            continue
        serial = f', ATTRS{{serial}}=="{device.serial}"' if device.serial else ""
        lines.append(
            f'SUBSYSTEM=="tty", ATTRS{{idVendor}}=="{device.vendor_id:04x}", '
            f'ATTRS{{idProduct}}=="{device.product_id:04x}"{serial}, '
            f'SYMLINK+="{name}", GROUP="dialout", MODE="0660", ENV{{ID_MM_DEVICE_IGNORE}}="1"'
        )
    return "\n".join(lines) + "\n"


def _names(config: VesselConfig | LeaderConfig) -> set[str]:
    """Names /dev/usv-… in the file: no kernel gives them, so a rule has to."""
    if isinstance(config, LeaderConfig):
        others = config.local_links
    else:
        others = tuple(bridge.port for bridge in config.actuators)
    urls = (*(sensor.port for sensor in config.sensors), *others, *config.links)
    paths = [parse_url(url).path for url in urls if url.startswith("serial:")]
    return {path.removeprefix("/dev/") for path in paths if path.startswith("/dev/usv-")}


def _usb_device(path: str) -> UsbDevice:
    """The adapter at `path`. Raises ServiceError where there is no USB serial device."""
    from serial.tools import list_ports

    real = os.path.realpath(path)
    for port in list_ports.comports():
        if os.path.realpath(port.device) == real and port.vid is not None and port.pid is not None:
            return UsbDevice(port.vid, port.pid, port.serial_number)
    raise ServiceError(f"{path}: no USB serial device; `companion devices` lists what is plugged in")


def _install(arguments: argparse.Namespace) -> int:
    leader = load_leader(arguments.vessel) if arguments.leader else None
    config = load_vessel(arguments.vessel) if leader is None else leader
    path = find(arguments.vessel) if leader is None else find_leader(arguments.vessel)
    vessel = arguments.vessel if Path(arguments.vessel).suffix != ".toml" else str(path.resolve())
    for link in arguments.link:
        judge_url(link)
    if arguments.log_limit < 1:
        raise ServiceError(f"--log-limit {arguments.log_limit}: must be at least 1 MB")
    devices: dict[str, UsbDevice] = {}
    for entry in arguments.device:
        name, equals, where = entry.partition("=")
        if not equals or not name.replace("-", "").replace("_", "").isalnum():
            raise ServiceError(f"--device {entry}: write NAME=PATH, as usv-gnss=/dev/ttyUSB0")
        devices[name] = _usb_device(where)
    rules_file = arguments.root / _RULES_FILE
    before = rules_file.read_text(encoding="utf-8") if rules_file.is_file() else ""
    reads = [Path(sys.executable).resolve(), Path(companion.__file__).resolve(), path.resolve()]
    texts = {
        _UNIT_FILE: unit(vessel, arguments.link, arguments.log_limit, sys.executable, reads, leader),
        _USER_FILE: users(),
        _RULES_FILE: rules(config, devices, before),
    }
    for file, text in texts.items():
        target = arguments.root / file
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")
        except PermissionError as error:
            raise ServiceError(
                f"{target}: permission denied; run this with sudo, "
                f"as `sudo {sys.executable} -m companion service install …`"
            ) from error
        print(f"written: {target}")
    if arguments.root == Path("/"):
        print_warnings(closed_to_others([Path(sys.executable), *reads]))
        _activate(start=not arguments.no_start)
    return 0


def _activate(start: bool) -> None:
    if not _BOOTED.is_dir():
        raise ServiceError(f"{_NO_SYSTEMD}. {_WRITTEN}")
    _systemd("systemd-sysusers", _USER_FILE.name)
    _systemd("udevadm", "control", "--reload")
    _systemd("udevadm", "trigger", "--subsystem-match=tty")
    _systemd("systemctl", "daemon-reload")
    _systemd("systemctl", "enable", *(("--now",) if start else ()), UNIT)


def _systemd(*command: str) -> None:
    """Run one of systemd's tools. Raises ServiceError with its output."""
    if shutil.which(command[0]) is None:
        raise ServiceError(f"{command[0]} not found: {_NO_SYSTEMD}. {_WRITTEN}")
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ServiceError(
            f"`{' '.join(command)}`: {(done.stderr or done.stdout).strip() or f'exit code {done.returncode}'}"
        )


def _status(arguments: argparse.Namespace) -> int:
    """Exit code 0 while it runs, 1 otherwise."""
    for file in _FILES:
        print(f"{'there' if (arguments.root / file).exists() else 'not there'}: {arguments.root / file}")
    if arguments.root != Path("/"):
        return 0
    if shutil.which("systemctl") is None:
        print(_NO_SYSTEMD)
        return 1
    done = subprocess.run(
        ["systemctl", "--no-pager", "--lines=5", "status", UNIT], capture_output=True, text=True, check=False
    )
    print((done.stdout or done.stderr).strip())
    return 0 if done.returncode == 0 else 1


def _remove(arguments: argparse.Namespace) -> int:
    here = arguments.root == Path("/") and _BOOTED.is_dir()
    if here and (arguments.root / _UNIT_FILE).exists():
        _systemd("systemctl", "disable", "--now", UNIT)
    for file in _FILES:
        target = arguments.root / file
        try:
            target.unlink()
            print(f"removed: {target}")
        except FileNotFoundError:
            continue
        except PermissionError as error:
            raise ServiceError(f"{target}: permission denied; run this with sudo") from error
    if here:
        _systemd("systemctl", "daemon-reload")
        _systemd("udevadm", "control", "--reload")
    print(f"left in place: {_STATE}, {_LOGS}, the user {_USER}")
    return 0


def _quoted(part: str) -> str:
    """An argument as systemd reads it: % and $ doubled, in quotes where needed."""
    part = part.replace("%", "%%").replace("$", "$$")
    if part and all(c.isalnum() or c in "/._-:=@,+%$?&" for c in part):
        return part
    return '"' + part.replace("\\", "\\\\").replace('"', '\\"') + '"'
