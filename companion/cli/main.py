"""The `companion` program: its commands, one file each, and the exit code of what they do."""

from __future__ import annotations

import argparse
import importlib
import os
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from companion import native
from companion.analysis.log_reader import LogError
from companion.app import program_version
from companion.cli.common import UsageError, complain
from companion.config.vessel import ConfigError
from companion.core.nearest import did_you_mean
from companion.io.mavlink.wire.links import LinkError, NoAddress
from companion.io.transport.urls import TransportError
from companion.mission.plan_file import PlanFileError
from companion.record.state_file import StateFileBusy

_COMMANDS = (
    *("run", "new", "draw", "check", "sitl", "devices", "mission", "scenario", "sweep", "hunt", "evaluate", "leader"),
    *("replay", "identify", "calibrate", "capability", "report", "console", "script", "export", "service", "signing"),
    *("bollard", "thruster_test", "trial"),
)
"""Their modules, in the order of the help."""

_NOT_YET = 3  # the service tries again after it, as it does not after 2
_NOBODY_READS = 141  # as shells have it: 128 and the number of SIGPIPE


def main(argv: Sequence[str] | None = None) -> int:
    """Carry out a command. Returns its exit code: 0 success, 1 a check failed, 2 a mistake in the command or its files,
    3 an address that this computer does not have, or not yet.

    `argv`: the arguments after the program's name; None: those of the process.
    """
    return carry_out(parsed(sys.argv[1:] if argv is None else argv))


def parsed(words: Sequence[str]) -> argparse.Namespace:
    """What is asked for. Exits where that cannot be understood, or only help is asked for."""
    return argument_parser(words[0] if words else "").parse_args(words)


def carry_out(arguments: argparse.Namespace) -> int:
    """Carry out what is asked for, as `main`."""
    try:
        code: int = arguments.command(arguments)
        return code
    except (ConfigError, PlanFileError) as error:
        for problem in error.problems:
            print(problem, file=sys.stderr)
    except NoAddress as error:
        complain(str(error))
        return _NOT_YET
    except (UsageError, LinkError, LogError, TransportError, StateFileBusy) as error:
        complain(str(error))
    except BrokenPipeError:  # who reads, as `head`, has enough: no mistake
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _NOBODY_READS
    except OSError as error:
        complain(f"{error.filename or 'the system'}: {error.strerror or error}")
    return 2


class _Commands:
    """argparse's subparsers, each with its line in the list of commands as the first sentence of its own help."""

    def __init__(self, subparsers: Any) -> None:
        self._subparsers = subparsers

    def add_parser(self, name: str, *, help: str, description: str = "", **options: Any) -> argparse.ArgumentParser:
        """As argparse's."""
        first = f"{help[:1].upper()}{help[1:]}."
        parser: argparse.ArgumentParser = self._subparsers.add_parser(
            name, help=help, description=f"{first} {description}".strip(), **options
        )
        return parser


class _Parser(argparse.ArgumentParser):
    """Says what a misspelt command may have meant. Python does so from 3.14 on.

    `tasks`: of a command that may stand without its task: their names, and first the one that is meant then.
    """

    tasks: Sequence[str] = ()

    def parse_known_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """As argparse's, but what the command does not know is an error beside its own usage, not the program's."""
        if self.tasks and args and args[0] not in (*self.tasks, "-h", "--help"):
            args = [self.tasks[0], *args]
        known, strange = super().parse_known_args(args, namespace)
        if strange:
            meant = did_you_mean(strange[0], re.findall(r"--[\w-]+", self.format_help()))
            self.error(f"unrecognized arguments: {' '.join(strange)}{meant}")
        return known, strange

    def add_subparsers(self, **options: Any) -> Any:
        """As argparse's."""
        return _Commands(super().add_subparsers(**options))

    def error(self, message: str) -> NoReturn:
        """As argparse's."""
        wrong = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
        if wrong and "did you mean" not in message:
            message += did_you_mean(wrong[1], re.findall(r"[\w-]+", wrong[2]))
        super().error(message)


def argument_parser(command: str = "") -> argparse.ArgumentParser:
    """What can be asked on the command line: of that command, where there is one of that name, else of all. The modules
    of the others are not imported then."""
    parser = _Parser(
        prog="companion", description="Autopilot for small uncrewed boats, controlled by any MAVLink ground station."
    )
    parser.add_argument("--version", action="version", version=f"USV companion {program_version()}, {native.status}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    named = command.replace("-", "_")
    for name in (named,) if named in _COMMANDS else _COMMANDS:
        importlib.import_module(f"companion.cli.{name}").add_to(commands)
    return parser
