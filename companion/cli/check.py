"""`companion check VESSEL`: every error of a vessel's file at once, and whether its devices are what it says."""

from __future__ import annotations

import argparse
from typing import Any

from companion.analysis.static_limits import lines, static_limits, weakness
from companion.app import load_vessel
from companion.cli.common import print_warnings
from companion.cli.devices import listen_to
from companion.config.overlay import that_count
from companion.config.plausibility import judgements
from companion.config.toml_places import dotted
from companion.config.vessel import VesselConfig, find
from companion.io.mavlink.wire.exposure import exposed_warnings

_LISTEN_S = 3.0


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    check = commands.add_parser("check", help="every error of a vessel's file at once, with its place")
    check.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
    check.add_argument(
        "--listen",
        action="store_true",
        help="also compare its serial devices with what they send; nothing is written to any",
    )
    check.set_defaults(command=_check)


def _check(arguments: argparse.Namespace) -> int:
    """Exit code 0 where the file and, if asked for, its devices are in order, else 1."""
    config = load_vessel(arguments.vessel)
    print(f"{config.name}: {config.title}: no errors", flush=True)
    if overlays := that_count(find(arguments.vessel)):
        names = ", ".join(overlay.name for overlay in overlays)
        print(f"model: {names}, as accepted after a sea trial; {arguments.vessel} has the rest")
    for found in judgements(config):
        print(f"note: {dotted(found.place)}: {found}")
    _print_limits(config)
    print_warnings(exposed_warnings(config.links))
    judged = listen_to(config, _LISTEN_S) if arguments.listen else []
    for _, text in judged:
        print(text)
    return 0 if all(well for well, _ in judged) else 1


def _print_limits(config: VesselConfig) -> None:
    """What it holds in the mean by its file, and what is weak."""
    found = static_limits(config)
    if config.has_sail:
        return
    if found is None:
        print("note: windage: no wind areas, so the wind that the boat holds against is unknown")
        return
    for line in lines(found):
        print(line)
    for text in weakness(config, found):
        print(f"note: {text}")
