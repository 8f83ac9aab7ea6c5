"""Work beside the control thread."""

from __future__ import annotations

import select
import threading
from collections.abc import Iterator

import pytest

from companion.beside import Bell, ThreadWorker

LONG_S = 30.0


@pytest.fixture
def worker() -> Iterator[ThreadWorker]:
    bell = Bell()
    made = ThreadWorker(bell)
    yield made
    made.close()
    bell.close()


def test_urgent_work_passes_what_is_under_way(worker: ThreadWorker) -> None:
    """A large upload must not delay the way of a failsafe's RTL."""
    let_go = threading.Event()
    upload = worker.submit(lambda: let_go.wait(LONG_S))
    waits = worker.submit(lambda: "listing")
    way = worker.submit(lambda: "way", urgent=True)
    assert way.result(LONG_S) == "way"
    assert not upload.done() and not waits.done()
    let_go.set()
    assert waits.result(LONG_S) == "listing" and upload.result() is True


def test_work_is_done_in_order(worker: ThreadWorker) -> None:
    done: list[int] = []
    jobs = [worker.submit(lambda n=n: done.append(n)) for n in range(20)]
    for job in jobs:
        job.result(LONG_S)
    assert done == list(range(20))


def test_a_failure_is_told_where_the_result_is_asked_for(worker: ThreadWorker) -> None:
    def fails() -> None:
        raise ArithmeticError("no such way")

    with pytest.raises(ArithmeticError):
        worker.submit(fails, urgent=True).result(LONG_S)
    assert worker.submit(lambda: 1, urgent=True).result(LONG_S) == 1


def test_each_piece_of_work_rings_the_bell() -> None:
    bell = Bell()
    worker = ThreadWorker(bell)
    for urgent in (False, True):
        worker.submit(lambda: None, urgent).result(LONG_S)
        assert select.select([bell], [], [], LONG_S)[0]
        bell.silence()
    worker.close()
    bell.close()
