"""Names of log folders: a log that begins anew goes on in `NAME-2`, `NAME-3` and so on."""

from __future__ import annotations


def next_name(first: str, number: int) -> str:
    """The name of the folder with that number, from 2, of a log that began in `first`."""
    return f"{first}-{number}"


def is_of_run(name: str, first: str) -> bool:
    """Whether a log folder belongs to the run whose log began in `first`."""
    return name == first or (name.startswith(f"{first}-") and name.removeprefix(f"{first}-").isdigit())
