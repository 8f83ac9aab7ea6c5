"""`companion bollard FILE`: thrust curve of one thruster from pulls measured at the quay."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from companion.analysis.figure import MATPLOTLIB_MISSING
from companion.cli.common import UsageError
from companion.cli.progress import bar


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    bollard = commands.add_parser(
        "bollard",
        help="a thruster's curve from a CSV of throttle,force_n measured at the quay, as lines for the vessel's TOML",
    )
    bollard.add_argument("file", type=Path, metavar="FILE")
    bollard.add_argument("--thruster", default="thruster", metavar="NAME")
    bollard.add_argument("--plot", type=Path, metavar="PNG", help="needs pip install 'usv-companion[report]'")
    bollard.set_defaults(command=_bollard)


def _bollard(arguments: argparse.Namespace) -> int:
    from companion.analysis import bollard

    try:
        with bar("fitting the curve"):
            found = bollard.fit(*bollard.read_pulls(arguments.file))
    except bollard.BollardError as error:
        raise UsageError(str(error)) from error
    print(bollard.report(found), bollard.toml_lines(found, arguments.thruster), sep="\n\n")
    if arguments.plot is not None:
        try:
            with bar("drawing"):
                bollard.plot(found, arguments.thruster, arguments.plot)
            print(f"written: {arguments.plot}")
        except ImportError:
            print(f"no plot: {MATPLOTLIB_MISSING}", file=sys.stderr)
    return 0
