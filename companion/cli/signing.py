"""`companion signing set | clear | status VESSEL`: the key that signs MAVLink packets, from a passphrase."""

from __future__ import annotations

import argparse
import getpass
import hashlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from companion.app import load_vessel
from companion.cli.common import UsageError, boat_folder, complain
from companion.config.vessel import ConfigError
from companion.leader_module.app import load_leader
from companion.record.signing_file import FILE, SigningFileError, read_signing, write_signing
from companion.record.state_file import StateFile


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    signing = commands.add_parser("signing", help="the key with which MAVLink packets are signed")
    verbs = signing.add_subparsers(required=True, metavar="set | clear | status")
    rows: tuple[tuple[str, str, Callable[[argparse.Namespace], int]], ...] = (
        ("set", "set it from a passphrase, typed or on standard input", _set),
        ("clear", "delete it", _clear),
        ("status", "say whether there is one", _status),
    )
    for name, text, command in rows:
        verb = verbs.add_parser(name, help=text)
        verb.add_argument(
            "vessel", metavar="VESSEL", help="as for `companion run`, or CONFIG as for `companion leader`"
        )
        verb.add_argument("--sitl", action="store_true", help="for the simulated boat")
        verb.add_argument("--state", type=Path, metavar="DIR", help="folder of parameters, plans and the key")
        verb.set_defaults(command=command)


def key_of(passphrase: str) -> bytes:
    """The 32-byte key of a passphrase, SHA-256 of its text, as MAVProxy, Mission Planner and QGroundControl make it."""
    return hashlib.sha256(passphrase.encode()).digest()


def _directory(arguments: argparse.Namespace) -> Path:
    if arguments.state is not None:
        return Path(arguments.state)
    return boat_folder(_name(arguments.vessel), arguments.sitl) / "state"


def _name(vessel: str) -> str:
    """The name of a vessel or of a leader module. Raises ConfigError, the vessel's where it is neither."""
    try:
        return load_vessel(vessel).name
    except ConfigError as error:
        try:
            return load_leader(vessel).name
        except ConfigError:
            raise error from None


def _set(arguments: argparse.Namespace) -> int:
    directory = _directory(arguments)
    key = key_of(_passphrase())
    _keep(directory, key)
    print(f"{directory / FILE}: key set; links with ?signing=accept or ?signing=require use it from the next start")
    return 0


def _clear(arguments: argparse.Namespace) -> int:
    directory = _directory(arguments)
    _keep(directory, None)
    print(f"{directory / FILE}: no key; links with ?signing=require accept no packets")
    return 0


def _status(arguments: argparse.Namespace) -> int:
    directory = _directory(arguments)
    try:
        key, _ = read_signing(directory)
    except SigningFileError as error:
        complain(str(error))
        return 1
    print(f"{directory / FILE}: {'no key' if key is None else 'a key is set'}")
    return 0


def _keep(directory: Path, key: bytes | None) -> None:
    """Write the key. Raises StateFileBusy while a companion runs there, which would overwrite the key; OSError."""
    warnings: list[str] = []
    state = StateFile(directory, warnings.append)
    try:
        if warnings:
            raise UsageError(warnings[0])
        write_signing(directory, key, _horizon(directory, key))
    finally:
        state.close()


def _horizon(directory: Path, key: bytes | None) -> int:
    """The time before which packets are refused: kept with the same key, so that its old packets stay refused."""
    try:
        kept, horizon = read_signing(directory)
    except SigningFileError:
        return 0
    return horizon if kept == key else 0


def _passphrase() -> str:
    if not sys.stdin.isatty():
        passphrase = sys.stdin.readline().rstrip("\r\n")
    else:
        try:
            passphrase, again = getpass.getpass("passphrase: "), getpass.getpass("again: ")
        except EOFError as error:  # Ctrl-D
            raise UsageError("no passphrase; nothing was changed") from error
        if passphrase != again:
            raise UsageError("the two differ; nothing was changed")
    if not passphrase:
        raise UsageError("the passphrase is empty; nothing was changed")
    return passphrase
