"""MAVProxy, headless, driven through its own prompt."""

from __future__ import annotations

import os
import re
import select
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType


class MavProxy:
    """`mavproxy.py --master MASTER` with a pipe for a keyboard. `modules`: to load over those that it brings."""

    def __init__(self, master: str, folder: Path, modules: tuple[str, ...] = ()) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, str(Path(sys.executable).with_name("mavproxy.py")), f"--master={master}"]
        command += [f"--logfile={folder / 'mav.tlog'}", "--streamrate=-1", *(f"--load-module={name}" for name in modules)]
        environment = {**os.environ, "HOME": str(folder), "PYTHONUNBUFFERED": "1"}
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=folder, env=environment
        )
        self._heard = ""
        self._looked_at = 0

    def say(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write((line + "\n").encode())
        self._process.stdin.flush()

    def expect(self, pattern: str, timeout_s: float = 30.0) -> re.Match[str]:
        """The next thing that it prints which fits `pattern`; what stands before it is passed over."""
        end_s = time.monotonic() + timeout_s
        while True:
            found = re.compile(pattern).search(self._heard, self._looked_at)
            if found is not None:
                self._looked_at = found.end()
                return found
            assert time.monotonic() < end_s, f"MAVProxy did not print {pattern!r}; it printed: {self._heard[self._looked_at :][-1500:]}"
            self._listen(0.1)

    def ask(self, line: str, pattern: str, timeout_s: float = 20.0, again_s: float = 1.0) -> re.Match[str]:
        """Say `line` again and again until what comes back fits `pattern`."""
        end_s = time.monotonic() + timeout_s
        while True:
            self.say(line)
            try:
                return self.expect(pattern, again_s)
            except AssertionError:
                if time.monotonic() > end_s:
                    raise

    def _listen(self, timeout_s: float) -> None:
        assert self._process.stdout is not None
        ready, _, _ = select.select([self._process.stdout], (), (), timeout_s)
        if ready:
            data = os.read(self._process.stdout.fileno(), 65536)
            assert data, f"MAVProxy ended: {self._heard[-1500:]}"
            self._heard += data.decode(errors="replace")

    def __enter__(self) -> MavProxy:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._process.terminate()
        try:
            self._process.communicate(timeout=10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.communicate()
