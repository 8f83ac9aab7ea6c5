"""Which code a run was sailed by: commit and versions."""

from __future__ import annotations

import hashlib
import platform
import subprocess
from collections.abc import Mapping
from functools import cache
from importlib import metadata
from pathlib import Path

_ROOT = Path(__file__).parents[2]
_SAILED = ("companion", "sitl", "mission_files", "pyproject.toml")  # what a run depends on
_PACKAGES = ("numpy", "scipy", "daqp", "pymavlink")  # those whose arithmetic a run depends on


@cache
def commit() -> str:
    """The short name of the commit, with + and a digest of what differs from it; `v0.1.0` of an installed package. A
    process asks once: it goes on with the code that it has loaded."""
    if not (_ROOT / ".git").exists():
        return f"v{_version('usv-companion') or '0.0.0'}"
    name = _git("rev-parse", "--short=10", "HEAD").decode().strip()
    changed = _git("diff", "HEAD", "--", *_SAILED)
    return f"{name}+{hashlib.sha256(changed).hexdigest()[:8]}" if changed else name


@cache
def versions() -> Mapping[str, str]:
    """The versions of the interpreter, of this program and of the packages that compute, by name."""
    own = {"python": platform.python_version(), "usv-companion": _version("usv-companion") or "0.0.0"}
    return {**own, **{name: found for name in _PACKAGES if (found := _version(name))}}


def _git(*words: str) -> bytes:
    try:
        return subprocess.run(["git", *words], cwd=_ROOT, capture_output=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return b"unknown"


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""
