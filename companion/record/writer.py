"""Writes the small files of the state directory: the newest content of each, as soon as the medium takes it.

Who submits a content gets a `Ticket` at once, and asks it later whether the content is durable. Of a file that waits,
only the newest content is written. A content that could not be written is tried again until it is, or until a newer
one replaces it. So the queue never holds more than one content a file. A directory that somebody removes is made again
with the next write, and all files in it.
"""

from __future__ import annotations

import errno
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from companion.core.storing import Stored, Ticket
from companion.record.disk import REAL_DISK, Disk, Owner

RETRY_S = 2.0
_CLOSING_S = 10.0  # for the last writes to a medium that answers no more
_FULL = (errno.ENOSPC, errno.EDQUOT)


@dataclass(frozen=True, slots=True)
class Access:
    """Who may read a file. `owner`: None for that of the process."""

    mode: int = 0o644
    owner: Owner | None = None


USUAL = Access()


@dataclass(frozen=True, slots=True)
class News:
    """What to tell people: one line, and whether it is good."""

    text: str
    good: bool


@dataclass(frozen=True, slots=True)
class _Job:
    content: Callable[[], bytes]
    access: Access
    ticket: Ticket = field(default_factory=Ticket)


class Writer(Protocol):
    """Stores files by name."""

    def submit(self, name: str, content: Callable[[], bytes], access: Access = USUAL) -> Ticket:
        """Store what `content` returns under that name. It is called where the file is written, so it must not use
        what may change meanwhile."""
        ...

    def known(self, name: str, content: bytes) -> None:
        """That file has this content already."""
        ...

    def retry(self) -> None:
        """Time has passed: try again what failed."""
        ...

    def news(self) -> list[News]:
        """What has failed, or works again, since the last call."""
        ...

    @property
    def failing(self) -> str:
        """Why a file has its old content now; empty while all are stored."""
        ...

    @property
    def at_work(self) -> object | None:
        """Something that changes with each file that is written; None while nothing is."""
        ...

    def close(self) -> None:
        """Write what waits, and try once more what failed."""
        ...


class _Attempts:
    """Writes files, and remembers which of them failed and why."""

    def __init__(self, directory: Path, disk: Disk) -> None:
        self._directory = directory
        self._disk = disk
        self.owed: dict[str, _Job] = {}  # failed, the longest ago first
        self.stored: dict[str, _Job] = {}  # what the medium has, by file
        self._why: dict[str, str] = {}
        self._news: deque[News] = deque(maxlen=64)

    def attempt(self, name: str, job: _Job) -> bool:
        """Write one file; returns whether it is stored."""
        try:
            self._store(name, job)
        except OSError as error:
            return self._failed(name, job, error.strerror or str(error), error.errno in _FULL)
        except Exception as error:  # noqa: BLE001  whatever is wrong with one file, the others are written
            return self._failed(name, job, str(error), False)
        self.owed.pop(name, None)
        self.stored[name] = job
        if self._why.pop(name, None) is not None:
            self._news.append(News(f"{self._directory / name} is saved again", good=True))
        job.ticket.state = Stored.DURABLE
        return True

    def _store(self, name: str, job: _Job) -> None:
        """Replace the file. Raises OSError."""
        content = job.content()
        try:
            self._disk.replace(self._directory, name, content, job.access.mode, job.access.owner)
        except FileNotFoundError:
            if self._directory.exists():
                raise
            self._directory.mkdir()
            text = f"{self._directory} was removed; it is made again, and all that was in it is stored again"
            self._news.append(News(text, good=False))
            for other, stored in self.stored.items():
                self.owed.setdefault(other, stored)
            self._disk.replace(self._directory, name, content, job.access.mode, job.access.owner)

    def _failed(self, name: str, job: _Job, reason: str, full: bool) -> bool:
        self.owed.pop(name, None)
        self.owed[name] = job
        if self._why.get(name) != reason:
            text = f"{self._directory / name} not saved: {reason}; it keeps its old content for now"
            self._news.append(News(text, good=False))
        self._why[name] = reason
        job.ticket.reason, job.ticket.full = reason, full
        job.ticket.state = Stored.FAILED
        return False

    def news(self) -> list[News]:
        """As `Writer.news`."""
        return [self._news.popleft() for _ in range(len(self._news))]

    @property
    def failing(self) -> str:
        """As `Writer.failing`."""
        return "; ".join(f"{name} not saved: {why}" for name, why in sorted(self._why.copy().items()))


class DirectWriter:
    """A `Writer` that writes at once, in the caller's thread: for lockstep, and for commands without a loop."""

    def __init__(self, directory: Path, disk: Disk = REAL_DISK) -> None:
        self._attempts = _Attempts(directory, disk)

    def submit(self, name: str, content: Callable[[], bytes], access: Access = USUAL) -> Ticket:
        """As `Writer.submit`; the ticket is settled."""
        job = _Job(content, access)
        self._attempts.attempt(name, job)
        return job.ticket

    def known(self, name: str, content: bytes) -> None:
        """As `Writer.known`."""
        self._attempts.stored[name] = _Job(lambda: content, USUAL)

    def retry(self) -> None:
        """As `Writer.retry`."""
        for name, job in list(self._attempts.owed.items()):
            self._attempts.attempt(name, job)

    def news(self) -> list[News]:
        """As `Writer.news`."""
        return self._attempts.news()

    @property
    def failing(self) -> str:
        """As `Writer.failing`."""
        return self._attempts.failing

    @property
    def at_work(self) -> object | None:
        """None: nothing is ever under way."""
        return None

    def close(self) -> None:
        """As `Writer.close`."""
        self.retry()


class ThreadWriter:
    """A `Writer` with a thread of its own: `submit` returns at once, whatever the medium does. Calls `settled` after
    each attempt."""

    def __init__(
        self, directory: Path, settled: Callable[[], None], disk: Disk = REAL_DISK, retry_s: float = RETRY_S
    ) -> None:
        self._attempts = _Attempts(directory, disk)
        self._settled = settled
        self._retry_s = retry_s
        self._wake = threading.Condition()
        self._waiting: dict[str, _Job] = {}
        self._at_work: _Job | None = None
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="state-writer", daemon=True)
        self._thread.start()

    def submit(self, name: str, content: Callable[[], bytes], access: Access = USUAL) -> Ticket:
        """As `Writer.submit`. The ticket of an older content that still waits serves for the newer one."""
        with self._wake:
            older = self._waiting.get(name)
            job = _Job(content, access) if older is None else _Job(content, access, older.ticket)
            self._waiting[name] = job
            self._wake.notify()
        return job.ticket

    def known(self, name: str, content: bytes) -> None:
        """As `Writer.known`."""
        self._attempts.stored[name] = _Job(lambda: content, USUAL)

    def retry(self) -> None:
        """Nothing: the thread tries again by itself."""

    def news(self) -> list[News]:
        """As `Writer.news`."""
        return self._attempts.news()

    @property
    def failing(self) -> str:
        """As `Writer.failing`."""
        return self._attempts.failing

    @property
    def at_work(self) -> object | None:
        """As `Writer.at_work`."""
        return self._at_work

    def close(self) -> None:
        """As `Writer.close`. Gives up on a medium that does not answer."""
        with self._wake:
            self._closed = True
            self._wake.notify()
        self._thread.join(_CLOSING_S)

    def _run(self) -> None:
        while (found := self._next()) is not None:
            name, self._at_work = found
            self._attempts.attempt(name, self._at_work)
            self._at_work = None
            self._settled()
        for name, job in list(self._attempts.owed.items()):
            self._attempts.attempt(name, job)

    def _next(self) -> tuple[str, _Job] | None:
        """What to write next: what waits, else what failed, the longest ago first; None when closed."""
        with self._wake:
            owed = self._attempts.owed
            self._wake.wait_for(lambda: self._waiting or self._closed, self._retry_s if owed else None)
            if self._waiting:
                name = next(iter(self._waiting))
                return name, self._waiting.pop(name)
            return None if self._closed else next(iter(owed.items()))
