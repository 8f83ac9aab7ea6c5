"""`companion calibrate LOGDIR`: a magnetometer's hard and soft iron from recorded turns."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from companion.analysis.log_reader import open_sensor_log
from companion.cli.common import add_time_span, judge_out_folder, print_warnings


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    calibrate = commands.add_parser(
        "calibrate", help="a magnetometer's hard and soft iron from recorded turns, as lines for the vessel's TOML"
    )
    calibrate.add_argument("folder", type=Path, metavar="LOGDIR", help="a log folder")
    calibrate.add_argument("--sensor", metavar="NAME", help="which one, where the log has several magnetometers")
    add_time_span(calibrate)
    calibrate.add_argument(
        "--out", type=Path, metavar="DIR", help="for magnetometer.toml and magnetometer.png; default: the log folder"
    )
    calibrate.set_defaults(command=_calibrate)


def _calibrate(arguments: argparse.Namespace) -> int:
    from companion.analysis.calibrate import calibrate

    log, out = open_sensor_log(arguments.folder), arguments.out or arguments.folder
    judge_out_folder(out)
    found = calibrate(log, out, arguments.sensor, arguments.from_s, arguments.to_s)
    print_warnings(found.warnings)
    print(found.report, found.toml, sep="\n\n")
    print(f"written: {out}")
    return 0
