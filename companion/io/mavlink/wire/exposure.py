"""Links on which anybody in the network can command the boat."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterable

from companion.io.mavlink.wire.link_options import parse_options
from companion.io.mavlink.wire.signing import Policy
from companion.io.transport.urls import TransportError, parse_url

_LISTENING = ("tcpin", "udpin")


def exposed(url: str) -> bool:
    """Whether a link listens beyond this computer and does not require signatures. False for a URL that cannot be used,
    which is told elsewhere."""
    try:
        parsed = parse_url(url)
        _, options = parse_options(parsed.options)
    except TransportError:
        return False
    return parsed.scheme in _LISTENING and options.signing is not Policy.REQUIRE and not _local(parsed.host)


def exposed_warnings(urls: Iterable[str]) -> list[str]:
    """One line with the remedy for each link that is exposed."""
    remedy = "listen on 127.0.0.1, or add signing=require"
    return [f"link {url} obeys anybody in the network: {remedy}" for url in urls if exposed(url)]


def _local(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
