"""`companion report LOGDIR`: one self-contained HTML file of a log."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from companion.cli.common import print_warnings


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    report = commands.add_parser(
        "report", help="one HTML file of a log: track, errors, thrusters, health, links, events"
    )
    report.add_argument("folder", type=Path, metavar="LOGDIR")
    report.add_argument("--out", type=Path, metavar="HTML", help="default: report.html in the log folder")
    report.set_defaults(command=_report)


def _report(arguments: argparse.Namespace) -> int:
    from companion.analysis.report import write_report

    out = arguments.out or arguments.folder / "report.html"
    print_warnings(write_report(arguments.folder, out))
    print(f"written: {out}")
    return 0
