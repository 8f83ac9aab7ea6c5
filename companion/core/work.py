"""Work that may be done beside the control thread, or at once."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from enum import Enum
from typing import Any, Generic, TypeVar

T = TypeVar("T")

Submit = Callable[[Callable[[], Any]], "Future[Any]"]
"""How work is given away: `Worker.submit`."""


class Lane(Enum):
    """The threads that compute. Some things serve one thread at a time, so each lane has its own of them."""

    CONTROL = "control"
    USUAL = "usual"  # work that nobody waits for
    URGENT = "urgent"  # work that the boat waits for


def at_once(work: Callable[[], T]) -> Future[T]:
    """Carry it out now; the future is done."""
    future: Future[T] = Future()
    settle(future, work)
    return future


class AtOnce:
    """The `Worker` where nothing runs beside the control thread, as in lockstep."""

    def submit(self, work: Callable[[], T], urgent: bool = False) -> Future[T]:
        """As `at_once`."""
        return at_once(work)


class Job(Generic[T]):
    """`begin(work)`; then `take()` once it is `done`. Remembers the work under way.

    `work` uses nothing that may change meanwhile. Who begins it judges whether the result still fits.
    """

    def __init__(self, submit: Submit) -> None:
        self._submit = submit
        self._future: Future[T] | None = None

    @property
    def pending(self) -> bool:
        """Whether work was begun whose result nobody took."""
        return self._future is not None

    @property
    def done(self) -> bool:
        """Whether there is a result to take."""
        return self._future is not None and self._future.done()

    def begin(self, work: Callable[[], T]) -> None:
        """Do something else; what was begun before is given up."""
        self.drop()
        self._future = self._submit(work)

    def take(self) -> T:
        """The result. Raises what the work raised, and RuntimeError where there is none."""
        future, self._future = self._future, None
        if future is None:
            raise RuntimeError("Job.take before begin")
        return future.result()

    def drop(self) -> None:
        """Give it up."""
        if self._future is not None:
            self._future.cancel()
            self._future = None


def settle(future: Future[T], work: Callable[[], T]) -> None:
    """Carry out `work`, and put its result or its exception into the future."""
    try:
        result = work()
    except Exception as error:  # noqa: BLE001  it is raised again where the result is asked for
        future.set_exception(error)
    else:
        future.set_result(result)
