"""`companion trial …`: accept or undo what a sea trial found, and its report."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from companion.cli.common import UsageError, judge_out_folder, print_warnings, typed
from companion.cli.progress import bar
from companion.cli.trial_results import REPORT, accept, accept_overlay, undo
from companion.config.overlay import accepted, copy_beside, in_force, is_overlay, overlays, that_count
from companion.config.vessel import find
from companion.core.progress import part

_IDENTIFIED, _PREDICTED = 0.7, 0.95  # shares of a report after which the boat is identified, and its Hold predicted


def add_to(commands: Any) -> None:
    """Add the commands to `commands`, argparse's subparsers."""
    trial = commands.add_parser("trial", help="accept or undo what a sea trial found; its report")
    steps = trial.add_subparsers(required=True, metavar="STEP")
    accept = steps.add_parser("accept", help="let an overlay count from the next start of the boat on")
    accept.add_argument(
        "overlay", metavar="OVERLAY", help="as `companion identify` wrote it; or the VESSEL, for its newest overlay"
    )
    accept.add_argument(
        "--vessel", metavar="VESSEL", help="for an overlay in another folder: copy it beside this vessel"
    )
    accept.set_defaults(command=_accept)
    undo = steps.add_parser("undo", help="the overlay in force no longer counts; the one before counts again")
    undo.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
    undo.set_defaults(command=_undo)
    listed = steps.add_parser("list", help="all overlays of a vessel, and which one counts")
    listed.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
    listed.set_defaults(command=_list)
    report = steps.add_parser("report", help="one HTML file: manoeuvring figures, capability, what changes and why")
    report.add_argument("folder", type=Path, metavar="LOGDIR", help="a log folder")
    report.add_argument(
        "--after",
        type=Path,
        metavar="LOGDIR",
        help="a later log, with a trial or Hold; default: the last one beside LOGDIR that has the new gains",
    )
    report.add_argument("--no-prediction", action="store_true", help="without station keeping in simulation")
    report.add_argument("--out", type=Path, metavar="HTML", help="default: trial.html in the log folder")
    report.set_defaults(command=_report)


def _accept(arguments: argparse.Namespace) -> int:
    overlay = Path(arguments.overlay)
    if not is_overlay(overlay.name) and arguments.vessel is None:
        return _accept_newest(find(arguments.overlay))
    if not is_overlay(overlay.name):
        raise UsageError(f"{overlay}: not named like an overlay, NAME.trial-DATE.toml; `companion identify` writes one")
    vessel_file = overlay.with_name(overlay.name.split(".trial-")[0] + ".toml")
    if arguments.vessel is not None:
        vessel_file = find(arguments.vessel)
        overlay = copy_beside(overlay, vessel_file)
    if not vessel_file.is_file():
        raise UsageError(f"{vessel_file}: no such vessel beside the overlay; name it with --vessel")
    try:
        accept_overlay(vessel_file, overlay)
    except ValueError as error:
        raise UsageError(str(error)) from error
    return _accepted(vessel_file, overlay)


def _accept_newest(vessel_file: Path) -> int:
    try:
        overlay = accept(vessel_file)
    except ValueError as error:
        raise UsageError(str(error)) from error
    return _accepted(vessel_file, overlay)


def _accepted(vessel_file: Path, overlay: Path) -> int:
    back = typed("trial", "undo", vessel_file)
    counts = in_force(vessel_file)
    if counts is None or counts.resolve() == overlay.resolve():
        print(f"accepted: {overlay}, from the next start on. Back: {back}")
    else:
        print(f"accepted: {overlay}, but the newer {counts} counts until it is undone: {back}")
    return 0


def _undo(arguments: argparse.Namespace) -> int:
    vessel_file = find(arguments.vessel)
    try:
        overlay = undo(vessel_file)
    except ValueError as error:
        raise UsageError(str(error)) from error
    now = in_force(vessel_file)
    print(f"undone: {overlay}; in force from the next start on: {now or vessel_file}")
    return 0


def _list(arguments: argparse.Namespace) -> int:
    vessel_file = find(arguments.vessel)
    count = that_count(vessel_file)
    for overlay in overlays(vessel_file):
        state = "accepted, replaced" if accepted(overlay) else "not accepted"
        if overlay in count:
            state = "in force" if overlay == count[-1] else "in force, but for the parameters of later ones"
        print(f"{overlay}: {state}")
    if not count:
        print(f"{vessel_file} counts as it is")
    return 0


def _report(arguments: argparse.Namespace) -> int:
    from companion.analysis.log_reader import open_log
    from companion.analysis.trial_identify import identify_trial
    from companion.analysis.trial_report import write_report
    from companion.cli.keeping import keepings

    out = arguments.out or arguments.folder / REPORT
    if arguments.folder.is_dir():
        judge_out_folder(out.parent)
    log = open_log(arguments.folder)
    with bar("trial report", lines="it identifies the boat first, which takes a minute or more") as told:
        found = identify_trial(log, told=part(told, 0.0, _IDENTIFIED))
        told("holding a point in simulation", _IDENTIFIED)
        kept = keepings(found, arguments.after, not arguments.no_prediction)
        told("writing the page", _PREDICTED)
        warnings = write_report(found, out, kept)
    print_warnings(warnings)
    print(f"written: {out}")
    return 0
