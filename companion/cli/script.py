"""`companion script FILE`: one script by hand, on the companion that runs, with its output in the terminal."""

from __future__ import annotations

import argparse
import contextlib
import json
import socket
import tempfile
import time
from pathlib import Path
from typing import Any

from companion.cli.common import Interrupt, UsageError
from companion.cli.console import found_state
from companion.core.decision import TextKind
from companion.io.transport.urls import TransportError, parse_url
from companion.record.feed import SOCKET, address_of
from companion.scripting.keeper import KeptScript, ScriptKeeper
from companion.scripting.keeping import Keeping
from companion.scripting.runner import Settings

_SYSTEM = 230
_LOOK_S = 0.1
_HELLO_S = 5.0
_LONGEST_HELLO = 1 << 20


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    script = commands.add_parser(
        "script",
        help="run a Python script on the companion that runs",
        description="The script is a client like any other, with a system id of its own. Those that [[script]] in the "
        "vessel file lists start with the boat.",
    )
    add = script.add_argument
    add("file", type=Path, metavar="FILE", help="a Python file with a function main(boat)")
    add("arguments", nargs="*", metavar="WORD", help="words for the script: boat.arguments")
    add("--state", type=Path, metavar="DIR", help="state folder of that companion; none: the one that is found")
    add("--link", metavar="URL", help="link to the boat, tcpout:HOST:PORT; none: as the boat says")
    add("--system-id", type=int, default=_SYSTEM, metavar="N", help="of the script")
    add("--folder", type=Path, metavar="DIR", help="where it may write; none: a new folder that is then deleted")
    add("--watchdog", type=float, default=10.0, metavar="S", help="kill it when it hangs for so long; 0: never")
    add("--memory", type=int, default=512, metavar="MB", help="address space of each of its processes")
    script.set_defaults(command=_script)


def _script(arguments: argparse.Namespace) -> int:
    if not arguments.file.is_file():
        raise UsageError(f"{arguments.file}: no such file")
    if not 1 <= arguments.system_id <= 255:
        raise UsageError(f"--system-id {arguments.system_id}: 1 to 255")
    if not arguments.watchdog >= 0.0:
        raise UsageError(f"--watchdog {arguments.watchdog:g}: 0 or more")
    if not 64 <= arguments.memory <= 65536:
        raise UsageError(f"--memory {arguments.memory}: 64 to 65536 MB")
    feed = (arguments.state or found_state()) / SOCKET
    address = _address(arguments.link, feed)
    interrupt = Interrupt()
    with contextlib.ExitStack() as stack:
        folder = arguments.folder or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="script-")))
        folder.mkdir(parents=True, exist_ok=True)
        settings = Settings(
            file=str(arguments.file.absolute()),
            arguments=tuple(arguments.arguments),
            system=arguments.system_id,
            feed=str(feed.absolute()),
            folder=str(folder.absolute()),
            keeper=0,
            status=-1,
            address=address,
            memory_mb=arguments.memory,
        )
        return _kept(settings, arguments.file.stem, arguments.watchdog, interrupt)


def _kept(settings: Settings, name: str, watchdog_s: float, interrupt: Interrupt) -> int:
    """Run it once. Returns 0 if it ended well, 1 otherwise."""
    script = KeptScript(name, Keeping(name, "never", watchdog_s, 1.0), settings)
    failed = False

    def say(now_s: float, kind: TextKind, event: str, text: str) -> None:
        nonlocal failed
        failed = failed or kind is TextKind.ATTENTION
        print(text, flush=True)

    keeper = ScriptKeeper([script], say, lambda: True)
    try:
        while not interrupt.received and not keeper.over:
            time.sleep(_LOOK_S)
            keeper.announce(0.0)
    finally:
        keeper.close()
    keeper.announce(0.0)
    return int(failed)


def _address(link: str | None, feed: Path) -> tuple[str, int]:
    """Host and port of the boat's link. Raises UsageError."""
    for url in (link,) if link is not None else _links_of(feed):
        try:
            endpoint = parse_url(url)
        except TransportError as error:
            if link is not None:
                raise UsageError(f"--link {error}") from error
            continue
        if endpoint.scheme == ("tcpout" if link is not None else "tcpin"):
            host = "127.0.0.1" if endpoint.host in ("0.0.0.0", "::") else endpoint.host
            if "dialect=" not in url or endpoint.options.get("dialect") == "px4":
                return host, endpoint.port
    if link is not None:
        raise UsageError(f"--link {link}: should read tcpout:HOST:PORT")
    raise UsageError("the boat has no tcpin: link; give --link, or the boat tcpin:127.0.0.1:5760")


def _links_of(feed: Path) -> list[str]:
    """The links that the companion names in its feed. Raises UsageError where none runs."""
    try:
        with address_of(feed) as address, socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as reader:
            reader.settimeout(_HELLO_S)
            reader.connect(address)
            data = b""
            while b"\n" not in data and len(data) < _LONGEST_HELLO and (more := reader.recv(65536)):
                data += more
    except OSError as error:
        raise UsageError(f"no companion runs: {feed}: {error.strerror or error}") from error
    try:
        return [str(url) for url in json.loads(data.split(b"\n")[0]).get("links", ())]
    except ValueError:
        return []
