"""The wheel, installed into an environment that holds the project's declared dependencies and nothing else."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from importlib.metadata import distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]


def build(folder: Path, target: str) -> Path:
    """The archive that hatchling makes of the source: `target` is "wheel" or "sdist"."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    (archive,) = folder.iterdir()
    return archive


class Environment:
    """A virtual environment in `folder` with the wheel.

    Dependencies are links to those of the running Python, so nothing is downloaded. Extras are left out.
    """

    def __init__(self, folder: Path, wheel: Path) -> None:
        self.folder = folder
        self.bin = folder / "bin"
        venv.create(folder, with_pip=False, symlinks=True)
        (self.packages,) = folder.glob("lib/python3.*/site-packages")
        install = [sys.executable, "-m", "pip", "--python", str(self.bin / "python"), "install", "--quiet"]
        install += ["--disable-pip-version-check", "--no-deps", "--no-index", "--no-compile", str(wheel)]
        subprocess.run(install, cwd=folder, env=self._variables(), check=True, capture_output=True, text=True)
        (metadata,) = self.packages.glob("*.dist-info/METADATA")
        self._link_dependencies(metadata.read_text(encoding="utf-8"))

    def run(self, program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        """A program of the environment, run in its folder, where no source is near."""
        command = [str(self.bin / program), *arguments]
        return subprocess.run(
            command, cwd=self.folder, env=self._variables(), capture_output=True, text=True, check=False
        )

    def _variables(self) -> dict[str, str]:
        kept = {
            key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "VIRTUAL_ENV", "XDG_"))
        }
        return {**kept, "HOME": str(self.folder)}

    def _link_dependencies(self, metadata: str) -> None:
        lines = [
            line.removeprefix("Requires-Dist: ") for line in metadata.splitlines() if line.startswith("Requires-Dist: ")
        ]
        for name in closure(lines):
            files = distribution(name).files or []
            for top in {file.parts[0] for file in files} - {"..", "__pycache__"}:
                link = self.packages / top
                if not link.exists():
                    link.symlink_to(Path(str(distribution(name).locate_file(top))))


def closure(requirements: list[str]) -> set[str]:
    """Names of all that `requirements` need, without extras."""
    found: set[str] = set()
    waiting = list(requirements)
    while waiting:
        requirement = Requirement(waiting.pop())
        name = canonicalize_name(requirement.name)
        if name not in found and (requirement.marker is None or requirement.marker.evaluate({"extra": ""})):
            found.add(name)
            waiting += distribution(name).requires or []
    return found
