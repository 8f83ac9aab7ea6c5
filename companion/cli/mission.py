"""`companion mission FILE`: summary, check, conversion and picture of a plan file."""

from __future__ import annotations

import argparse
import sys
from importlib import resources
from pathlib import Path
from typing import Any

from companion.config.vessel import VesselConfig
from companion.mission.plan_file import PlanFile, PlanFileError


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    mission = commands.add_parser("mission", help="summary, check, conversion and picture of a plan file or a route")
    mission.add_argument("file", type=Path, metavar="FILE", help="a path, or the name of an example of mission_files")
    mission.add_argument(
        "--vessel", metavar="V", help="the boat for it: its speed, its turns, and what it would refuse"
    )
    mission.add_argument("--speed", type=float, default=None, metavar="MPS", help="cruise speed if the file has none")
    mission.add_argument("--convert", type=Path, metavar="OUT", help="write it in the format of OUT's suffix")
    mission.add_argument(
        "--plot",
        type=Path,
        metavar="PNG",
        help="draw waypoints, the four curves through them, fence, curvature and speed",
    )
    mission.set_defaults(command=_mission)


def find_plan(file: Path) -> Path:
    """`file`, or the example mission of that name where `file` is a bare name that the current folder does not hold."""
    example = Path(str(resources.files("mission_files").joinpath(file.name)))
    return example if file.parent == Path() and not file.exists() and example.exists() else file


def read_plan(file: Path) -> PlanFile:
    """Raises PlanFileError with every problem, OSError for a file that cannot be opened."""
    from companion.mission import files

    if file.stat().st_size > 4 * files.LONGEST_TEXT:
        raise PlanFileError([f"{file}: {file.stat().st_size} bytes; no plan file is that long"])
    try:
        return files.read(file.name, file.read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        raise PlanFileError([f"{file}: not text in UTF-8; save it again as UTF-8"]) from error


def _mission(arguments: argparse.Namespace) -> int:
    from companion.app import load_vessel
    from companion.mission import files, summary
    from companion.params.store import Parameters

    if arguments.speed is not None and not arguments.speed > 0.0:
        raise PlanFileError([f"--speed {arguments.speed:g}: must be above 0"])
    vessel = None if arguments.vessel is None else load_vessel(arguments.vessel)
    parameters = Parameters() if vessel is None else Parameters(vessel.parameters)
    plan = read_plan(find_plan(arguments.file))
    cruise_mps = arguments.speed or plan.cruise_speed_mps or parameters["WP_SPEED"]
    print(summary.format_summary(summary.summarise(plan.mission, cruise_mps, plan.home)))
    print(f"fence: {len(plan.fence)} items, rally points: {len(plan.rally)}")
    if arguments.convert is not None:
        arguments.convert.write_text(files.write(arguments.convert.name, plan), encoding="utf-8")
        print(f"written: {arguments.convert}")
    refusals = _refusals(plan, vessel)
    for text in refusals:
        print(f"the boat would refuse: {text}", file=sys.stderr)
    if arguments.plot is not None and not refusals:
        from companion.analysis.mission_plot import draw

        draw(plan, parameters, cruise_mps, arguments.file.name, arguments.plot)
        print(f"written: {arguments.plot}")
    return 1 if refusals else 0


def _refusals(plan: PlanFile, vessel: VesselConfig | None) -> list[str]:
    from companion.mission.plan import PlanKind
    from companion.mission.validation import check_item, check_plan

    lists = {PlanKind.MISSION: plan.mission, PlanKind.FENCE: plan.fence, PlanKind.RALLY: plan.rally}
    found = [check_item(kind, item) for kind, items in lists.items() for item in items]
    can_sway, servos, relays = (
        (True, None, None) if vessel is None else (vessel.limits.sway_n > 0.0, len(vessel.servos), len(vessel.relays))
    )
    found += [check_plan(kind, items, can_sway, servos, relays) for kind, items in lists.items() if items]
    return [f"{refusal.text} ({refusal.result.name})" for refusal in found if refusal is not None]
