"""Work that may be done beside the control thread, or at once."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

T = TypeVar("T")


class AtOnce:
    """The `Worker` where nothing runs beside the control thread, as in lockstep."""

    def submit(self, work: Callable[[], T]) -> Future[T]:
        """Carry it out now; the future is done."""
        future: Future[T] = Future()
        settle(future, work)
        return future


def settle(future: Future[T], work: Callable[[], T]) -> None:
    """Carry out `work`, and put its result or its exception into the future."""
    try:
        result = work()
    except Exception as error:  # noqa: BLE001  it is raised again where the result is asked for
        future.set_exception(error)
    else:
        future.set_result(result)
