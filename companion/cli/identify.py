"""`companion identify LOGDIR`: a hull from a recorded manoeuvre, as lines for the vessel's TOML."""

from __future__ import annotations

import argparse
import math
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from companion.analysis.log_reader import open_log
from companion.cli import realtime
from companion.cli.common import add_time_span, judge_out_folder, print_warnings, typed
from companion.cli.progress import bar
from companion.config.vessel import find
from companion.core.trial_results import TrialFinding

_TAKES = "it takes about a minute, longer on a small computer"
_NEXT = (
    "Next: put these lines in place of [hull] in the vessel's file, and those of the thrusters into their tables;",
    "then companion check FILE, and sail the scenarios again. A Trial does all of this by itself",
)
_NEXT_OF_NONE = (
    "Next: leave the vessel's file as it is, and sail a Trial: it moves the boat in all the ways that tell",
)


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    identify = commands.add_parser(
        "identify", help="inertia, damping and thrust from a recorded manoeuvre, as lines for the vessel's TOML"
    )
    identify.add_argument("folder", type=Path, metavar="LOGDIR", help="a log folder")
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
    identify.add_argument(
        "--vessel", metavar="VESSEL", help="of a Trial: write the overlay beside this vessel's file, not into the log"
    )
    identify.add_argument("--beside", action="store_true", help=argparse.SUPPRESS)  # of a boat that sails
    identify.set_defaults(command=_identify)


def _identify(arguments: argparse.Namespace) -> int:
    from companion.analysis.identify import TOML_FILE, identify
    from companion.analysis.trial_log import manoeuvres

    if arguments.beside:
        return _identify_beside(arguments)
    if manoeuvres(arguments.folder) and (arguments.from_s, arguments.to_s) == (0.0, math.inf):
        return _identify_trial(arguments)
    log, out = open_log(arguments.folder), arguments.out or arguments.folder
    judge_out_folder(out)
    with bar("identify", lines=_TAKES) as told:
        found = identify(log, out, arguments.from_s, arguments.to_s, arguments.hold, told)
    print_warnings(found.warnings)
    print(found.report, found.toml, sep="\n\n")
    print(f"written: {out / TOML_FILE}")
    print(*_NEXT if found.better else _NEXT_OF_NONE, sep="\n")
    return 0


def _identify_beside(arguments: argparse.Namespace) -> int:
    """For a boat that sails meanwhile: after all other programs; the finding as a line of JSON, then the report."""
    from companion.cli import trial_results

    realtime.after_all_others()
    found = []

    def work() -> TrialFinding:
        found.append(trial_results.identified(arguments.folder, find(arguments.vessel)))
        return trial_results.finding(found[0])

    print(trial_results.line_of(work), flush=True)
    for one in found:
        trial_results.report(one, arguments.folder)
    return 0


def _identify_trial(arguments: argparse.Namespace) -> int:
    """All of a Trial at once: the overlay is written, and counts once the operator accepts it."""
    from companion.analysis.trial_identify import identify_trial, write

    log, vessel_file = open_log(arguments.folder), None if arguments.vessel is None else find(arguments.vessel)
    folder = arguments.out or (arguments.folder if vessel_file is None else vessel_file.parent)
    judge_out_folder(folder)
    with bar("identify", lines=_TAKES) as told:
        found = identify_trial(log, arguments.hold, told)
    print_warnings(found.warnings)
    stem = found.log.config.name if vessel_file is None else vessel_file.stem
    overlay, picture = write(found, folder, stem, datetime.now(UTC).date().isoformat(), arguments.out)
    print(found.text, "", f"written: {overlay}", *([] if picture is None else [f"written: {picture}"]), sep="\n")
    beside = vessel_file is not None and folder.resolve() == vessel_file.parent.resolve()
    option = "" if beside else f" --vessel {arguments.vessel or 'VESSEL'}"
    print(f"Nothing changes until you accept it: {typed('trial', 'accept', overlay)}{option}")
    return 0
