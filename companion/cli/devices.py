"""`companion devices`: what is plugged in, what it sends, and the lines for it in a vessel's file."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from companion.cli.common import UsageError
from companion.config.vessel import VesselConfig
from companion.core.microcontroller_frame import BoardStatus, Ident
from companion.io.formats import LineFormat
from companion.io.listening import PortListener, hear_out, listen, real_time_s
from companion.io.recognise import Recognised
from companion.io.transport.opener import device_endpoint
from companion.io.transport.port_names import PortName, named, ports

_USUAL_HZ = (1.0, 2.0, 4.0, 5.0, 10.0, 20.0, 25.0, 50.0, 100.0, 200.0, 400.0)
_GCS, _NO_AUTOPILOT = 6, 8  # MAV_TYPE, MAV_AUTOPILOT
_FIXES = ("GGA", "RMC", "GNS", "GLL")
_FORMATS = {  # driver: what it reads
    "nmea0183": LineFormat.NMEA,
    "ais": LineFormat.AIS,
    "mtdata2": LineFormat.MTDATA2,
    "vectornav": LineFormat.NMEA,
    "mavlink_imu": LineFormat.MAVLINK,
    "mavlink_servo": LineFormat.MAVLINK,
    "microcontroller": LineFormat.BOARD,
}
_SILENT = (
    "silent: without power, or it only answers when asked, as stepper drives on RS485 (Nanotec), "
    "or it has nothing to send (AIS without traffic)"
)
_NAMES = {
    "the GNSS receiver": "gnss",
    "the inertial sensor": "imu",
    "the wind sensor": "wind",
    "the compass": "compass",
    "the echo sounder or log": "sounder",
    "the rudder sensor": "rudder",
    "an NMEA device": "nmea",
}


_OWN_YAW = ['# heading = "magnetic"    # where it is the compass: its own yaw; "true", or "ahrs" by its raw field']
_CONFIGURE = "configure = true    # it sends another message than VNYMR"


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    devices = commands.add_parser(
        "devices",
        help="what is plugged in, and the lines for it in a vessel's file",
        description="Listens on every serial port that no other program uses. Writes to none. "
        "Opening a port resets some Arduino boards.",
    )
    devices.add_argument(
        "--port", action="append", type=Path, metavar="PATH", help="listen on this one alone; may be repeated"
    )
    devices.add_argument("--seconds", type=float, default=3.0, metavar="S", help="shortest time to listen on each")
    devices.set_defaults(command=_devices)


def _devices(arguments: argparse.Namespace) -> int:
    """Exit code 1 where there is no port, or nothing comes from those that were named."""
    if not 0.5 <= arguments.seconds <= 600.0:
        raise UsageError(f"--seconds {arguments.seconds:g}: must be 0.5 to 600")
    found = ports() if arguments.port is None else [named(path) for path in arguments.port]
    if not found:
        print("no serial port on this computer: plug a device in, or use --port PATH")
        return 1
    print(f"listening on {len(found)} port{'s' if len(found) > 1 else ''}; nothing is written to any", flush=True)
    taken: set[str] = set()
    heard = False
    for port, listener in zip(found, listen([port.name for port in found], arguments.seconds), strict=True):
        aside = ", ".join(text for text in (str(port.device) if port.device != port.name else "", port.about) if text)
        print(f"\n{port.name}{f' ({aside})' if aside else ''}")
        for line in described(port, listener, taken):
            print(f"  {line}")
        heard = heard or bool(listener.recogniser.bytes)
    return 0 if heard or arguments.port is None else 1


def described(port: PortName, listener: PortListener, taken: set[str]) -> list[str]:
    """What a port received, and its lines of TOML. `taken`: names of devices already used, to which this adds."""
    if listener.fault is not None:
        return [listener.fault]
    if not listener.recogniser.bytes:
        return [_SILENT]
    verdict = listener.recogniser.verdict
    notes = [port.note] if port.note else []
    if verdict is None:
        guess = listener.recogniser.guess or "no known format at any usual speed: a maker's own binary, or a bad wire"
        return [f"{listener.recogniser.bytes} bytes in {listener.heard_s:.1f} s: {guess}", *notes]
    rates = ", ".join(f"{name} {count / listener.heard_s:.1f}/s" for name, count in verdict.kinds)
    lines = [f"{verdict.device}: {verdict.format.value} at {listener.baud} baud: {rates}", *_more(verdict), *notes]
    return lines + toml_lines(verdict, f"serial:{port.name}:{listener.baud}", listener.heard_s, taken)


def toml_lines(verdict: Recognised, url: str, heard_s: float, taken: set[str]) -> list[str]:
    """The table for a device in a vessel's file; comments mark what a person has to fill in."""
    match verdict.format:
        case LineFormat.NMEA:
            driver = "vectornav" if verdict.device == "the inertial sensor" else "nmea0183"
            own = _OWN_YAW if driver == "vectornav" else []
            if driver == "vectornav" and "YMR" not in verdict.types:
                own = [_CONFIGURE, *own]
            return _sensor(_NAMES[verdict.device], driver, url, taken, [*_nmea_lines(verdict, heard_s), *own])
        case LineFormat.AIS:
            return _sensor("ais", "ais", url, taken, [])
        case LineFormat.MTDATA2:
            rate = _rate(sum(count for _, count in verdict.kinds), heard_s)
            return _sensor("imu", "mtdata2", url, taken, [rate, *_OWN_YAW])
        case LineFormat.BOARD:
            status = verdict.notes.get("status")
            n = len(status.thrusters) if isinstance(status, BoardStatus) else 0
            thrusters = ", ".join(f'"thruster_{i + 1}"' for i in range(n))
            name = _free("microcontroller", taken)
            head = ["[[actuator]]", f'name = "{name}"', 'driver = "microcontroller"', f'port = "{url}"']
            return [*head, f"thrusters = [{thrusters}]    # as the vessel's file names them, in the board's order"]
        case LineFormat.MAVLINK:
            return [f'links = ["{url}"]    # if ground stations are at its other end']
        case LineFormat.RTCM:
            return ["[[corrections]]", f'port = "{url}"']
        case _:
            return []


def _nmea_lines(verdict: Recognised, heard_s: float) -> list[str]:
    types = {name[2:]: count for name, count in reversed(verdict.kinds)}
    if verdict.device != "the GNSS receiver":
        return [_rate(max(types.values()), heard_s)]
    fixes = next((types[name] for name in _FIXES if name in types), 0)
    return [f"antennas = {2 if {'HDT', 'THS'} & types.keys() else 1}", *([_rate(fixes, heard_s)] if fixes else [])]


def _rate(count: int, heard_s: float) -> str:
    """The usual rate near the measured one, else the measured one."""
    heard_hz = count / heard_s
    usual_hz = min(_USUAL_HZ, key=lambda rate_hz: abs(heard_hz - rate_hz))
    return f"rate_hz = {usual_hz if abs(heard_hz - usual_hz) < max(0.15 * usual_hz, 0.4) else max(heard_hz, 0.1):.1f}"


def _sensor(name: str, driver: str, url: str, taken: set[str], lines: Sequence[str]) -> list[str]:
    return ["[[sensor]]", f'name = "{_free(name, taken)}"', f'driver = "{driver}"', f'port = "{url}"', *lines]


def _free(name: str, taken: set[str]) -> str:
    chosen, n = name, 2
    while chosen in taken:
        chosen, n = f"{name}_{n}", n + 1
    taken.add(chosen)
    return chosen


def _more(verdict: Recognised) -> list[str]:
    """Further lines for people: settings to change, versions, who sends."""
    match verdict.format:
        case LineFormat.MTDATA2 if not any(
            {"acceleration", "rate of turn"} <= set(name.split(", ")) for name, _ in verdict.kinds
        ):
            return ["have it send acceleration and rate of turn as well (in MT Manager: output configuration)"]
        case LineFormat.XSENS:
            return ["have it send MTData2 (in MT Manager: output configuration)"]
        case LineFormat.UBX:
            return ["have it send NMEA 0183 (in u-center: GGA, RMC, VTG)"]
        case LineFormat.BOARD if isinstance(ident := verdict.notes.get("identity"), Ident):
            return [f"firmware {'.'.join(map(str, ident.firmware))}, {ident.thrusters} thrusters"]
        case LineFormat.MAVLINK if (heartbeat := verdict.notes.get("HEARTBEAT")) is not None:
            return [_who(heartbeat)]
        case _:
            return []


def _who(heartbeat: Any) -> str:
    who = f"system {heartbeat.get_srcSystem()}, component {heartbeat.get_srcComponent()}"
    if heartbeat.type == _GCS:
        return f"{who}: a ground station, through a telemetry radio"
    return f"{who}: {'a component of a vehicle' if heartbeat.autopilot == _NO_AUTOPILOT else 'an autopilot'}"


# --- check --listen ------------------------------------------------------------------------------------------------


def listen_to(config: VesselConfig, seconds: float, wait: Callable[[], float] = real_time_s) -> list[tuple[bool, str]]:
    """Listen to each device of a vessel on a serial port: whether it is what the file says, and a line about it.

    Writes to no port. `wait`: as of `hear_out`.
    """
    rows = [(row.name, row.driver, row.port) for row in config.sensors] + [
        (row.name, row.driver, row.port) for row in config.actuators
    ]
    endpoints = [(name, driver, port, device_endpoint(port)) for name, driver, port in rows]
    serial = [row for row in endpoints if row[3].scheme == "serial"]
    listeners = hear_out(
        [PortListener(Path(row[3].path), seconds, (row[3].baud,), row[3].options) for row in serial], wait
    )
    return [
        _judged(name, driver, port, listener)
        for (name, driver, port, _), listener in zip(serial, listeners, strict=True)
    ]


def _judged(name: str, driver: str, port: str, listener: PortListener) -> tuple[bool, str]:
    where, expected = f"{name}: {port}", _FORMATS.get(driver)
    verdict = listener.recogniser.verdict
    if listener.fault is not None:
        return False, f"{where}: {listener.fault}"
    if verdict is None:
        guess = listener.recogniser.guess or "of no known format: is the baud rate right?"
        heard = f"{listener.recogniser.bytes} bytes, {guess}"
        return expected is None, f"{where}: {heard if listener.recogniser.bytes else _SILENT}"
    if expected is None:
        return True, f"{where}: {verdict.text}"
    return (
        verdict.format is expected,
        f"{where}: {verdict.text if verdict.format is expected else listener.recogniser.guess}",
    )
