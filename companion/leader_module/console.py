"""The terminal of a leader module: a status line, announcements above it, and keys."""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import sys
import termios
import tty
from typing import Any, TextIO

_PLAIN_PERIOD_S = 5.0  # where the output is not a terminal
_CHUNK = 256


class Console:
    """The crew's terminal. A terminal that goes away does not stop the caller.

    Keys are read one by one, without echo, until `close()`. Without a terminal, the status is printed every 5 s, and
    keys are read from the pipe.
    """

    def __init__(self, out: TextIO = sys.stdout, source: TextIO = sys.stdin) -> None:
        self._out: TextIO | None = out
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
        if self._before is not None and self._fd is not None:
            with contextlib.suppress(OSError, termios.error):
                termios.tcsetattr(self._fd, termios.TCSADRAIN, self._before)

    def _write(self, text: str) -> None:
        if self._out is None:
            return
        try:
            self._out.write(text)
            self._out.flush()
        except (OSError, ValueError):
            self._give_up(self._out)
            self._out = None

    @staticmethod
    def _give_up(out: TextIO) -> None:
        """Redirect the output: text left in its buffer would otherwise end the process with an error."""
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, out.fileno())
            os.close(nowhere)


def _is_terminal(out: TextIO) -> bool:
    try:
        return out.isatty()
    except ValueError:
        return False
