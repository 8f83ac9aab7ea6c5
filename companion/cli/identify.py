"""`companion identify LOGDIR`: a hull from a recorded manoeuvre, as lines for the vessel's TOML."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from companion.analysis.log_reader import open_log
from companion.cli.common import add_time_span, print_warnings


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    identify = commands.add_parser(
        "identify", help="inertia, damping and thrust from a recorded manoeuvre, as lines for the vessel's TOML"
    )
    identify.add_argument("folder", type=Path, metavar="LOGDIR")
    add_time_span(identify)
    identify.add_argument(
        "--hold",
        action="append",
        default=[],
        metavar="NAME",
        help="leave a quantity at the model's value, by its name in the report",
    )
    identify.add_argument(
        "--out", type=Path, metavar="DIR", help="for identified.toml and identified.png; default: the log folder"
    )
    identify.set_defaults(command=_identify)


def _identify(arguments: argparse.Namespace) -> int:
    from companion.analysis.identify import identify

    out = arguments.out or arguments.folder
    found = identify(open_log(arguments.folder), out, arguments.from_s, arguments.to_s, arguments.hold)
    print_warnings(found.warnings)
    print(found.report, found.toml, sep="\n\n")
    print(f"written: {out}")
    return 0
