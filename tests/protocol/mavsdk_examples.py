"""MAVSDK's own examples: where they come from, the interpreter that each version needs, and one run of one of them.

The files are MAVSDK's, and are fetched by git at pinned commits. `git config --global url.MIRROR.insteadOf ADDRESS`
makes git take them from a mirror.
"""

from __future__ import annotations

import fcntl
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from tests.waiting import CAP_S, wait_until


class Unavailable(Exception):
    """This machine cannot get what the examples need. The text says what, and why."""


@dataclass(frozen=True, slots=True)
class Source:
    """A repository with examples, and the wheel that they are for; None: the one that is installed."""

    address: str
    commit: str
    folder: str
    wheel: str | None


SOURCES = {
    3: Source(
        "https://github.com/mavlink/MAVSDK-Python",
        "4fab80e453072b8404313ebccb41c5fc04942aa5",
        "examples",
        "mavsdk==3.*",
    ),
    4: Source(
        "https://github.com/mavlink/MAVSDK", "158e33932461464a9cad473a84349fa0c376d94d", "py/mavsdk/examples", None
    ),
}


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """One process at a time: several workers of pytest share the folder."""
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _run(command: list[str], what: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True, timeout=CAP_S, check=False, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        raise Unavailable(f"{what}: {(done.stderr or done.stdout).strip().splitlines()[-1:]}")


def fetched(sdk: int, cache: Path) -> Path:
    """The folder with the examples of a version, fetched once into `cache`. Raises Unavailable."""
    source = SOURCES[sdk]
    place = cache / source.commit
    with _alone(cache):
        if not (place / "whole").exists():
            git = ["git", "-C", str(place)]
            _run(["git", "init", "--quiet", str(place)], "git")
            _run([*git, "fetch", "--quiet", "--depth=1", source.address, source.commit], f"no {source.address}")
            _run([*git, "checkout", "--quiet", "FETCH_HEAD", "--", source.folder], "git")
            (place / "whole").touch()
    return place / source.folder


def interpreter(sdk: int, cache: Path) -> str:
    """A Python that has that MAVSDK: this one, or one of a virtual environment made once in `cache`. Raises
    Unavailable."""
    wheel = SOURCES[sdk].wheel
    if wheel is None:
        return sys.executable
    place = cache / f"venv-{sdk}"
    with _alone(cache):
        if not (place / "whole").exists():
            _run([sys.executable, "-m", "venv", str(place)], "venv")
            pip = [str(place / "bin" / "python"), "-m", "pip", "--quiet", "--disable-pip-version-check"]
            _run([*pip, "install", wheel, "tqdm", "anyio"], f"pip has no {wheel} for this machine")
            (place / "whole").touch()
    return str(place / "bin" / "python")


class Running:
    """One example in a process group of its own, since MAVSDK 3 starts a server beside it. What it prints goes to a
    file."""

    def __init__(self, command: list[str], folder: Path, output: Path) -> None:
        self._output = output
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        with output.open("wb") as into:
            self._process = subprocess.Popen(
                command,
                cwd=folder,
                env=environment,
                stdin=subprocess.PIPE,
                stdout=into,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def printed(self) -> str:
        return self._output.read_text(encoding="utf-8", errors="replace")

    def shows(self, pattern: str) -> None:
        """Wait until what it has printed fits `pattern`."""
        wait_until(lambda: re.search(pattern, self.printed) or self._ended, f"{pattern!r} in {self._output}")
        assert re.search(pattern, self.printed), f"{pattern!r} is not in:\n{self.printed[-3000:]}"

    def ended_well(self) -> None:
        wait_until(lambda: self._ended, f"the example ends: {self._output}")
        assert self._process.returncode == 0, self.printed[-3000:]

    @property
    def _ended(self) -> bool:
        return self._process.poll() is not None

    def __enter__(self) -> Running:
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.communicate()
