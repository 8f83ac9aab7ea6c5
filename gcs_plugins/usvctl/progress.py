"""Waiting for MAVSDK's transfers with a bar on the terminal."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

Report = Callable[[Any, Any, Any], None]


def bar() -> Progress:
    """A bar on stderr; stdout stays free for scripts."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), transient=False)


def transferred(
    what: str, start: Callable[[Report], None], share: Callable[[Any], float], goes_on: Callable[[Any], bool]
) -> Any:
    """Begin a transfer of MAVSDK by `start`, show the `share` of each report, and return the first result for which
    `goes_on` is false."""
    over, last = threading.Event(), []
    with bar() as progress:
        task = progress.add_task(what, total=1.0)

        def report(result: Any, data: Any, _: Any) -> None:
            if goes_on(result):
                progress.update(task, completed=min(1.0, share(data)))
            else:
                last.append(result)
                over.set()

        start(report)
        over.wait()
        if int(last[0]) == 1:  # SUCCESS, in every plug-in
            progress.update(task, completed=1.0)
    return last[0]
