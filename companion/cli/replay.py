"""`companion replay LOGDIR`: a recorded log through today's code."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from companion.analysis.log_reader import open_log
from companion.cli.common import print_warnings


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    replay = commands.add_parser("replay", help="a recorded log through today's code")
    replay.add_argument("folder", type=Path, metavar="LOGDIR", help="a log folder")
    replay.add_argument(
        "--all",
        action="store_true",
        dest="whole",
        help="the whole tick, not the estimate alone: modes, guidance, control, with what ground stations sent",
    )
    replay.add_argument(
        "--out",
        type=Path,
        metavar="PATH",
        help="a CSV, default replay.csv in the log folder; with --all a log folder, default replay/ in it",
    )
    replay.add_argument(
        "--tolerance",
        type=float,
        default=1e-9,
        metavar="D",
        help="largest difference from the log for exit code 0, in SI units",
    )
    replay.set_defaults(command=_replay)


def _replay(arguments: argparse.Namespace) -> int:
    """Exit code 0 where today's code agrees with the log within the tolerance, else 1."""
    return (_replay_all if arguments.whole else _replay_estimate)(arguments)


def _replay_estimate(arguments: argparse.Namespace) -> int:
    from companion.analysis.replay import replay

    out = arguments.out or arguments.folder / "replay.csv"
    result = replay(open_log(arguments.folder), out)
    print_warnings(result.warnings)
    print(result.report())
    print(f"written: {out}")
    return 0 if result.largest_in_log() <= arguments.tolerance else 1


def _replay_all(arguments: argparse.Namespace) -> int:
    from companion.analysis.rerun import rerun

    out = arguments.out or arguments.folder / "replay"
    result = rerun(open_log(arguments.folder), out)
    print_warnings(result.warnings)
    print(result.report())
    print(f"written: {out}")
    return 0 if result.within(arguments.tolerance) else 1
