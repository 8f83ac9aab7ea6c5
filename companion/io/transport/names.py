"""Names of hosts: looked up beside the control thread, since that may take seconds, and again when a line is lost."""

from __future__ import annotations

import re
import socket
import threading

from companion.io.transport.threads import begun

LOCALHOST = "127.0.0.1"
LOOK_AGAIN_S = 30.0  # for the address of a peer that is not heard
_LOOK_SOON_S = 5.0  # for a name that has no address yet
_LABEL = re.compile(r"(?!-)[A-Za-z0-9_-]{1,63}(?<!-)")


class NameUnknown(OSError):
    """A name without an address. Its text is complete."""


def look_up(host: str) -> str:
    """The IPv4 address of a host, as the system finds it (hosts file, mDNS, DNS). Raises OSError, UnicodeError."""
    return str(socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_DGRAM)[0][4][0])


def is_address(host: str) -> bool:
    """Whether `host` is an IPv4 or IPv6 address."""
    for family in (socket.AF_INET, socket.AF_INET6):
        try:
            socket.inet_pton(family, host)
        except OSError:
            continue
        return True
    return False


def is_name(host: str) -> bool:
    """Whether `host` can be a host's name. A name that ends in a number is a mistyped address."""
    labels = host.removesuffix(".").split(".")
    return len(host) <= 253 and all(map(_LABEL.fullmatch, labels)) and not labels[-1].isdigit()


class Host:
    """The address of a host. An IP address is its own; a name is looked up by each `seek`.

    Remembers the newest address, also when a later look-up fails: a name server may be gone while the host is not.
    """

    def __init__(self, host: str) -> None:
        self.host = host
        self.fixed = is_address(host) or host == "localhost"
        self.address: str | None = (LOCALHOST if host == "localhost" else host) if self.fixed else None
        self._failed = False
        self._due_s: float | None = None
        self._seeking: threading.Thread | None = None

    @property
    def seeking(self) -> bool:
        """Whether a look-up is under way."""
        return self._seeking is not None and self._seeking.is_alive()

    @property
    def fault(self) -> str | None:
        """What is wrong with the name, in words; None where the newest look-up found it."""
        if self.address is None and self.seeking and not self._failed:
            return f"looking up '{self.host}'"
        if not self._failed:
            return None
        if self.address is None:
            return f"'{self.host}' has no address in this network; is that computer on, is the name right?"
        return f"'{self.host}' is not found any more; its last address {self.address} is tried"

    def seek(self) -> None:
        """Begin to look the name up, unless that is under way. Returns at once."""
        if self.fixed or self.seeking:
            return
        self._seeking = begun(self._look, f"look-up {self.host}")
        self._failed = self._failed or self._seeking is None

    def keep_up(self, silent: bool, now_s: float, patience: float = 1.0) -> None:
        """Look the name up again now and then while its host is `silent`. `patience`: factor on the time until then,
        where vessel time runs fast."""
        if self.fixed or self.seeking:
            return
        if not silent:
            self._due_s = None
        elif self._due_s is None:
            self._due_s = now_s + patience * (_LOOK_SOON_S if self.address is None else LOOK_AGAIN_S)
        elif now_s >= self._due_s:
            self._due_s = None
            self.seek()

    def found(self) -> str:
        """The address. Raises NameUnknown where no look-up has found one."""
        if self.address is None:
            raise NameUnknown(self.fault or f"'{self.host}' was not looked up")
        return self.address

    def _look(self) -> None:
        try:
            self.address, self._failed = look_up(self.host), False
        except (OSError, UnicodeError):
            self._failed = True
