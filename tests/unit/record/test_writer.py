"""Small files beside the control thread: the newest content of each, in the end, whatever the medium does meanwhile."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.core.storing import Stored
from companion.record.writer import Access, DirectWriter, ThreadWriter
from tests.faulty_disk import FaultyDisk
from tests.waiting import wait_until


class Kept:
    """A thread writer on a faulty disk."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.disk, self.settled = folder, FaultyDisk(), 0
        self.writer = ThreadWriter(folder, self._settle, self.disk, retry_s=0.001)

    def _settle(self) -> None:
        self.settled += 1

    def content(self, name: str) -> bytes | None:
        path = self.folder / name
        return path.read_bytes() if path.exists() else None


@pytest.fixture
def kept(tmp_path: Path) -> Iterator[Kept]:
    made = Kept(tmp_path)
    yield made
    made.disk.go_on()
    made.disk.fail_with(None)
    made.writer.close()


def test_a_stalled_medium_holds_nobody_up_and_gets_the_newest_content(kept: Kept) -> None:
    kept.disk.stall()
    first = kept.writer.submit("a", lambda: b"0")
    kept.disk.wait_for_stall()
    tickets = [kept.writer.submit("a", lambda n=n: b"%d" % n) for n in range(1, 100)]
    other = kept.writer.submit("b", lambda: b"other")
    assert first.pending and other.pending and all(ticket is tickets[0] for ticket in tickets), "one waits, for all"
    assert kept.writer.at_work is not None
    kept.disk.go_on()
    wait_until(lambda: first.durable and tickets[0].durable and other.durable, "all to be stored")
    assert kept.content("a") == b"99" and kept.disk.replaced == ["a", "a", "b"]
    wait_until(lambda: kept.settled == 3, "to be told of each")


def test_what_fails_is_told_at_once_and_stored_when_the_medium_is_back(kept: Kept) -> None:
    kept.writer.submit("a", lambda: b"old")
    wait_until(lambda: kept.content("a") == b"old", "the old content")
    kept.disk.fail_with(errno.ENOSPC)
    ticket = kept.writer.submit("a", lambda: b"new")
    wait_until(lambda: ticket.state is Stored.FAILED, "the failure")
    assert ticket.full and "No space left" in ticket.reason and kept.content("a") == b"old"
    assert "a not saved: No space left" in kept.writer.failing
    settled = kept.settled
    wait_until(lambda: kept.settled > settled + 3, "some more attempts")
    (news,) = kept.writer.news()
    assert "No space left" in news.text and not news.good, "told once"
    kept.disk.fail_with(None)
    wait_until(lambda: ticket.durable, "the next attempt")
    (news,) = kept.writer.news()
    assert news.good and kept.content("a") == b"new" and kept.writer.failing == ""


def test_a_newer_content_takes_the_place_of_one_that_failed(kept: Kept) -> None:
    kept.disk.fail_with(errno.EIO)
    failed = kept.writer.submit("a", lambda: b"failed")
    wait_until(lambda: failed.state is Stored.FAILED, "the failure")
    kept.disk.fail_with(None)
    newer = kept.writer.submit("a", lambda: b"newer")
    wait_until(lambda: newer.durable, "the newer content")
    kept.writer.close()
    assert kept.content("a") == b"newer" and not failed.full


def test_a_content_that_cannot_be_made_does_not_stop_the_others(kept: Kept) -> None:
    def broken() -> bytes:
        raise RecursionError("too deep")

    bad, good = kept.writer.submit("bad", broken), kept.writer.submit("good", lambda: b"good")
    wait_until(lambda: good.durable, "the good file")
    assert bad.state is Stored.FAILED and "too deep" in bad.reason


def test_closing_writes_what_waits_and_tries_once_more_what_failed(tmp_path: Path) -> None:
    disk = FaultyDisk()
    writer = ThreadWriter(tmp_path, lambda: None, disk, retry_s=1e6)
    disk.fail_with(errno.ENOSPC)
    failed = writer.submit("a", lambda: b"a")
    wait_until(lambda: failed.state is Stored.FAILED, "the failure")
    disk.fail_with(None)
    waiting = writer.submit("b", lambda: b"b")
    writer.close()
    assert failed.durable and waiting.durable


def test_a_direct_writer_is_done_when_it_returns(tmp_path: Path) -> None:
    disk = FaultyDisk()
    writer = DirectWriter(tmp_path, disk)
    assert writer.submit("a", lambda: b"a", Access(0o600)).durable
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o600
    disk.fail_with()
    failed = writer.submit("a", lambda: b"newer")
    assert failed.state is Stored.FAILED and (tmp_path / "a").read_bytes() == b"a"
    writer.retry()
    assert failed.state is Stored.FAILED and len(writer.news()) == 1
    disk.fail_with(None)
    writer.retry()
    assert failed.durable and (tmp_path / "a").read_bytes() == b"newer"


def test_a_directory_that_was_removed_is_made_again_with_all_that_was_in_it(tmp_path: Path) -> None:
    state = tmp_path / "state"
    state.mkdir()
    writer = DirectWriter(state)
    writer.known("loaded", b"1")
    writer.submit("saved", lambda: b"2")
    shutil.rmtree(state)
    assert writer.submit("new", lambda: b"3").durable
    writer.retry()
    assert {path.name: path.read_bytes() for path in state.iterdir()} == {"loaded": b"1", "saved": b"2", "new": b"3"}
    (news,) = writer.news()
    assert "was removed" in news.text and not news.good and writer.failing == ""


def test_a_medium_that_was_taken_out_is_not_replaced_by_a_folder_elsewhere(tmp_path: Path) -> None:
    writer = DirectWriter(tmp_path / "card" / "state")
    assert writer.submit("a", lambda: b"a").state is Stored.FAILED and not (tmp_path / "card").exists()
    (tmp_path / "card").mkdir()
    writer.retry()
    assert (tmp_path / "card" / "state" / "a").read_bytes() == b"a"
