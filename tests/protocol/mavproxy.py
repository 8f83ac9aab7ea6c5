"""MAVProxy, headless, driven through its own prompt."""

from __future__ import annotations

import os
import re
import select
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from tests.waiting import ended, wait_until


class MavProxy:
    """`mavproxy.py --master MASTER` with a pipe for a keyboard. `modules`: to load over those that it brings. `within`:
    a command that runs this one, as that of an `Island`."""

    def __init__(self, master: str, folder: Path, modules: tuple[str, ...] = (), within: tuple[str, ...] = ()) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        command = [*within, sys.executable, str(Path(sys.executable).with_name("mavproxy.py")), f"--master={master}"]
        command += [
            f"--logfile={folder / 'mav.tlog'}",
            "--streamrate=-1",
            *(f"--load-module={name}" for name in modules),
        ]
        environment = {**os.environ, "HOME": str(folder), "PYTHONUNBUFFERED": "1"}
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env=environment,
        )
        self._heard = ""
        self._looked_at = 0

    def say(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write((line + "\n").encode())
        self._process.stdin.flush()

    def expect(self, pattern: str) -> re.Match[str]:
        """The next thing that it prints which fits `pattern`; what stands before it is passed over."""
        return wait_until(lambda: self._found(pattern), f"MAVProxy prints {pattern!r}")

    def expect_all(self, *patterns: str) -> None:
        """As `expect`, for several that come in any order."""
        wait_until(lambda: self._all_found(patterns), f"MAVProxy prints {patterns!r}")

    def ask(self, line: str, pattern: str, again_s: float = 1.0) -> re.Match[str]:
        """Say `line` again and again until what comes back fits `pattern`."""
        what = f"MAVProxy answers {line!r} with {pattern!r}"
        return wait_until(lambda: self._found(pattern), what, again=lambda: self.say(line), again_s=again_s)

    @property
    def printed(self) -> str:
        """All that it has printed so far, as far as it was looked at."""
        return self._heard[: self._looked_at]

    def _found(self, pattern: str) -> re.Match[str] | None:
        self._listen()
        found = re.compile(pattern).search(self._heard, self._looked_at)
        if found is not None:
            self._looked_at = found.end()
        return found

    def _all_found(self, patterns: Sequence[str]) -> bool:
        self._listen()
        found = [re.compile(pattern).search(self._heard, self._looked_at) for pattern in patterns]
        ends = [one.end() for one in found if one is not None]
        if len(ends) < len(patterns):
            return False
        self._looked_at = max(ends)
        return True

    def _listen(self) -> None:
        assert self._process.stdout is not None
        while select.select([self._process.stdout], (), (), 0.0)[0]:
            data = os.read(self._process.stdout.fileno(), 65536)
            assert data, f"MAVProxy ended: {self._heard[-1500:]}"
            self._heard += data.decode(errors="replace")

    def __enter__(self) -> MavProxy:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            print(f"MAVProxy printed: {self._heard[-1500:]}")
        self._process.terminate()
        ended(self._process, "MAVProxy")
