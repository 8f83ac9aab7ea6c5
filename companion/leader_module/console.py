"""The terminal of a leader module: a status line, announcements above it, and keys."""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import sys
import termios
import threading
import tty
from collections import deque
from typing import Any, TextIO

_PLAIN_PERIOD_S = 5.0  # where the output is not a terminal
_CHUNK = 256
_MOST_WAITING = 500  # lines
_PATIENCE_S = 1.0  # for the last lines at the end


class _Writer:
    """Writes to a descriptor beside the caller: a terminal that stands still (Ctrl-S, a connection that is cut) costs
    the oldest lines, and holds nobody up. One that is gone gets nothing more."""

    def __init__(self, descriptor: int, encoding: str) -> None:
        self._descriptor, self._encoding = descriptor, encoding
        self._waiting: deque[bytes] = deque(maxlen=_MOST_WAITING)
        self._wake = threading.Event()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="terminal", daemon=True)
        self._thread.start()

    def put(self, text: str) -> None:
        """Write this as soon as the terminal takes it."""
        self._waiting.append(text.encode(self._encoding, "replace"))
        self._wake.set()

    def close(self) -> bool:
        """Whether all that waits was written within a second."""
        self._ended = True
        self._wake.set()
        self._thread.join(_PATIENCE_S)
        return not self._thread.is_alive()

    def _run(self) -> None:
        ended = False
        while not ended:
            self._wake.wait()
            self._wake.clear()
            ended = self._ended
            try:
                while self._waiting:
                    self._write(self._waiting.popleft())
            except OSError:
                return

    def _write(self, rest: bytes) -> None:
        while rest:
            rest = rest[os.write(self._descriptor, rest) :]


class Console:
    """The crew's terminal. One that goes away or stands still does not stop the caller.

    Keys are read one by one, without echo, until `close()`. Without a terminal, the status is printed every 5 s, and
    keys are read from the pipe.
    """

    def __init__(self, out: TextIO = sys.stdout, source: TextIO = sys.stdin) -> None:
        self._out = out
        self._writer = _writer_to(out)
        self._terminal = _is_terminal(out)
        self._shown_s: float | None = None
        self._fd: int | None = None
        self._before: Any = None
        with contextlib.suppress(OSError, ValueError, termios.error):
            fd = source.fileno()
            if os.isatty(fd):
                self._before = termios.tcgetattr(fd)
                tty.setcbreak(fd)
            self._fd = fd

    def fileno(self) -> int | None:
        """Standard input, or None."""
        return self._fd

    def typed(self) -> str:
        """Keys pressed since the last call."""
        if self._fd is None:
            return ""
        try:
            if not select.select((self._fd,), (), (), 0.0)[0]:
                return ""
            data = os.read(self._fd, _CHUNK)
        except (OSError, ValueError):
            data = b""
        if not data:
            self._fd = None
        return data.decode("ascii", errors="ignore")

    def show(self, line: str, now_s: float) -> None:
        """Replace the status line."""
        if self._terminal:
            width = max(20, shutil.get_terminal_size().columns - 1)
            self._write(f"\r{line[:width]:<{width}}")
        elif self._shown_s is None or now_s - self._shown_s >= _PLAIN_PERIOD_S:
            self._shown_s = now_s
            self._write(line + "\n")

    def say(self, text: str) -> None:
        """Print a line that stays."""
        clear = f"\r{'':{max(20, shutil.get_terminal_size().columns - 1)}}\r" if self._terminal else ""
        self._write(f"{clear}{text}\n")

    def close(self) -> None:
        """Restore the terminal."""
        if self._terminal:
            self._write("\n")
        written = self._writer is None or self._writer.close()
        if self._before is not None and self._fd is not None:
            with contextlib.suppress(OSError, termios.error):
                termios.tcsetattr(self._fd, termios.TCSADRAIN if written else termios.TCSANOW, self._before)

    def _write(self, text: str) -> None:
        if self._writer is not None:
            self._writer.put(text)
            return
        with contextlib.suppress(OSError, ValueError):
            self._out.write(text)


def _writer_to(out: TextIO) -> _Writer | None:
    """None for what has no descriptor: memory, or an output that is closed."""
    try:
        return _Writer(out.fileno(), out.encoding)
    except (OSError, ValueError):
        return None


def _is_terminal(out: TextIO) -> bool:
    try:
        return out.isatty()
    except ValueError:
        return False
