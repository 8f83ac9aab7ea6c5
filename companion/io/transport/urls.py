"""URLs of ports: `scheme:address:number?key=value`, for devices and ground-station links alike."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from urllib.parse import parse_qsl

from companion.core.nearest import did_you_mean

SCHEMES = ("serial", "udpin", "udpout", "tcpin", "tcpout", "can")
DEFAULT_BAUD = 115200
_NO_BAUD = re.compile(r"\d*|\d[\d.,]* ?(k|kb|kbps|bd|baud|bps)|[5-8][NEO][12]", re.IGNORECASE)
_MISTYPED_BAUD = re.compile(r"(?=\w*\d)[\dOoIl]{4,}|\d{4,}[A-Za-z]+")  # 11520O for 115200
"""What stands behind a serial port's last colon where somebody meant a baud rate. Names by-path have colons too."""


class TransportError(Exception):
    """A port's URL that cannot be used. The message is one line with the remedy."""


@dataclass(frozen=True, slots=True)
class PortUrl:
    """A parsed URL. Serial: `path` and `baud`. CAN: `path`, the channel, and `port`. The others: `host` and `port`.
    `options`: the part after the `?`."""

    scheme: str
    host: str = ""
    port: int = 0
    path: str = ""
    baud: int = 0
    options: Mapping[str, str] = field(default_factory=dict)


def parse_url(text: str, schemes: Sequence[str] = SCHEMES) -> PortUrl:
    """`scheme:address:number?key=value&…` → its parts. Raises TransportError with one line. `schemes`: those that make
    sense there; another one is refused as if nobody knew it."""
    body, _, query = text.strip().partition("?")
    scheme, colon, rest = body.partition(":")
    if not colon or scheme not in schemes:
        known = ", ".join(name + ":" for name in schemes)
        raise TransportError(f"'{text}': should begin with one of {known}{_meant(text.strip(), scheme, rest, schemes)}")
    try:
        options = dict(parse_qsl(query, keep_blank_values=True, strict_parsing=True)) if query else {}
    except ValueError as error:
        raise TransportError(f"'{text}': options should read ?key=value&key=value") from error
    address, _, number = rest.rpartition(":")
    if scheme == "serial":
        return _serial_endpoint(text, rest, address, number, options)
    if scheme == "can":
        return _can_endpoint(text, rest, address, number, options)
    if not address or not (number.isascii() and number.isdigit()):
        raise TransportError(f"'{text}': should read {scheme}:host:port")
    if not 0 <= int(number) <= 65535:
        raise TransportError(f"'{text}': port {number} should be 0 to 65535")
    return PortUrl(scheme, host=address.removeprefix("[").removesuffix("]"), port=int(number), options=options)


def _meant(text: str, scheme: str, rest: str, schemes: Sequence[str]) -> str:
    """The URL that was probably meant, to end a refusal with; empty where nobody knows."""
    if text.startswith("/dev/"):
        return f"; did you mean 'serial:{text}'?"
    if scheme in ("udp", "tcp") and rest:
        return f"; {scheme}out: sends to that address, {scheme}in: listens there"
    return did_you_mean(scheme, schemes)


def _serial_endpoint(text: str, rest: str, address: str, number: str, options: Mapping[str, str]) -> PortUrl:
    """The baud rate may be left out; device paths may hold colons themselves (`/dev/serial/by-path/…:1.0-port0`)."""
    with_baud = number.isascii() and number.isdigit() and bool(address)
    path, baud = (address, int(number)) if with_baud else (rest, DEFAULT_BAUD)
    if not path.startswith("/") or (not with_baud and _NO_BAUD.fullmatch(number)):
        raise TransportError(f"'{text}': should read serial:/dev/name:baud, as serial:/dev/usv-gnss:115200")
    if not with_baud and _MISTYPED_BAUD.fullmatch(number):
        raise TransportError(f"'{text}': baud rate {number} should be digits alone, as 115200")
    if not 50 <= baud <= 12_000_000:
        raise TransportError(f"'{text}': baud rate {baud} should be 50 to 12000000")
    return PortUrl("serial", path=path, baud=baud, options=options)


def _can_endpoint(text: str, rest: str, address: str, number: str, options: Mapping[str, str]) -> PortUrl:
    """A channel, with a port where its interface has one."""
    with_port = number.isascii() and number.isdigit() and bool(address)
    channel, port = (address, int(number)) if with_port else (rest, 0)
    if not channel:
        raise TransportError(f"'{text}': should read can:channel, as can:can0")
    if port > 65535:
        raise TransportError(f"'{text}': port {number} should be 0 to 65535")
    return PortUrl("can", path=channel, port=port, options=options)
