"""Where runs keep their things."""

from __future__ import annotations

import os
from pathlib import Path


def kept_in(name: str) -> Path:
    """The folder of a boat's logs and state in the user's home."""
    base = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    return base / "usv-companion" / name


def fresh(directory: Path, name: str) -> Path:
    """A folder that is not there yet."""
    folder, n = directory / name, 2
    while folder.exists():
        folder, n = directory / f"{name}-{n}", n + 1
    return folder
