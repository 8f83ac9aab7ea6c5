"""The one place in the tests that looks at the machine's clock: waiting for what another process or thread does.

No test asserts how long that takes. `CAP_S` only bounds a hang: nothing that works ever comes near it, on a machine
loaded thirtyfold either.
"""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")
Output = TypeVar("Output", str, bytes)

CAP_S = 300.0  # of wall time, for any one condition and any one blocking call
_POLL_S = 0.01


def wait_until(
    condition: Callable[[], T], what: str, *, again: Callable[[], object] | None = None, again_s: float = 1.0
) -> T:
    """The first true value of `condition()`. Fails with `what` when none comes before the cap.

    `again`: an action to repeat every `again_s` meanwhile, as a request on a link that may lose it.
    """
    end_s = time.monotonic() + CAP_S
    again_due_s = time.monotonic() + again_s
    if again is not None:
        again()
    while not (found := condition()):
        now_s = time.monotonic()
        assert now_s < end_s, f"waited in vain: {what}"
        if again is not None and now_s >= again_due_s:
            again_due_s = now_s + again_s
            again()
        time.sleep(_POLL_S)
    return found


class Every:
    """Whether it is time to do something again, at most once every `period_s` of wall time; at once the first time."""

    def __init__(self, period_s: float) -> None:
        self._period_s, self._due_s = period_s, 0.0

    def due(self) -> bool:
        now_s = time.monotonic()
        if now_s < self._due_s:
            return False
        self._due_s = now_s + self._period_s
        return True


def ended(process: subprocess.Popen[Output], what: str) -> tuple[Output, Output]:
    """What a process that was asked to end still wrote to stdout and stderr. Kills it and fails where it does not
    end."""
    try:
        return process.communicate(timeout=CAP_S)
    except subprocess.TimeoutExpired:
        process.kill()
        _, errors = process.communicate()
        raise AssertionError(f"{what} did not end: {errors}") from None


def run_to_end(command: list[str], **more: object) -> subprocess.CompletedProcess[str]:
    """A command that ends by itself, with what it wrote."""
    return subprocess.run(command, capture_output=True, text=True, timeout=CAP_S, check=False, **more)  # type: ignore[call-overload,no-any-return]
