"""`python -m gcs_plugins.qgroundcontrol install | uninstall [--dir DIR]`: QGroundControl's action files."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import platformdirs

from gcs_plugins.qgroundcontrol.action_files import FLY_VIEW, JOYSTICK
from gcs_plugins.qgroundcontrol.installation import InstallationError, install, save_folders, uninstall

_AFTER = f"""Choose them once in QGroundControl, Application Settings, Fly View:
  Fly View Actions: {FLY_VIEW}
  Joystick Actions: {JOYSTICK}"""


def main(argv: Sequence[str] | None = None) -> int:
    """Returns 0, or 2 with the reason on stderr."""
    parser = argparse.ArgumentParser(
        prog="python -m gcs_plugins.qgroundcontrol", description="Buttons for this boat in QGroundControl."
    )
    parser.add_argument("what", choices=("install", "uninstall"))
    parser.add_argument(
        "--dir",
        type=Path,
        metavar="DIR",
        help="QGroundControl's load/save path, where it is not in the documents folder",
    )
    arguments = parser.parse_args(argv)
    carry_out = install if arguments.what == "install" else uninstall
    try:
        folders = [arguments.dir] if arguments.dir is not None else save_folders(platformdirs.user_documents_path())
        for folder in folders:
            print("\n".join(carry_out(folder)))
    except InstallationError as error:
        print(f"qgroundcontrol: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"qgroundcontrol: {error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    if arguments.what == "install":
        print(_AFTER)
    return 0


if __name__ == "__main__":
    sys.exit(main())
