"""What is done with a recorded log: `companion replay`, `companion identify`, `companion calibrate`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.record.log_reader import open_log


def add_to(commands: Any) -> None:
    """`commands` as argparse's `add_subparsers` gives it."""
    again = commands.add_parser("replay", help="a recorded log through today's code")
    again.add_argument("folder", type=Path, metavar="LOGDIR")
    again.add_argument("--all", action="store_true", dest="whole", help="the whole tick again, with what ground stations sent: modes, guidance, control")
    again.add_argument("--out", type=Path, metavar="PATH", help="a CSV, default replay.csv in the log folder; with --all a log folder, default replay/ in it")
    again.add_argument("--tolerance", type=float, default=1e-9, metavar="D", help="largest difference from the log for exit code 0, in SI units")
    again.set_defaults(command=_replay)

    hull = commands.add_parser("identify", help="inertia, damping and thrust from a recorded manoeuvre, as lines for the vessel's TOML")
    hull.add_argument("folder", type=Path, metavar="LOGDIR")
    hull.add_argument("--from", type=float, default=0.0, metavar="S", dest="from_s", help="leave out what was before, in the boat's time")
    hull.add_argument("--to", type=float, default=float("inf"), metavar="S", dest="to_s")
    hull.add_argument("--hold", action="append", default=[], metavar="NAME", help="leave a quantity at the model's value, by its name in the report")
    hull.add_argument("--out", type=Path, metavar="DIR", help="for identified.toml and identified.png; default: the log folder")
    hull.set_defaults(command=_identify)

    compass = commands.add_parser("calibrate", help="a magnetometer's hard and soft iron from recorded turns, as lines for the vessel's TOML")
    compass.add_argument("folder", type=Path, metavar="LOGDIR")
    compass.add_argument("--sensor", metavar="NAME", help="where the log has several magnetometers")
    compass.add_argument("--from", type=float, default=0.0, metavar="S", dest="from_s", help="leave out what was before, in the boat's time")
    compass.add_argument("--to", type=float, default=float("inf"), metavar="S", dest="to_s")
    compass.add_argument("--out", type=Path, metavar="DIR", help="for magnetometer.toml and magnetometer.png; default: the log folder")
    compass.set_defaults(command=_calibrate)


def _replay(arguments: argparse.Namespace) -> int:
    from companion.record.replay import replay

    if arguments.whole:
        return _rerun(arguments)
    out = arguments.out or arguments.folder / "replay.csv"
    result = replay(open_log(arguments.folder), out)
    _warn(result.warnings)
    print(result.report())
    print(f"written: {out}")
    return 0 if result.largest_in_log() <= arguments.tolerance else 1


def _rerun(arguments: argparse.Namespace) -> int:
    from companion.commands.rerun import rerun

    out = arguments.out or arguments.folder / "replay"
    result = rerun(open_log(arguments.folder), out)
    _warn(result.warnings)
    print(result.report())
    print(f"written: {out}")
    return 0 if result.within(arguments.tolerance) else 1


def _warn(warnings: Sequence[str]) -> None:
    for warning in warnings:
        print(f"warning: {warning}", file=sys.stderr)


def _identify(arguments: argparse.Namespace) -> int:
    from companion.record.identify import identify

    out = arguments.out or arguments.folder
    found = identify(open_log(arguments.folder), out, arguments.from_s, arguments.to_s, arguments.hold)
    _warn(found.warnings)
    print(found.report, found.toml, sep="\n\n")
    print(f"written: {out}")
    return 0


def _calibrate(arguments: argparse.Namespace) -> int:
    from companion.record.calibrate import calibrate

    out = arguments.out or arguments.folder
    found = calibrate(open_log(arguments.folder), out, arguments.sensor, arguments.from_s, arguments.to_s)
    _warn(found.warnings)
    print(found.report, found.toml, sep="\n\n")
    print(f"written: {out}")
    return 0
