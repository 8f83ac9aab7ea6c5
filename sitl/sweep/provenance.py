"""Which code a run was sailed by: commit and versions."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import subprocess
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import metadata
from pathlib import Path

_ROOT = Path(__file__).parents[2]
_SAILED = ("companion", "sitl", "mission_files", "pyproject.toml")  # what a run depends on
_PACKAGES = ("numpy", "scipy", "daqp", "pymavlink")  # those whose arithmetic a run depends on


@cache
def commit() -> str:
    """The code that runs, see `commit_of`. A process asks once: it goes on with the code that it has loaded."""
    return commit_of(_ROOT)


def commit_of(root: Path) -> str:
    """The short name of the commit of a checkout, with + and a digest of what differs from it, new files too; `v0.1.0`
    where `root` is none, but an installed package."""
    if not (root / ".git").exists():
        return f"v{_version('usv-companion') or '0.0.0'}"
    name = _git(root, "rev-parse", "--short=10", "HEAD").decode().strip()
    changed = _git(root, "diff", "HEAD", "--", *_SAILED) + b"".join(_new_files(root))
    return f"{name}+{hashlib.sha256(changed).hexdigest()[:8]}" if changed else name


def _new_files(root: Path) -> Iterator[bytes]:
    """Names and contents of what git does not know yet, as a new vessel."""
    for name in _git(root, "ls-files", "--others", "--exclude-standard", "-z", "--", *_SAILED).split(b"\0"):
        with contextlib.suppress(OSError):
            yield name + (root / os.fsdecode(name)).read_bytes()


@cache
def versions() -> Mapping[str, str]:
    """The versions of the interpreter, of this program and of the packages that compute, by name."""
    own = {"python": platform.python_version(), "usv-companion": _version("usv-companion") or "0.0.0"}
    return {**own, **{name: found for name in _PACKAGES if (found := _version(name))}}


def _git(root: Path, *words: str) -> bytes:
    try:
        return subprocess.run(["git", *words], cwd=root, capture_output=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return b"unknown"


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""
