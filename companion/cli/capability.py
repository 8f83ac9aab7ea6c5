"""`companion capability VESSEL`: the wind that a vessel can hold against, with all thrusters or some lost."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from companion.analysis.figure import MATPLOTLIB_MISSING
from companion.app import load_vessel
from companion.cli.common import UsageError


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    capability = commands.add_parser("capability", help="the wind that a vessel can hold against, by its direction")
    capability.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
    capability.add_argument(
        "--lost", action="append", default=[], metavar="THRUSTER", help="without this thruster; may be repeated"
    )
    capability.add_argument(
        "--current", type=float, default=0.0, metavar="MPS", help="current from the same direction as the wind"
    )
    capability.add_argument("--plot", type=Path, nargs="?", const=Path(), metavar="PNG", help="a polar picture")
    capability.set_defaults(command=_capability)


def _capability(arguments: argparse.Namespace) -> int:
    from companion.analysis.capability import capability, plot, summary

    if not math.isfinite(arguments.current):
        raise UsageError(f"--current {arguments.current:g}: must be a number")
    config = load_vessel(arguments.vessel)
    found = capability(config, arguments.lost, arguments.current)
    print(summary(found))
    if arguments.plot is not None:
        path = Path(f"{config.name}-capability.png") if arguments.plot == Path() else arguments.plot
        curves = [("without " + ", ".join(found.lost) if found.lost else "all thrusters", found)]
        if found.lost:
            curves.append(("all thrusters", capability(config, (), arguments.current)))
        try:
            plot(config.title, curves, path)
        except ImportError as error:
            raise UsageError(f"no plot: {MATPLOTLIB_MISSING}") from error
        print(f"written: {path}")
    return 0
