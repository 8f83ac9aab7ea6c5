"""The `companion` program: its commands, one file each, and the exit code of what they do."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from companion.analysis.log_reader import LogError
from companion.app import program_version
from companion.cli import (
    bollard,
    calibrate,
    check,
    devices,
    identify,
    leader,
    mission,
    replay,
    report,
    run,
    scenario,
    service,
    signing,
    sitl,
    thruster_test,
)
from companion.cli.common import UsageError, complain
from companion.config.vessel import ConfigError
from companion.io.mavlink.wire.links import LinkError
from companion.io.transport.urls import TransportError
from companion.mission.plan_file import PlanFileError
from companion.record.state_file import StateFileBusy

_COMMANDS = (
    run,
    check,
    sitl,
    devices,
    mission,
    scenario,
    leader,
    replay,
    identify,
    calibrate,
    report,
    service,
    signing,
    bollard,
    thruster_test,
)


def main(argv: Sequence[str] | None = None) -> int:
    """Carry out a command. Returns its exit code: 0 success, 1 a check failed, 2 a mistake in the command or its files.

    `argv`: the arguments after the program's name; None: those of the process.
    """
    arguments = argument_parser().parse_args(argv)
    try:
        code: int = arguments.command(arguments)
        return code
    except (ConfigError, PlanFileError) as error:
        for problem in error.problems:
            print(problem, file=sys.stderr)
    except (UsageError, LinkError, LogError, TransportError, StateFileBusy) as error:
        complain(str(error))
    except OSError as error:
        complain(f"{error.filename or 'the system'}: {error.strerror or error}")
    return 2


def argument_parser() -> argparse.ArgumentParser:
    """What can be asked on the command line."""
    parser = argparse.ArgumentParser(
        prog="companion", description="Autopilot for small uncrewed boats, controlled by any MAVLink ground station."
    )
    parser.add_argument("--version", action="version", version=f"USV companion {program_version()}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for module in _COMMANDS:
        module.add_to(commands)
    return parser
