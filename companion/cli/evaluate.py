"""`companion evaluate`: runs on the same water, by whichever autopilot, judged from the plant's truth alone."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from companion.analysis.log_reader import LogError, open_log
from companion.app import load_vessel
from companion.cli import beside, consistency
from companion.cli.common import UsageError
from companion.config.vessel import HomeConfig, VesselConfig
from companion.core.geodesy import LocalFrame
from companion.mission import files
from companion.mission.commands import PLACES

if TYPE_CHECKING:
    from sitl.evaluate.figures import Figure


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    evaluate = commands.add_parser(
        "evaluate",
        help="compare simulated runs, of this or another autopilot, from their truth.csv",
        description="One table: a column a run, and how many times worse the last is than the first. A DIR holds a "
        "truth.csv: of `companion run --sitl`, of a scenario, or of `companion sitl --physics`.",
    )
    tasks = evaluate.add_subparsers(dest="task", required=True, metavar="TASK")
    held = tasks.add_parser("hold", help="station keeping")
    held.add_argument("--point", metavar="NORTH_M,EAST_M", help="from home; left out: where the boat is at --from")
    held.add_argument("--heading", type=float, metavar="DEG", help="left out: the heading is not judged")
    sailed = tasks.add_parser("route", help="a route of straight legs")
    sailed.add_argument("--plan", type=Path, required=True, metavar="FILE", help="its waypoints, in any plan format")
    sailed.add_argument("--radius", type=float, default=5.0, metavar="M", help="within which a waypoint is reached")
    beside.add_to(tasks)
    consistency.add_to(tasks)
    for task in (held, sailed):
        task.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
        task.add_argument("runs", nargs="+", metavar="LABEL=DIR", help="the first is ours, as ours=logs/a")
        task.add_argument("--from", dest="from_s", type=float, default=0.0, metavar="S", help="judge from this time on")
        task.add_argument("--to", dest="to_s", type=float, default=math.inf, metavar="S", help="and to this time")
        task.set_defaults(command=_evaluate)


def _evaluate(arguments: argparse.Namespace) -> int:
    from sitl.evaluate.table import table

    _check(arguments)
    vessel = load_vessel(arguments.vessel)
    named = [_run(text) for text in arguments.runs]
    labels = [label for label, _ in named]
    if twice := next((label for label in labels if labels.count(label) > 1), None):
        raise UsageError(f"two runs are called '{twice}': a column needs a label of its own")
    runs = {label: _judged(label, folder, vessel, arguments) for label, folder in named}
    for text in table(runs):
        print(text)
    return 0


def _check(arguments: argparse.Namespace) -> None:
    """Raises UsageError for a number that makes no sense."""
    if arguments.task == "hold" and arguments.heading is not None and not math.isfinite(arguments.heading):
        raise UsageError(f"--heading {arguments.heading:g}: in degrees, as 90")
    if arguments.task == "route" and not arguments.radius > 0.0:
        raise UsageError(f"--radius {arguments.radius:g}: must be above 0")


def _run(text: str) -> tuple[str, Path]:
    label, equals, folder = text.partition("=")
    if not (label and equals and folder):
        raise UsageError(f"'{text}': write LABEL=DIR, as ours=logs/a")
    return label, Path(folder)


def _judged(label: str, folder: Path, vessel: VesselConfig, arguments: argparse.Namespace) -> list[Figure]:
    """Raises UsageError for a run that cannot be judged."""
    from sitl.evaluate.figures import hold, route
    from sitl.scenarios.measure import between, read_truth

    try:
        track = between(read_truth(folder), arguments.from_s, arguments.to_s)
    except OSError as error:
        raise UsageError(f"{label}: {folder / 'truth.csv'} cannot be read ({error.strerror})") from error
    try:
        if arguments.task == "hold":
            yaw_rad = None if arguments.heading is None else math.radians(arguments.heading)
            return hold(track, vessel, _point(arguments.point), yaw_rad)
        return route(track, vessel, _waypoints(arguments.plan, _home(folder, vessel)), arguments.radius)
    except (ValueError, KeyError) as error:
        why = f"no column {error} in truth.csv" if isinstance(error, KeyError) else error
        raise UsageError(f"{label}: {why}") from error


def _point(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    try:
        north_m, east_m = map(float, text.split(","))
    except ValueError as error:
        raise UsageError(f"--point {text}: write NORTH_M,EAST_M, as 10,-5") from error
    if not (math.isfinite(north_m) and math.isfinite(east_m)):
        raise UsageError(f"--point {text}: write NORTH_M,EAST_M, as 10,-5")
    return north_m, east_m


def _home(folder: Path, vessel: VesselConfig) -> HomeConfig:
    """Where the run began, which `--home` may have chosen; the vessel's own where the log does not say it."""
    try:
        return open_log(folder).config.home
    except LogError:
        return vessel.home


def _waypoints(path: Path, home: HomeConfig) -> list[tuple[float, float]]:
    """The places of a plan's mission, from home, which is the first."""
    try:
        plan = files.read(path.name, path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from error
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    points = [frame.to_ned(item.lat_deg, item.lon_deg) for item in plan.mission if item.command in PLACES]
    if not points:
        raise UsageError(f"{path}: no waypoint in its mission")
    return [(0.0, 0.0), *points]
