"""`companion mission FILE`: summary, check, conversion and picture of a plan file."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

from companion.config.vessel import VesselConfig
from companion.fence import home_circle
from companion.mission.plan_file import PlanFile, PlanFileError
from companion.mission.summary import Summary
from companion.params.store import Parameters


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
    from companion.allocation.astern import stern_first_mps
    from companion.app import load_vessel
    from companion.mission import files, summary

    if arguments.speed is not None and not arguments.speed > 0.0:
        raise PlanFileError([f"--speed {arguments.speed:g}: must be above 0"])
    vessel = None if arguments.vessel is None else load_vessel(arguments.vessel)
    parameters = Parameters() if vessel is None else Parameters(vessel.parameters)
    plan = read_plan(find_plan(arguments.file))
    of_file_mps = plan.cruise_speed_mps if vessel is None else None  # the boat sails at its own
    cruise_mps = arguments.speed or of_file_mps or parameters["WP_SPEED"]
    most_mps = math.inf if vessel is None else parameters["MPC_XY_VEL_MAX"]
    astern_mps = math.inf if vessel is None else stern_first_mps(vessel)
    docks = vessel is None or (vessel.limits.sway_n > 0.0 and bool(parameters["MIS_LAND_ACT"]))
    voyage = summary.summarise(plan.mission, cruise_mps, plan.home, most_mps, astern_mps, docks)
    print(summary.format_summary(voyage))
    for text in _outlook(voyage, parameters):
        print(f"the boat would warn: {text}")
    for text in _payload_notes(plan, vessel):
        print(f"note: {text}")
    print(f"fence: {len(plan.fence)} items, rally points: {len(plan.rally)}")
    for text in _home_circle(plan, parameters):
        print(text)
    if arguments.convert is not None:
        arguments.convert.write_text(files.write(arguments.convert.name, plan), encoding="utf-8")
        print(f"written: {arguments.convert}")
    refusals = _refusals(plan, parameters, vessel) + _beyond_home_circle(plan, parameters, vessel)
    for text in refusals:
        print(f"the boat would refuse: {text}", file=sys.stderr)
    if arguments.plot is not None and not refusals:
        from companion.analysis.mission_plot import draw

        draw(_with_home_circle(plan, parameters), parameters, cruise_mps, arguments.file.name, arguments.plot)
        print(f"written: {arguments.plot}")
    return 1 if refusals else 0


def _payload_notes(plan: PlanFile, vessel: VesselConfig | None) -> list[str]:
    """What the plan asks of cameras and gimbals that the boat has not, as far as its file says."""
    from companion.core.payload import PayloadPart
    from companion.mission.survey import needs_part, without_camera

    texts = [needs_part(plan.mission, part) for part in PayloadPart]
    if vessel is not None and not vessel.cameras:
        texts.append(without_camera(plan.mission))
    return [text for text in texts if text is not None]


def _outlook(voyage: Summary, parameters: Parameters) -> Iterator[str]:
    """What the boat would warn of at the upload, with a full battery."""
    from companion.mission import outlook
    from companion.mission.summary import first_leg

    full_s = outlook.full_battery_s(parameters["BAT_ENDURANCE"])
    lasts_s = outlook.battery_lasts_s(full_s, 1.0, parameters["BAT_CRIT_THR"])
    warnings = (
        outlook.first_leg_warning(first_leg(voyage.legs), parameters["MIS_DIST_1WP"]),
        outlook.battery_warning(voyage.length_m, voyage.time_s, lasts_s),
    )
    yield from (text for text in warnings if text is not None)


def _refusals(plan: PlanFile, parameters: Parameters, vessel: VesselConfig | None) -> list[str]:
    from companion.config.reversing import stern_first_refusal
    from companion.guidance.orbit import least_radius_m
    from companion.mission.plan import PlanKind
    from companion.mission.validation import check_item, check_plan

    lists = {PlanKind.MISSION: plan.mission, PlanKind.FENCE: plan.fence, PlanKind.RALLY: plan.rally}
    found = [check_item(kind, item) for kind, items in lists.items() for item in items]
    servos, relays = (None, None) if vessel is None else (len(vessel.servos), len(vessel.relays))
    home = plan.home[:2] if plan.home is not None else None
    if home is None and vessel is not None:
        home = vessel.home.lat_deg, vessel.home.lon_deg
    no_astern = None if vessel is None else stern_first_refusal(vessel.thrusters)
    least_m = 0.0 if vessel is None else least_radius_m(parameters, vessel.length_m)
    takes_off = vessel is None or bool(parameters["COM_TAKEOFF_OK"])
    found += [
        check_plan(kind, items, servos, relays, least_m, takes_off, home, no_astern)
        for kind, items in lists.items()
        if items
    ]
    return [f"{refusal} ({refusal.result.name})" for refusal in found if refusal is not None]


def _home_circle(plan: PlanFile, parameters: Parameters) -> Iterator[str]:
    """What GF_MAX_HOR_DIST means for this plan."""
    radius_m = parameters[home_circle.PARAMETER]
    if radius_m > 0.0:
        unknown = "" if plan.home else "; the file gives no home, so it is not checked"
        yield f"fence: a circle of {radius_m:g} m around home ({home_circle.PARAMETER}){unknown}"


def _beyond_home_circle(plan: PlanFile, parameters: Parameters, vessel: VesselConfig | None) -> list[str]:
    radius_m = parameters[home_circle.PARAMETER]
    if plan.home is None or radius_m <= 0.0:
        return []
    kept_m = parameters["FENCE_MARGIN"] + (0.0 if vessel is None else 0.5 * vessel.length_m)
    return list(home_circle.beyond(plan.mission, plan.home[:2], radius_m, kept_m))


def _with_home_circle(plan: PlanFile, parameters: Parameters) -> PlanFile:
    """The plan with the circle as a zone of its fence, to be drawn."""
    radius_m = parameters[home_circle.PARAMETER]
    if plan.home is None or radius_m <= 0.0:
        return plan
    return replace(plan, fence=(*plan.fence, home_circle.as_item(plan.home[:2], radius_m, len(plan.fence))))
