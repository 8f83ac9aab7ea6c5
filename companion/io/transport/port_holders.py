"""Which program has a device file open, as far as this user may know."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

_MOST_LETTERS = 60


def holder_of(path: str | Path) -> str | None:
    """`process 1234 (companion run revolt)` of a program that has `path` open, "this companion itself" for our own;
    None where none can be seen.

    Reads /proc, which takes some 10 ms. Only root sees the processes of other users.
    """
    device = os.path.realpath(path)
    own = str(os.getpid())
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if any(_points_to(link, device) for link in (folder / "fd").iterdir()):
                return "this companion itself" if folder.name == own else f"process {folder.name} ({_command(folder)})"
    return None


def _points_to(link: Path, device: str) -> bool:
    with contextlib.suppress(OSError):
        return str(link.readlink()) == device
    return False


def _command(folder: Path) -> str:
    """What was called, short: `companion run revolt` for `/usr/bin/python -m companion run revolt`."""
    words = (folder / "cmdline").read_bytes().decode("utf-8", "replace").split("\0")
    if len(words) > 2 and words[1] == "-m":
        words = words[2:]
    elif len(words) > 1 and Path(words[0]).name.startswith("python"):
        words = words[1:]
    text = " ".join([Path(words[0]).name, *words[1:]]).strip()
    return text if len(text) <= _MOST_LETTERS else text[: _MOST_LETTERS - 1] + "…"
