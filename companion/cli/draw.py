"""`companion draw VESSEL`: the boat from above, as its file describes it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from companion.app import load_vessel
from companion.cli.drawing import characters, svg


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    draw = commands.add_parser("draw", help="the boat from above: hull, thrusters with their direction, sensors")
    draw.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
    draw.add_argument("--svg", type=Path, metavar="FILE", help="also write the drawing as an SVG file")
    draw.set_defaults(command=_draw)


def _draw(arguments: argparse.Namespace) -> int:
    """Exit code 0."""
    config = load_vessel(arguments.vessel)
    print(characters(config))
    if arguments.svg is not None:
        arguments.svg.write_text(svg(config), encoding="utf-8")
        print(f"{arguments.svg}: written")
    return 0
