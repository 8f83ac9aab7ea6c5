"""`companion report LOGDIR`: one self-contained HTML file of a log, or of a folder of scenarios' runs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from companion.analysis.log_reader import LogError
from companion.cli.common import complain, judge_out_folder, print_warnings
from companion.cli.progress import bar
from companion.core.progress import part


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    report = commands.add_parser(
        "report", help="one HTML file of a log: track, errors, thrusters, health, links, events"
    )
    report.add_argument("folder", type=Path, metavar="LOGDIR", help="a log folder")
    report.add_argument("--out", type=Path, metavar="HTML", help="default: report.html in the log folder")
    report.set_defaults(command=_report)


def leave_page(folder: Path) -> None:
    """Write the report of a scenario's log, and of each further log in it; name the page."""
    from companion.analysis.report import write_report

    for log in (folder, *sorted(path.parent for path in folder.glob("*/manifest.json"))):
        try:
            with bar("report") as told:
                write_report(log, log / "report.html", told)
        except LogError as error:
            complain(str(error))
        else:
            print(f"written: {log / 'report.html'}")


def leave_table(folder: Path) -> None:
    """Write the page of all runs below a folder, and the report of each that has none."""
    from companion.analysis.report import write_report
    from companion.analysis.table_page import runs_in, write_table

    missing = [run.folder for run in runs_in(folder) if not (run.folder / "report.html").exists()]
    with bar("reports") as told:
        for number, log in enumerate(missing):
            try:
                write_report(log, log / "report.html", part(told, number / len(missing), (number + 1) / len(missing)))
            except LogError as error:
                complain(str(error))
    count = write_table(folder, folder / "index.html")
    print(f"written: {folder / 'index.html'}, {count} runs")


def _report(arguments: argparse.Namespace) -> int:
    from companion.analysis.report import write_report

    if not (arguments.folder / "manifest.json").exists() and any(arguments.folder.glob("**/result.json")):
        leave_table(arguments.folder)
        return 0
    out = arguments.out or arguments.folder / "report.html"
    if arguments.folder.is_dir():
        judge_out_folder(out.parent)
    with bar("report") as told:
        warnings = write_report(arguments.folder, out, told)
    print_warnings(warnings)
    print(f"written: {out}")
    return 0
