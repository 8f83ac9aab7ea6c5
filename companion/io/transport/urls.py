"""URLs of ports: `scheme:address:number?key=value`, for devices and ground-station links alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import parse_qsl

SCHEMES = ("serial", "udpin", "udpout", "tcpin", "tcpout", "can")
DEFAULT_BAUD = 115200


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


def parse_url(text: str) -> PortUrl:
    """`scheme:address:number?key=value&…` → its parts. Raises TransportError with one line."""
    body, _, query = text.strip().partition("?")
    scheme, colon, rest = body.partition(":")
    if not colon or scheme not in SCHEMES:
        raise TransportError(f"'{text}': should begin with one of {', '.join(name + ':' for name in SCHEMES)}")
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


def _serial_endpoint(text: str, rest: str, address: str, number: str, options: Mapping[str, str]) -> PortUrl:
    """The baud rate may be left out; device paths may hold colons themselves (`/dev/serial/by-path/…:1.0-port0`)."""
    with_baud = number.isascii() and number.isdigit() and bool(address)
    path, baud = (address, int(number)) if with_baud else (rest, DEFAULT_BAUD)
    if not path:
        raise TransportError(f"'{text}': should read serial:/dev/name:baud")
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
