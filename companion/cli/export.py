"""`companion export LOGDIR --to FORMATS`: a log in the formats of other programs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from companion.cli.common import UsageError, print_warnings

_FORMATS = ("csv", "gpx", "kml", "geojson", "parquet")


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    export = commands.add_parser("export", help="a log for other programs: its track as GPX, KML or GeoJSON, tables")
    export.add_argument("folder", type=Path, metavar="LOGDIR", help="a log folder")
    export.add_argument(
        "--to", required=True, metavar="FORMATS", help=f"one or more of {', '.join(_FORMATS)}, separated by commas"
    )
    export.add_argument("--out", type=Path, metavar="DIR", help="default: export/ in the log folder")
    export.set_defaults(command=_export)


def _export(arguments: argparse.Namespace) -> int:
    from companion.analysis.export import export, size_text

    formats = [name.strip() for name in arguments.to.split(",") if name.strip()]
    unknown = [name for name in formats if name not in _FORMATS]
    if unknown or not formats:
        raise UsageError(f"--to {arguments.to}: one or more of {', '.join(_FORMATS)}, separated by commas")
    warnings: list[str] = []
    out = arguments.out or arguments.folder / "export"
    written = export(arguments.folder, formats, out, warnings)
    print_warnings(warnings)
    for path in written:
        print(f"written: {path}, {size_text(path.stat().st_size)}")
    return 0
