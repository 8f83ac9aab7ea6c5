"""`companion console`: the live page of a running companion, or of a log that is played back."""

from __future__ import annotations

import argparse
import contextlib
import errno
import os
import secrets
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from companion.cli.common import UsageError, boat_folder, complain, end
from companion.feed_view import open_feed
from companion.loop import Vessel
from companion.record.feed import SOCKET
from companion.record.signing_file import SigningFileError, read_signing

if TYPE_CHECKING:
    from companion.console.server import Settings

PORT = 8080
_SYSTEM = 251
_NICE = 10
_TOKEN = "USV_CONSOLE_TOKEN"
_EXTRA = "needs {}: pip install 'usv-companion[console]'"


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    console = commands.add_parser(
        "console",
        help="a live page of the boat in a browser, or of a log that is played back",
        description="Beyond this computer (--host) the page asks for a token, which is printed at the start, or taken "
        f"from the environment variable {_TOKEN}.",
    )
    add = console.add_argument
    add("log", nargs="?", type=Path, metavar="LOGDIR", help="a log folder to play back; none: the companion that runs")
    add("--state", type=Path, metavar="DIR", help="state folder of that companion; none: the one that is found")
    add("--port", type=int, default=PORT, metavar="N", help="port of the page; 0: one that is free")
    add("--host", default="127.0.0.1", metavar="ADDRESS", help="address to listen at; 0.0.0.0: the whole network")
    add("--control", action="store_true", help="pages may command the boat")
    add("--link", metavar="URL", help="with --control: link to the boat, tcpout: or udpout:; none: as the boat says")
    add("--system-id", type=int, default=_SYSTEM, metavar="N", help="with --control: of this ground station")
    add("--chart", type=Path, metavar="FILE", help="raster tiles for the chart (PMTiles or MBTiles)")
    add("--beside", action="store_true", help=argparse.SUPPRESS)  # end with the process that started it
    console.set_defaults(command=_console)


def _console(arguments: argparse.Namespace) -> int:
    try:
        from companion.console import serving
    except ModuleNotFoundError as error:
        raise UsageError(f"console {_EXTRA.format(error.name)}") from error
    if not 0 <= arguments.port <= 65535:
        raise UsageError(f"--port {arguments.port}: 0 to 65535")
    if not 1 <= arguments.system_id <= 255:
        raise UsageError(f"--system-id {arguments.system_id}: 1 to 255")
    settings = _settings(arguments)
    with contextlib.suppress(OSError):
        os.nice(_NICE)  # the boat comes first
    try:
        return serving.serve(settings, arguments.port, arguments.beside)
    except OSError as error:
        if error.errno != errno.EADDRINUSE:
            raise
        asked = f"--{'console' if arguments.beside else 'port'} {arguments.port}"
        raise UsageError(f"{asked}: another program has it; choose another, or 0") from error


def _settings(arguments: argparse.Namespace) -> Settings:
    from companion.console.doors import is_local
    from companion.console.replay import Recording
    from companion.console.server import Settings
    from companion.console.tiles import TileError, open_tiles

    token = os.environ.get(_TOKEN) or (None if is_local(arguments.host) else secrets.token_urlsafe(12))
    try:
        tiles = None if arguments.chart is None else open_tiles(arguments.chart)
    except TileError as error:
        raise UsageError(f"--chart {error}") from error
    if arguments.log is not None:
        if arguments.control:
            raise UsageError("--control: a log cannot be commanded")
        return Settings(log=Recording(arguments.log), host=arguments.host, token=token, tiles=tiles)
    state = arguments.state or found_state()
    return Settings(
        feed=state / SOCKET,
        control=arguments.control,
        link=arguments.link,
        key=_key(state),
        system=arguments.system_id,
        host=arguments.host,
        token=token,
        tiles=tiles,
    )


def found_state() -> Path:
    """The state folder of the companion that runs; of several, the one that began last."""
    sockets = sorted(boat_folder("x").parent.glob(f"*/state/{SOCKET}"), key=lambda path: path.stat().st_mtime)
    if not sockets:
        raise UsageError("no companion runs here: start one, give its --state, or a LOGDIR to play back")
    return sockets[-1].parent


def _key(state: Path) -> bytes | None:
    """The boat's signing key, which its state folder has for those who may read it."""
    try:
        return read_signing(state)[0]
    except SigningFileError as error:
        complain(str(error))
        return None


# --- beside `companion run` ----------------------------------------------------------------------------------------


def add_option_to(parser: argparse.ArgumentParser) -> None:
    """The options of `companion run` that start a console beside it."""
    parser.add_argument(
        "--console", type=int, nargs="?", const=PORT, metavar="PORT", help="with a live page of the boat in a browser"
    )
    parser.add_argument("--control", action="store_true", help="with --console: the page may command the boat")


def add_feed(vessel: Vessel, links: Sequence[str], state: Path) -> bool:
    """Offer the boat's ticks to displays. False, with a word, where the state folder takes no socket."""
    try:
        vessel.add_recorder(open_feed(vessel, links, state))
    except OSError as error:
        complain(f"{error.filename}: {error.strerror}")
        return False
    return True


def start_console(port: int | None, state: Path, control: bool) -> subprocess.Popen[bytes] | None:
    """A console in a process of its own, which prints its address; none where `port` is None."""
    if port is None:
        return None
    command = [sys.executable, "-m", "companion", "console", f"--port={port}", f"--state={state}", "--beside"]
    return subprocess.Popen(command + ["--control"] * control, stdin=subprocess.PIPE, start_new_session=True)


def stop_console(process: subprocess.Popen[bytes] | None) -> None:
    """End a console, if there is one; its port is free afterwards."""
    if process is None:
        return
    end(process)
    if process.stdin is not None:
        process.stdin.close()
