"""LOG_REQUEST_*: lists the runs, and sends one file of each: its ULog, or its .tlog where it has no ULog.

Source: MAVLink guide, log messages. Logs are numbered from 0, for clients with the ardupilot persona from 1; numbers
stay the same until the list is requested again.

QGroundControl requests 512 blocks of 90 bytes at a time, and then what is missing; MAVSDK requests 128. MAVProxy
requests all, and expects an empty block after a file that ends with a full block.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, TypeVar

from companion.core.decision import TextKind
from companion.io.mavlink.transfer.disk_files import DiskFile, LogStore, Run, abandon
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.io.mavlink.wire.yielding import to_yield
from companion.loop import Vessel

BLOCK = 90
_ALL = 0xFFFFFFFF
_MOST_CLIENTS = 8
_SHARE = 0.5  # of the line
_FRAME_BYTES = 97 + 14
_SAVED_S = 0.25
_IDLE_S = 60.0
_YIELD_S = 5.0  # a client that was sent nothing for so long makes room for another one
_MOST_RUNS = 1000  # the newest of them

T = TypeVar("T")


@dataclass(slots=True)
class _LogClient:
    """`used_s`, `sent_s`: when it last asked for something, or was sent it. `runs`: as last listed. `sending`: (next
    offset, end) of the data requested."""

    used_s: float
    sent_s: float
    runs: list[Run] | None = None
    asked: tuple[int, int] | None = None  # (first, last) of a list request that waits for the disk
    wanted: Any = None  # a LOG_REQUEST_DATA that waits for the list
    listing: Future[list[Run]] | None = None
    number: int | None = None
    file: DiskFile | None = None
    opening: Future[DiskFile | None] | None = None
    sending: tuple[int, int] | None = None
    to_the_end: bool = False  # all was requested: an empty block marks the end after a full block
    allowance: float = 0.0
    allowed_s: float | None = None


class LogService:
    """Answers LOG_REQUEST_LIST, LOG_REQUEST_DATA and LOG_REQUEST_END with LOG_ENTRY and LOG_DATA. LOG_ERASE deletes the
    logs of earlier runs, while disarmed.

    Remembers each client's list, its open file, and how far that was sent.
    """

    def __init__(self, hub: Hub, vessel: Vessel, store: LogStore | None) -> None:
        """`store`: the log folders; None where nothing is logged."""
        self._hub = hub
        self._vessel = vessel
        self._store = store
        self._erasing: Future[tuple[int, int]] | None = None
        self._clients: dict[Peer, _LogClient] = {}
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_LIST: self._on_list,
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_DATA: self._on_data,
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_END: self._on_end,
            mavlink.MAVLINK_MSG_ID_LOG_ERASE: self._on_erase,
        }

    def update(self, now_s: float) -> None:
        """Continue all transfers, and announce that logs are erased."""
        if self._erasing is not None and self._erasing.done():
            count, size = _result(self._erasing) or (0, 0)
            self._erasing = None
            self._vessel.events.say(
                now_s, TextKind.ROUTINE, "logs_erased", f"Logs erased: {count}, {size / 1e6:.0f} MB"
            )
        for peer, client in list(self._clients.items()):
            if peer.endpoint.gone or now_s - client.used_s > _IDLE_S * self._hub.patience:
                self._forget(peer)
                continue
            self._advance(peer, client, now_s)

    def close(self) -> None:
        """Close all open files."""
        for peer in list(self._clients):
            self._forget(peer)
        if self._store is not None:
            self._store.close()

    def _on_list(self, message: Any, peer: Peer, now_s: float) -> None:
        client = self._client(peer, now_s)
        if client is None:
            return
        client.asked = (message.start, message.end)
        client.sending = client.wanted = None
        self._close_file(client)
        if self._store is not None:
            client.listing = client.listing or self._store.runs(_MOST_RUNS)
        else:
            client.runs = []
        self._advance(peer, client, now_s)

    def _on_data(self, message: Any, peer: Peer, now_s: float) -> None:
        client = self._client(peer, now_s)
        if client is None or self._store is None:
            return
        client.wanted = message
        if client.runs is None and client.listing is None:
            client.listing = self._store.runs(_MOST_RUNS)
        self._advance(peer, client, now_s)

    def _begin(self, peer: Peer, client: _LogClient, store: LogStore, runs: list[Run], message: Any) -> None:
        """Begin to send the data that a LOG_REQUEST_DATA asks for."""
        index = message.id - peer.endpoint.persona.first_item
        if not 0 <= index < len(runs):
            self._hub.say(peer, TextKind.REFUSAL, f"Log {message.id} not found: request the list again")
            return
        if client.number != message.id:
            self._close_file(client)
            client.number = message.id
            client.opening = store.open(runs[index].path)
        size = runs[index].size
        end = size if message.count == _ALL else min(size, message.ofs + message.count)
        client.to_the_end = message.count == _ALL
        client.sending = (message.ofs, end) if message.ofs < size else None
        if client.sending is None and client.to_the_end:
            self._send(peer, client, message.ofs, b"")

    def _on_end(self, message: Any, peer: Peer, now_s: float) -> None:
        client = self._clients.get(peer)
        if client is not None:
            client.sending = client.wanted = None
            self._close_file(client)

    def _on_erase(self, message: Any, peer: Peer, now_s: float) -> None:
        """Who downloads goes on with the file that is open; of a log that is gone the client is told so."""
        if self._store is None:
            self._hub.say(peer, TextKind.REFUSAL, "Logs not erased: nothing is logged here")
        elif self._vessel.supervisor.status(now_s).armed:
            self._hub.say(peer, TextKind.REFUSAL, "Logs not erased: disarm first")
        elif self._erasing is None:
            self._erasing = self._store.erase()

    # --- steps -----------------------------------------------------------------------------------------------------

    def _advance(self, peer: Peer, client: _LogClient, now_s: float) -> None:
        """Continue one client's transfer with what the disk has delivered."""
        if client.listing is not None and client.listing.done():
            client.runs, client.listing = _result(client.listing) or [], None
        if client.asked is not None and client.runs is not None and client.listing is None:
            self._send_list(peer, client.runs, *client.asked)
            client.asked = None
        if client.wanted is not None and client.runs is not None and client.listing is None and self._store is not None:
            message, client.wanted = client.wanted, None
            self._begin(peer, client, self._store, client.runs, message)
        if client.opening is not None and client.opening.done():
            client.file, client.opening = _result(client.opening), None
            if client.file is None:
                client.sending = client.number = None
                self._hub.say(peer, TextKind.REFUSAL, "Log no longer there: request the list again")
        if client.file is not None and client.sending is not None:
            self._stream(peer, client, client.file, now_s)

    def _send_list(self, peer: Peer, runs: list[Run], start: int, end: int) -> None:
        """One LOG_ENTRY for each run; a single empty one where there is none."""
        first = peer.endpoint.persona.first_item
        if not runs:
            self._hub.send(peer, mavlink.MAVLink_log_entry_message(0, 0, 0, 0, 0))
        last = first + len(runs) - 1
        for number, run in enumerate(runs, first):
            if start <= number <= end:
                self._hub.send(
                    peer,
                    mavlink.MAVLink_log_entry_message(number, len(runs), last, run.begun_unix_s, min(run.size, _ALL)),
                )

    def _stream(self, peer: Peer, client: _LogClient, file: DiskFile, now_s: float) -> None:
        """Send as many blocks as the line has room for."""
        rate = _SHARE * peer.endpoint.bytes_per_s
        elapsed_s = _SAVED_S if client.allowed_s is None else max(0.0, now_s - client.allowed_s)
        client.allowed_s = now_s
        client.allowance = min(max(_SAVED_S * rate, 2.0 * _FRAME_BYTES), client.allowance + elapsed_s * rate)
        while client.sending is not None and client.allowance >= _FRAME_BYTES and not peer.endpoint.busy:
            offset, end = client.sending
            try:
                data = file.read(offset, min(BLOCK, end - offset))
            except OSError as error:
                client.sending = None
                self._hub.say(peer, TextKind.REFUSAL, f"Log not readable: {error.strerror or error}")
                return
            if data is None:
                return
            self._send(peer, client, offset, data)
            client.used_s = client.sent_s = now_s
            client.allowance -= _FRAME_BYTES
            offset += len(data)
            client.sending = (offset, end) if data and offset < end else None
            if client.sending is None and client.to_the_end and len(data) == BLOCK:
                self._send(peer, client, offset, b"")

    def _send(self, peer: Peer, client: _LogClient, offset: int, data: bytes) -> None:
        number = client.number if client.number is not None else 0
        self._hub.send(peer, mavlink.MAVLink_log_data_message(number, offset, len(data), data.ljust(BLOCK, b"\0")))

    # --- clients ---------------------------------------------------------------------------------------------------

    def _client(self, peer: Peer, now_s: float) -> _LogClient | None:
        """The client, added where it is new; None where there are too many."""
        client = self._clients.get(peer)
        if client is None:
            if len(self._clients) >= _MOST_CLIENTS and not self._makes_room(peer, now_s):
                self._hub.say(peer, TextKind.REFUSAL, "Log refused: too many clients fetch logs")
                return None
            client = self._clients[peer] = _LogClient(now_s, now_s)
        client.used_s = now_s
        return client

    def _makes_room(self, newcomer: Peer, now_s: float) -> bool:
        """Whether a client that makes no use of its place leaves it."""
        held = {peer: (peer.endpoint, client.sent_s) for peer, client in self._clients.items()}
        leaves = to_yield(held, newcomer.endpoint, now_s, _YIELD_S * self._hub.patience)
        if leaves is not None:
            self._forget(leaves)
        return leaves is not None

    def _forget(self, peer: Peer) -> None:
        client = self._clients.pop(peer)
        self._close_file(client)
        if client.listing is not None:
            client.listing.cancel()

    @staticmethod
    def _close_file(client: _LogClient) -> None:
        if client.file is not None:
            client.file.close()
        if client.opening is not None:
            abandon(client.opening)
        client.file = client.opening = client.number = None


def _result(done: Future[T]) -> T | None:
    """What the disk delivered; None where it failed."""
    try:
        return done.result()
    except OSError:
        return None
