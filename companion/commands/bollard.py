"""`companion bollard FILE`: thrust curve of one thruster from pulls measured at the quay."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any


def add_to(commands: Any) -> None:
    """`commands` as argparse's `add_subparsers` gives it."""
    pull = commands.add_parser("bollard", help="a thruster's curve from a CSV of throttle,force_n measured at the quay, as lines for the vessel's TOML")
    pull.add_argument("file", type=Path, metavar="FILE")
    pull.add_argument("--thruster", default="thruster", metavar="NAME")
    pull.add_argument("--plot", type=Path, metavar="PNG", help="needs pip install 'usv-companion[report]'")
    pull.set_defaults(command=_bollard)


def _bollard(arguments: argparse.Namespace) -> int:
    from companion.record import bollard

    try:
        found = bollard.fit(*bollard.read_pulls(arguments.file))
    except bollard.BollardError as error:
        print(f"companion: {error}", file=sys.stderr)
        return 2
    print(bollard.report(found), bollard.toml_lines(found, arguments.thruster), sep="\n\n")
    if arguments.plot is not None:
        try:
            bollard.plot(found, arguments.thruster, arguments.plot)
            print(f"written: {arguments.plot}")
        except ImportError:
            print("no plot: that needs matplotlib (pip install 'usv-companion[report]')", file=sys.stderr)
    return 0
