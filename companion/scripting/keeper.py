"""Keeps the scripts of a boat: starts their processes, listens to them, ends those that hang.

One thread for all of them, beside the control thread, which only takes what is to be announced. Nothing that a script
does reaches further than the pipe and the link that it was given.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO

from companion.core.decision import TextKind
from companion.core.events import Announce, encodable
from companion.core.tick import Tick
from companion.scripting.keeping import Deed, Keeping, News, Seen
from companion.scripting.runner import Settings

_LOOK_S = 0.1
_CHUNK = 65536
_SAY_S = 1.0  # between two texts of one script
_LONGEST_TEXT = 100
_MOST_NEWS = 100
_ENDING_S = 2.0
_KEPT = ("PATH", "LANG", "LC_ALL", "TZ", "PYTHONPATH", "VIRTUAL_ENV", "TMPDIR")

Fault = Callable[[str | None], None]


@dataclass(slots=True)
class KeptScript:
    """One script. `settings`: of its process, without the descriptors. `link`: the descriptor that it is given, -1 for
    none. `log`: where its output goes; None: to this program's. `show`: is told why it does not run."""

    name: str
    keeping: Keeping
    settings: Settings
    log: Path | None = None
    link: int = -1
    show: Fault = lambda fault: None
    process: subprocess.Popen[bytes] | None = None
    status: int = -1
    heard: bytes = b""
    beat_s: float = 0.0
    reason: str = ""
    said_s: float = field(default=float("-inf"))


class ScriptKeeper:
    """As a `core.ports.Recorder` it announces what has come up, and looks at SCR_ENABLE; `close` ends the scripts."""

    def __init__(self, scripts: Sequence[KeptScript], say: Announce, enabled: Callable[[], bool]) -> None:
        """`say`: as `EventLog.say`, called by the control thread alone. `enabled()`: whether scripts may run."""
        self._scripts, self._say, self._enabled = scripts, say, enabled
        self._may_run = enabled()
        self._news: queue.SimpleQueue[tuple[str, News]] = queue.SimpleQueue()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="scripts", daemon=True)
        self._thread.start()

    def record(self, tick: Tick) -> None:
        """See `Recorder`."""
        self.announce(tick.t_s)

    def announce(self, now_s: float) -> None:
        """Announce what has come up since the last call."""
        self._may_run = self._enabled()
        for _ in range(_MOST_NEWS):
            try:
                name, news = self._news.get_nowait()
            except queue.Empty:
                return
            self._say(now_s, news.kind, f"script_{name}", news.text)

    @property
    def over(self) -> bool:
        """Whether no script runs and none will be started."""
        return all(script.keeping.over and script.process is None for script in self._scripts)

    def close(self) -> None:
        """End all scripts."""
        self._ended.set()
        self._thread.join()

    # --- the thread ------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._ended.wait(_LOOK_S):
            for script in self._scripts:
                self.look_after(script)
        for script in self._scripts:
            _signal(script, signal.SIGTERM)
        end_s = time.monotonic() + _ENDING_S
        while any(_runs(script) for script in self._scripts) and time.monotonic() < end_s:
            time.sleep(0.02)
        for script in self._scripts:
            _end(script)

    def look_after(self, script: KeptScript) -> None:
        """Listen to a script, and do what its rule says."""
        self._listen(script)
        now_s, code = time.monotonic(), None
        if script.process is not None and not _runs(script):
            self._listen(script)
            code = _end(script)
        seen = Seen(script.process is not None, code, script.beat_s, script.reason)
        deed = script.keeping.update(seen, self._may_run, now_s)
        if deed is Deed.START:
            self._start(script, now_s)
        elif deed is Deed.ASK_TO_END:
            _signal(script, signal.SIGTERM)
        elif deed is Deed.KILL:
            _signal(script, signal.SIGKILL)
        script.show(script.keeping.fault)
        for news in script.keeping.news():
            self._news.put((script.name, news))

    def _start(self, script: KeptScript, now_s: float) -> None:
        try:
            ours, theirs = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError as error:
            script.keeping.not_started(f"not started: {error.strerror}", now_s)
            return
        script.status, script.heard, script.reason, script.beat_s = ours, b"", "", now_s
        given = (theirs,) if script.link < 0 else (theirs, script.link)
        settings = replace(script.settings, status=theirs, link=script.link, keeper=os.getpid())
        try:
            with contextlib.ExitStack() as stack:
                out = None if script.log is None else stack.enter_context(_opened(script.log))
                script.process = subprocess.Popen(
                    [sys.executable, "-m", "companion.scripting.runner", settings.text()],
                    stdin=subprocess.DEVNULL,
                    stdout=out,
                    stderr=subprocess.STDOUT if out is not None else None,
                    env=_environment(os.environ),
                    pass_fds=given,
                    start_new_session=True,
                )
        except OSError as error:
            os.close(ours)
            script.status = -1
            script.keeping.not_started(f"not started: {error.strerror}", now_s)
        finally:
            os.close(theirs)

    def _listen(self, script: KeptScript) -> None:
        """Take what the script has told: beats, texts, the reason of a failure."""
        if script.status < 0:
            return
        try:
            data = os.read(script.status, _CHUNK)
        except OSError:
            return
        if data:
            script.beat_s = time.monotonic()
        *lines, rest = (script.heard + data).split(b"\n")
        script.heard = rest[:_CHUNK]
        for line in lines:
            if line:
                self._heed(script, line)

    def _heed(self, script: KeptScript, line: bytes) -> None:
        try:
            told = json.loads(line)
        except (ValueError, RecursionError):
            return
        if not isinstance(told, dict):
            return
        script.reason = encodable(str(told.get("failed", script.reason)))
        now_s = time.monotonic()
        if "say" in told and now_s - script.said_s >= _SAY_S:
            script.said_s = now_s
            text = encodable(" ".join(str(told["say"]).split()))[:_LONGEST_TEXT]
            self._news.put((script.name, News(TextKind.ROUTINE, f"{script.name}: {text}")))


def _opened(log: Path) -> IO[bytes]:
    """The end of the file; nowhere, where it cannot be written."""
    try:
        return log.open("ab")
    except OSError:
        return Path(os.devnull).open("wb")


def _runs(script: KeptScript) -> bool:
    """Whether its process runs. One that has ended is left unreaped: until then its number belongs to nobody else."""
    if script.process is None:
        return False
    return os.waitid(os.P_PID, script.process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None


def _signal(script: KeptScript, number: int) -> None:
    """To the script and all that it has started."""
    if script.process is not None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(script.process.pid, number)


def _end(script: KeptScript) -> int | None:
    """Nothing of the script is left: neither its process, nor what it has started, nor its pipe. Returns its exit
    code."""
    code = None
    if script.process is not None:
        _signal(script, signal.SIGKILL)
        code = script.process.wait()
        script.process = None
    if script.status >= 0:
        os.close(script.status)
        script.status = -1
    return code


def _environment(ours: Mapping[str, str]) -> dict[str, str]:
    """What a script sees of the environment: no tokens, and numerical libraries with one thread."""
    kept = {name: ours[name] for name in _KEPT if name in ours}
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    return {**kept, **one, "PYTHONUNBUFFERED": "1", "PYTHONDONTWRITEBYTECODE": "1"}
