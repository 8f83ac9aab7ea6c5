"""What is done with a recorded log: `companion replay`, `companion identify`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from companion.record.log_reader import open_log


def add_to(commands: Any) -> None:
    """`commands` as argparse's `add_subparsers` gives it."""
    again = commands.add_parser("replay", help="the recorded readings of a log through today's estimator")
    again.add_argument("folder", type=Path, metavar="LOGDIR")
    again.add_argument("--all", action="store_true", dest="whole", help="through today's control and allocation too, by the recorded setpoints")
    again.add_argument("--out", type=Path, metavar="CSV", help="default: replay.csv in the log folder")
    again.add_argument("--tolerance", type=float, default=1e-9, metavar="D", help="largest difference from the log for exit code 0, in SI units")
    again.set_defaults(command=_replay)

    hull = commands.add_parser("identify", help="inertia, damping and thrust from a recorded manoeuvre, as lines for the vessel's TOML")
    hull.add_argument("folder", type=Path, metavar="LOGDIR")
    hull.add_argument("--from", type=float, default=0.0, metavar="S", dest="from_s", help="leave out what was before, in the boat's time")
    hull.add_argument("--to", type=float, default=float("inf"), metavar="S", dest="to_s")
    hull.add_argument("--hold", action="append", default=[], metavar="NAME", help="leave a quantity at the model's value, by its name in the report")
    hull.add_argument("--out", type=Path, metavar="DIR", help="for identified.toml and identified.png; default: the log folder")
    hull.set_defaults(command=_identify)


def _replay(arguments: argparse.Namespace) -> int:
    from companion.record.replay import replay

    out = arguments.out or arguments.folder / "replay.csv"
    result = replay(open_log(arguments.folder), out, arguments.whole)
    for warning in result.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    print(result.report())
    if arguments.whole:
        print("modes and guidance were not run again: the setpoints are the recorded ones")
    print(f"written: {out}")
    return 0 if result.largest_in_log() <= arguments.tolerance else 1


def _identify(arguments: argparse.Namespace) -> int:
    from companion.record.identify import identify

    out = arguments.out or arguments.folder
    found = identify(open_log(arguments.folder), out, arguments.from_s, arguments.to_s, arguments.hold)
    for warning in found.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    print(found.report, found.toml, sep="\n\n")
    print(f"written: {out}")
    return 0
